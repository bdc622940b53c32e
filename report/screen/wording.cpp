#include "kinetostat/report/screen/wording.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <sstream>

#include <fmt/format.h>

#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

// Characters, not bytes: continuation bytes of UTF-8 take no room.
std::size_t columns_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
  }));
}

// Where an element is: which chains have it, and whether it is a joint.
struct Place {
  std::size_t chains = 0;
  bool is_joint = false;
};

bool is_of(const std::string& coordinate, const std::string& element) {
  return coordinate == element || coordinate.starts_with(element + ".");
}

Place place_of(const vjm::Manipulator& manipulator, const std::string& element) {
  Place place;
  for (const vjm::Chain& chain : manipulator.chains()) {
    bool here = false;
    for (const vjm::Coordinate& c : chain.coordinates())
      if (is_of(c.name, element)) {
        here = true;
        place.is_joint = place.is_joint || c.role != vjm::Role::elastic;
      }
    for (const vjm::Node& node : chain.nodes()) here = here || is_of(node.name, element);
    place.chains += here ? 1 : 0;
  }
  return place;
}

// "x.rho" into chain and element; the chain is empty where none is named.
std::pair<std::string, std::string> parts_of(const vjm::Manipulator& manipulator,
                                             const std::string& at) {
  for (const vjm::Chain& chain : manipulator.chains())
    if (at.starts_with(chain.name() + "."))
      return {chain.name(), at.substr(chain.name().size() + 1)};
  return {"", at};
}

bool is_no_element(const std::string& at) {
  return at == "platform" || at == "load" || at == "sensor" || at == "all parts";
}

// The decimal place at which a deviation has its first digit, or its second where the first is 1.
int decimals_for(double deviation) {
  const double magnitude = std::floor(std::log10(deviation));
  const double leading = std::round(deviation / std::pow(10.0, magnitude));
  return static_cast<int>(leading < 2 ? 1 - magnitude : -magnitude);
}

std::string rounded(double value, int decimals) {
  if (decimals > 0) return fmt::format("{:.{}f}", value, decimals);
  const double unit = std::pow(10.0, -decimals);
  return fmt::format("{:.0f}", std::round(value / unit) * unit);
}

std::string with_commas(double value) {
  std::string digits = fmt::format("{:.0f}", value);
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, ",");
  return digits;
}

// What stands in one line each: words, and a number with its percent sign.
std::vector<std::string> unbroken(const std::string& text) {
  std::istringstream words(text);
  std::vector<std::string> result;
  for (std::string word; words >> word;)
    if (word.front() == '%' && !result.empty())
      result.back() += " " + word;
    else
      result.push_back(word);
  return result;
}

}  // namespace

std::string wrapped(const std::string& text, std::size_t first, std::size_t rest) {
  std::string result, line(first, ' ');
  bool is_empty = true;
  for (const std::string& word : unbroken(text)) {
    if (!is_empty && columns_of(line) + 1 + columns_of(word) > screen_columns) {
      result += line + "\n";
      line = std::string(rest, ' ');
      is_empty = true;
    }
    line += (is_empty ? "" : " ") + word;
    is_empty = false;
  }
  return is_empty ? result : result + line + "\n";
}

std::string wrapped_lines(const std::string& text) {
  std::istringstream lines(text);
  std::string result;
  for (std::string line; std::getline(lines, line);)
    result += columns_of(line) <= screen_columns ? line + "\n" : wrapped(line, 0, 2);
  return result;
}

std::string labelled(const std::string& label, std::size_t width, const std::string& text) {
  std::string lines = wrapped(text, width + 2, width + 2);
  const std::size_t size = columns_of(label);
  if (lines.empty()) return "  " + label + "\n";
  if (size >= width) return "  " + label + "\n" + lines;
  return "  " + label + std::string(width - size, ' ') + lines.substr(width + 2);
}

std::string listed(const std::vector<std::string>& words, const std::string& last) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " " + last + " " : ", ") + words[i];
  return text;
}

std::string capitalised(std::string text) {
  if (!text.empty())
    text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

std::string times(double error) {
  if (!std::isfinite(error)) return "infinitely many";
  if (error < 9.995) return fmt::format("{:.2f}", error);
  if (error < 99.95) return fmt::format("{:.1f}", error);
  return error < 1e6 ? fmt::format("{:.0f}", error) : number(error, 3);
}

std::string with_error(double value, double deviation) {
  if (!std::isfinite(deviation) || deviation <= 0) return number(value, 4);
  const double size = std::max(std::abs(value), deviation);
  if (size >= 1e6 || size < 1e-3) {  // a power of ten before both
    const double power = std::pow(10.0, std::floor(std::log10(size)));
    return fmt::format("({})e{:+03d}", with_error(value / power, deviation / power),
                       static_cast<int>(std::floor(std::log10(size))));
  }
  const int decimals = std::min(decimals_for(deviation), 9);
  return rounded(value, decimals) + " +- " + rounded(deviation, decimals);
}

std::string change(double factor, double deviation) {
  const double percent = 100 * (factor - 1);
  if (std::abs(percent) >= 1000) return fmt::format("times {}", number(factor, 3));
  const int decimals = std::max(0, std::min(decimals_for(std::max(100 * deviation, 0.01)), 2));
  return fmt::format("{}{} % +- {}", percent < 0 ? "" : "+", rounded(percent, decimals),
                     rounded(100 * deviation, decimals));
}

std::string figure(double value, int digits) {
  const double size = std::abs(value);
  if (!(size >= 999.5) || size >= 1e7) return number(value, digits);
  const double unit = std::pow(10.0, std::floor(std::log10(size)) - digits + 1);
  const double rounded_size = std::round(size / unit) * unit;
  return (value < 0 ? "-" : "") +
         (rounded_size < 1e4 ? fmt::format("{:.0f}", rounded_size) : with_commas(rounded_size));
}

std::string short_percent(double share) {
  if (share > 0.999) return "over 99.9 %";
  if (share >= 0.995) return fmt::format("{:.1f} %", 100 * share);
  if (share >= 0.1) return fmt::format("{:.0f} %", 100 * share);
  return percent(share);
}

std::string odds(double probability) {
  constexpr double least = 1e-12;
  if (!(probability > least)) return "below 1 : 10^12";
  const double against = 1 / probability - 1;
  const double unit = std::pow(10.0, std::floor(std::log10(std::max(against, 1.0))) - 1);
  return "1 : " +
         with_commas(against >= 10 ? std::round(against / unit) * unit : std::round(against));
}

std::string chance(double p_value) {
  if (p_value < 1e-8) return "below 1e-8";
  return p_value < 1e-3 ? number(p_value, 1) : short_percent(p_value);
}

std::string minutes(double minutes) {
  if (minutes < 1) return fmt::format("{:.0f} s", 60 * minutes);
  return minutes < 10 ? fmt::format("{:.3g} min", minutes) : fmt::format("{:.0f} min", minutes);
}

namespace {

// "tilt at base.Rx", by which a mount yields: "tilt Rx at the base".
std::optional<std::string> mount_in_words(const vjm::Manipulator& manipulator,
                                          const std::string& at) {
  const auto [chain, element] = parts_of(manipulator, at);
  for (const std::string place : {"base", "end"}) {
    const std::size_t found = element.find(" at " + place + ".");
    if (found == std::string::npos) continue;
    const bool is_shared = chain == "foundation" || chain == "tool";
    const std::string where = is_shared ? chain : chain.empty() ? place : chain + "." + place;
    return fmt::format("{} {} at {}", element.substr(0, found),
                       element.substr(element.rfind('.') + 1), place_in_words(manipulator, where));
  }
  return std::nullopt;
}

}  // namespace

std::string place_in_words(const vjm::Manipulator& manipulator, const std::string& at) {
  if (is_no_element(at)) return at;
  if (const auto mount = mount_in_words(manipulator, at)) return *mount;
  for (const vjm::ElasticBody& body : manipulator.elastic_bodies())
    if (body.name == at) return "elastic body " + at;
  const auto [chain, element] = parts_of(manipulator, at);
  const bool is_one = manipulator.chains().size() == 1;
  if (element == "base" || element == "end")
    return is_one          ? "the " + element
           : chain.empty() ? "the " + element + " of every chain"
                           : "the " + element + " of chain " + chain;
  const Place place = place_of(manipulator, element);
  if (place.chains == 0 && at == "foundation") return "the foundation of all chains";
  if (place.chains == 0 && at == "tool") return "the tool on the platform";
  const std::string word = place.is_joint ? "joint " : "link ";
  if (place.chains <= 1) return word + element;
  return chain.empty() ? word + element + " of every chain" : word + chain + "." + element;
}

std::string short_name(const vjm::Manipulator& manipulator, const std::string& name) {
  const auto [chain, element] = parts_of(manipulator, name);
  return place_of(manipulator, element).chains > 1 ? name : element;
}

std::string effect_in_words(const vjm::Manipulator& manipulator, const std::string& kind,
                            const std::string& at) {
  std::string words = kind;
  std::replace(words.begin(), words.end(), '_', ' ');
  if (at == "load" || at == "sensor" || at.empty()) return words;
  const std::string place = place_in_words(manipulator, at);
  return place == "the base" && kind.starts_with("base_") ? words : words + " at " + place;
}

std::string length_unit_for(double length, const std::string& own) {
  constexpr double small = 1e-4;
  const bool is_metric = own == "m" || own == "cm" || own == "mm";
  return is_metric && length < small ? "um" : own;
}

std::string length_in_words(double length, const std::string& own) {
  const std::string unit = length_unit_for(length, own);
  return fmt::format("{} {}", number(length / spatial::parse_unit(unit).factor, 3), unit);
}

std::string unit_in_words(const std::string& unit) {
  std::istringstream tokens(unit);
  std::string above, below;
  std::size_t below_count = 0;
  for (std::string token; tokens >> token;) {
    const std::size_t power = token.find("^-");
    if (power == std::string::npos) {
      above += (above.empty() ? "" : " ") + token;
      continue;
    }
    const std::string exponent = token.substr(power + 2);
    below += (below.empty() ? "" : " ") + token.substr(0, power) +
             (exponent == "1" ? "" : "^" + exponent);
    ++below_count;
  }
  if (below.empty()) return above;
  return (above.empty() ? "1" : above) + "/" + (below_count > 1 ? "(" + below + ")" : below);
}

std::string bar(double share, std::size_t length) {
  const auto signs = static_cast<std::size_t>(std::clamp(
      std::round(share * static_cast<double>(length)), 1.0, static_cast<double>(length)));
  return std::string(signs, '#');
}

std::string next_step(const std::string& command, const std::string& why) {
  std::string first = "Next: ";
  std::size_t width = first.size();
  std::istringstream words(command);
  for (std::string word; words >> word; width += word.size() + 1) {
    const bool is_first = width == 6;
    if (!is_first && width + 3 + word.size() > screen_columns) {  // as a shell takes it
      first += " \\\n          ";
      width = 10;
    } else if (!is_first) {
      first += " ";
    }
    first += word;
  }
  if (why.empty()) return first + "\n";
  if (first.find('\n') == std::string::npos &&
      columns_of(first) + 4 + columns_of(why) <= screen_columns)
    return first + "    " + why + "\n";
  return first + "\n" + wrapped(why, 6, 6);
}

std::string quoted(const std::filesystem::path& file) {
  std::string text = file.string();
  const auto is_plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           std::string("/._-+:,=@%").find(c) != std::string::npos;
  };
  if (!text.empty() && std::all_of(text.begin(), text.end(), is_plain)) return text;
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

}  // namespace kinetostat::report

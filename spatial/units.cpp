#include "kinetostat/spatial/units.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

#include "kinetostat/common/spelling.h"

namespace kinetostat::spatial {
namespace {

struct NamedUnit {
  std::string_view symbol;
  Unit unit;
  bool takes_prefix;
};

constexpr double pi = 3.14159265358979323846;
constexpr double pound_force = 4.4482216152605;

const NamedUnit named_units[] = {
    {"m", {1, dimension::length}, true},
    {"g", {1e-3, dimension::mass}, true},
    {"s", {1, dimension::time}, true},
    {"K", {1, dimension::temperature}, true},
    {"rad", {1, dimension::angle}, true},
    {"N", {1, dimension::force}, true},
    {"Pa", {1, dimension::pressure}, true},
    {"J", {1, dimension::moment}, true},
    {"Hz", {1, {.time = -1}}, true},
    {"bar", {1e5, dimension::pressure}, true},
    {"t", {1e3, dimension::mass}, false},
    {"l", {1e-3, {.length = 3}}, true},
    {"min", {60, dimension::time}, false},
    {"h", {3600, dimension::time}, false},
    {"deg", {pi / 180, dimension::angle}, false},
    {"degree", {pi / 180, dimension::angle}, false},
    {"°", {pi / 180, dimension::angle}, false},
    {"gon", {pi / 200, dimension::angle}, false},
    {"arcmin", {pi / 180 / 60, dimension::angle}, false},
    {"arcsec", {pi / 180 / 3600, dimension::angle}, false},
    {"turn", {2 * pi, dimension::angle}, false},
    {"rev", {2 * pi, dimension::angle}, false},
    {"degC", {1, dimension::temperature}, false},
    {"°C", {1, dimension::temperature}, false},
    {"inch", {0.0254, dimension::length}, false},
    {"in", {0.0254, dimension::length}, false},
    {"ft", {0.3048, dimension::length}, false},
    {"mil", {25.4e-6, dimension::length}, false},
    {"thou", {25.4e-6, dimension::length}, false},
    {"lb", {0.45359237, dimension::mass}, false},
    {"lbs", {0.45359237, dimension::mass}, false},
    {"lbf", {pound_force, dimension::force}, false},
    {"kgf", {9.80665, dimension::force}, false},
    {"kp", {9.80665, dimension::force}, false},
    {"daN", {10, dimension::force}, false},
    {"psi", {pound_force / (0.0254 * 0.0254), dimension::pressure}, false},
    {"ksi", {1e3 * pound_force / (0.0254 * 0.0254), dimension::pressure}, false},
    {"%", {0.01, dimension::none}, false},
    {"percent", {0.01, dimension::none}, false},
    {"ppm", {1e-6, dimension::none}, false},
    {"1", {1, dimension::none}, false},
};

struct Prefix {
  std::string_view symbol;
  double factor;
};
const Prefix prefixes[] = {{"n", 1e-9}, {"u", 1e-6}, {"µ", 1e-6}, {"μ", 1e-6},
                           {"m", 1e-3}, {"c", 1e-2}, {"d", 1e-1}, {"h", 1e2},
                           {"k", 1e3},  {"M", 1e6},  {"G", 1e9}};

std::optional<Unit> find_unit(std::string_view symbol) {
  for (const NamedUnit& named : named_units)
    if (named.symbol == symbol) return named.unit;
  for (const Prefix& prefix : prefixes) {
    if (!symbol.starts_with(prefix.symbol)) continue;
    for (const NamedUnit& named : named_units)
      if (named.takes_prefix && symbol.substr(prefix.symbol.size()) == named.symbol)
        return Unit{prefix.factor * named.unit.factor, named.unit.dimension};
  }
  return std::nullopt;
}

// "Nm", "kNmm", "lbfin": a force and a length without anything between them.
std::optional<Unit> find_moment(std::string_view symbol) {
  for (std::size_t at = 1; at < symbol.size(); ++at) {
    const std::optional<Unit> force = find_unit(symbol.substr(0, at));
    if (!force || force->dimension != dimension::force) continue;
    const std::optional<Unit> length = find_unit(symbol.substr(at));
    if (length && length->dimension == dimension::length)
      return Unit{force->factor * length->factor, dimension::moment};
  }
  return std::nullopt;
}

Unit power(const Unit& unit, int exponent) {
  const Dimension& d = unit.dimension;
  return {std::pow(unit.factor, exponent),
          {d.length * exponent, d.mass * exponent, d.time * exponent, d.temperature * exponent,
           d.angle * exponent}};
}

// Never another quantity that differs in the case of a letter only: "NM" is no nanometre.
std::string nearest_unit(const std::string& symbol) {
  std::vector<std::string> candidates;
  std::string lower = symbol;
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (lower.ends_with("nm") && symbol.find('N') != std::string::npos)
    return lower.starts_with('k') ? "kNm" : "Nm";
  for (const NamedUnit& named : named_units) {
    candidates.emplace_back(named.symbol);
    if (!named.takes_prefix) continue;
    for (const Prefix& prefix : prefixes)
      candidates.push_back(std::string(prefix.symbol) + std::string(named.symbol));
  }
  return common::nearest_spelling(symbol, candidates);
}

// expression := factor (('*' | '.' | blank) factor | '/' quotient)*, quotient := factor (blank
// factor)*
class UnitParser {
 public:
  explicit UnitParser(std::string_view text) : text_(text) {}

  Unit parse() {
    const Unit unit = expression();
    skip_blanks();
    if (at_ < text_.size()) fail(fmt::format("'{}' is not expected here", text_.substr(at_)));
    if (!(unit.factor > 0) || !std::isfinite(unit.factor))
      fail("it is beyond the range of numbers");
    return unit;
  }

 private:
  Unit expression() {
    Unit unit = factor();
    while (true) {
      skip_blanks();
      if (take('/')) {
        const Unit divisor = product();
        unit = {unit.factor / divisor.factor, unit.dimension / divisor.dimension};
      } else if (take('*') || starts_factor()) {
        const Unit next = factor();
        unit = {unit.factor * next.factor, unit.dimension * next.dimension};
      } else {
        return unit;
      }
    }
  }

  // What a '/' divides by: factors up to the next '*', '/' or ')'.
  Unit product() {
    Unit unit = factor();
    for (skip_blanks(); starts_factor(); skip_blanks()) {
      const Unit next = factor();
      unit = {unit.factor * next.factor, unit.dimension * next.dimension};
    }
    return unit;
  }

  Unit factor() {
    skip_blanks();
    Unit unit;
    if (take('(')) {
      if (++depth_ > deepest) fail("it is nested too deeply");
      unit = expression();
      skip_blanks();
      if (!take(')')) fail("a ')' is missing");
      --depth_;
    } else {
      unit = symbol();
    }
    return power(unit, exponent_of(unit));
  }

  int exponent_of(const Unit& unit) {
    const int value = exponent();
    const Dimension& d = unit.dimension;
    for (const int own : {d.length, d.mass, d.time, d.temperature, d.angle})
      if (std::abs(own) > largest_exponent || std::abs(own * value) > largest_exponent)
        fail("its exponents are too large");
    return value;
  }

  Unit symbol() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && !is_operator(text_[at_]) && !is_digit(text_[at_]) &&
           !at_superscript() && !dot_here())
      ++at_;
    if (at_ == begin && take('1')) return {};
    const std::string name(text_.substr(begin, at_ - begin));
    if (name.empty()) fail("a unit is missing");
    std::optional<Unit> unit = find_unit(name);
    if (!unit) unit = find_moment(name);
    if (!unit) {
      const std::string near = nearest_unit(name);
      fail(fmt::format("'{}' is not a known unit{}", name,
                       near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near)));
    }
    return *unit;
  }

  int exponent() {
    if (const int power = at_superscript()) {
      at_ += std::string_view("²").size();
      return power;
    }
    const bool explicit_power = take('^') || (text_.substr(at_).starts_with("**") && (at_ += 2));
    if (!explicit_power && !(at_ < text_.size() && is_digit(text_[at_]))) return 1;
    int value = 0;
    const auto [end, error] =
        std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (error != std::errc() || value < -12 || value > 12)
      fail("a whole exponent is expected after '^'");
    at_ = static_cast<std::size_t>(end - text_.data());
    return value;
  }

  // 2 at "²", 3 at "³", otherwise 0.
  int at_superscript() const {
    const std::string_view rest = text_.substr(at_);
    return rest.starts_with("²") ? 2 : rest.starts_with("³") ? 3 : 0;
  }
  bool starts_factor() const {
    return at_ < text_.size() && text_[at_] != ')' && text_[at_] != '/' && text_[at_] != '*' &&
           text_[at_] != '^';
  }
  static bool is_digit(char c) { return c >= '0' && c <= '9'; }
  static bool is_operator(char c) {
    return c == '*' || c == '/' || c == '^' || c == '(' || c == ')' || c == ' ' || c == '\t' ||
           c == '.' || c == '-' || c == '+';
  }
  // What stands between factors: blanks, points, "N·m", and the hyphen of "ft-lbf".
  void skip_blanks() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (const std::size_t dot = dot_here())
        at_ += dot;
      else if (c == ' ' || c == '\t' || c == '.' || hyphen_here())
        ++at_;
      else
        return;
    }
  }
  std::size_t dot_here() const {
    for (const std::string_view dot : {"·", "⋅"})
      if (text_.substr(at_).starts_with(dot)) return dot.size();
    return 0;
  }
  bool hyphen_here() const {
    const auto is_letter = [this](std::size_t i) {
      return std::isalpha(static_cast<unsigned char>(text_[i])) != 0;
    };
    return at_ > 0 && at_ + 1 < text_.size() && text_[at_] == '-' && is_letter(at_ - 1) &&
           is_letter(at_ + 1);
  }
  bool take(char c) {
    if (at_ >= text_.size() || text_[at_] != c) return false;
    if (c == '*' && text_.substr(at_).starts_with("**")) return false;
    ++at_;
    return true;
  }
  [[noreturn]] void fail(const std::string& why) const {
    throw std::invalid_argument(fmt::format("unit '{}': {}", text_, why));
  }

  static constexpr int deepest = 20, largest_exponent = 100;

  std::string_view text_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front())))
    text.remove_prefix(1);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())))
    text.remove_suffix(1);
  return text;
}

bool fits(const Dimension& got, const Dimension& expected) {
  const auto is_plain_angle = [](Dimension d) {
    return d.angle != 0 && (d.angle = 0, d == dimension::none);
  };
  if (got == expected) return true;
  if (is_plain_angle(got) || is_plain_angle(expected)) return false;
  Dimension a = got, b = expected;
  a.angle = b.angle = 0;
  return a == b;
}

std::string example_units(const Dimension& expected) {
  struct Example {
    Dimension dimension;
    const char* text = "";
  };
  static const Example examples[] = {
      {dimension::length, "a length such as '15 um', '3 mm' or '0.2 m'"},
      {dimension::angle, "an angle such as '30 deg' or '0.5 rad'"},
      {dimension::force, "a force such as '120 N'"},
      {dimension::moment, "a moment such as '3.5 N m'"},
      {dimension::pressure, "a modulus or pressure such as '210 GPa'"},
      {dimension::density, "a density such as '2700 kg/m^3'"},
      {dimension::mass, "a mass such as '2.5 kg'"},
      {dimension::time, "a time such as '10 s'"},
      {dimension::temperature, "a temperature difference such as '5 K'"},
      {dimension::linear_stiffness, "a stiffness such as '1.0e5 N/mm'"},
      {dimension::torsional_stiffness, "a torsional stiffness such as '1.0e4 N m/rad'"},
      {dimension::area, "an area such as '144 mm^2'"},
      {dimension::second_moment, "a second moment of area such as '1650 mm^4'"},
      {dimension::none, "a plain number"},
  };
  for (const Example& example : examples)
    if (example.dimension == expected) return example.text;
  return "a quantity in " + to_string(expected);
}

bool starts_with_digit(std::string_view text) {
  return !text.empty() && text.front() >= '0' && text.front() <= '9';
}

// Takes the number off the front of `text`, which is part of `whole`.
double take_number(std::string_view& text, std::string_view whole, const Dimension& expected) {
  const auto fail = [&](const char* why) {
    throw std::invalid_argument(
        fmt::format("'{}' {}: expected {}", whole, why, example_units(expected)));
  };
  double value = 0;
  std::string_view digits = text;
  if (digits.starts_with('+') && !digits.starts_with("+-")) digits.remove_prefix(1);
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error == std::errc::result_out_of_range) fail("is too large or too small a number");
  if (error != std::errc() || std::isnan(value)) fail("does not start with a number");
  text = trimmed(std::string_view(end, static_cast<std::size_t>(text.data() + text.size() - end)));
  if (text.starts_with(',')) fail("has a comma in its number (write a decimal point)");
  // "1 000" is not one number; "3 1/s" is.
  if (starts_with_digit(text) && !trimmed(text.substr(1)).starts_with('/'))
    fail("holds more than one number");
  return value;
}

// Powers of ten below one are not exact in binary, their reciprocals are: dividing by these makes
// "15 um" the double that is nearest to 1.5e-5.
double to_si(double number, double factor) {
  const double divisor = std::round(1 / factor);
  return divisor > 1 && 1 / divisor == factor ? number / divisor : number * factor;
}

}  // namespace

Dimension operator*(const Dimension& a, const Dimension& b) {
  return {a.length + b.length, a.mass + b.mass, a.time + b.time, a.temperature + b.temperature,
          a.angle + b.angle};
}

Dimension operator/(const Dimension& a, const Dimension& b) {
  return {a.length - b.length, a.mass - b.mass, a.time - b.time, a.temperature - b.temperature,
          a.angle - b.angle};
}

std::string to_string(const Dimension& d) {
  std::string text;
  const auto append = [&text](const char* symbol, int exponent) {
    if (exponent == 0) return;
    if (!text.empty()) text += ' ';
    text += exponent == 1 ? std::string(symbol) : fmt::format("{}^{}", symbol, exponent);
  };
  // A force to some power rather than its parts.
  const bool forces = d.mass != 0 && d.time == -2 * d.mass;
  append("N", forces ? d.mass : 0);
  append("kg", forces ? 0 : d.mass);
  append("m", d.length - (forces ? d.mass : 0));
  append("s", forces ? 0 : d.time);
  append("K", d.temperature);
  append("rad", d.angle);
  return text.empty() ? "1" : text;
}

Unit parse_unit(std::string_view text) { return UnitParser(trimmed(text)).parse(); }

double parse_quantity(std::string_view text, const Dimension& expected,
                      std::string_view default_unit) {
  const std::string_view whole = trimmed(text);
  std::string_view rest = whole;
  const double number = take_number(rest, whole, expected);
  const bool is_plain = rest.empty();
  if (is_plain && default_unit.empty()) {
    if (expected == dimension::none) return number;
    throw std::invalid_argument(
        fmt::format("'{}' has no unit: expected {}", whole, example_units(expected)));
  }
  const Unit unit = parse_unit(is_plain ? default_unit : rest);
  if (!fits(unit.dimension, expected))
    throw std::invalid_argument(fmt::format("'{}{}{}' is in {}: expected {}", whole,
                                            is_plain ? " " : "", is_plain ? default_unit : "",
                                            to_string(unit.dimension), example_units(expected)));
  return to_si(number, unit.factor);
}

std::string format_quantity(double value_in_si, std::string_view unit) {
  const double factor = parse_unit(unit).factor;
  const double exact = value_in_si / factor;
  // Division leaves rounding behind: take the shortest number that reads back to the same value.
  double shown = exact;
  for (int digits = 1; digits <= 17; ++digits) {
    const std::string text = fmt::format("{:.{}e}", exact, digits - 1);
    std::from_chars(text.data(), text.data() + text.size(), shown);
    if (to_si(shown, factor) == value_in_si) break;
  }
  return fmt::format("{} {}", shown == 0 ? 0.0 : shown, unit);
}

std::string UnitSystem::unit_for(const Dimension& d) const {
  if (d == dimension::none) return "1";
  if (d == dimension::angle) return angle;
  if (d == dimension::mass) return mass;
  if (d == dimension::temperature) return temperature;
  if (d == dimension::density) return fmt::format("{}/({})^3", mass, length);
  if (d == dimension::inertia) return fmt::format("{}*({})^2", mass, length);
  if (d.temperature != 0) throw std::invalid_argument("no default unit for " + to_string(d));
  // Mass is carried by the force unit: kg = N s^2/m. Compound units are per radian.
  std::string text;
  const auto append = [&text](const std::string& symbol, int exponent) {
    if (exponent == 0) return;
    const bool plain = exponent == 1 && std::all_of(symbol.begin(), symbol.end(), [](char c) {
                         return std::isalpha(static_cast<unsigned char>(c)) != 0;
                       });
    if (text.empty() && !plain) text = "1";
    text += (text.empty() ? "" : "*") + (plain ? symbol : fmt::format("({})^{}", symbol, exponent));
  };
  append(force, d.mass);
  append(length, d.length - d.mass);
  append(time, d.time + 2 * d.mass);
  return text;
}

}  // namespace kinetostat::spatial

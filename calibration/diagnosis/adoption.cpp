#include "kinetostat/calibration/diagnosis/adoption.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/printable.h"
#include "kinetostat/io/yaml.h"

namespace kinetostat::calibration {
namespace {

// Blocks stand between "  # >>> adopted effect 2 (with the heading)" and "  # <<< adopted effect".
// Adoptions are numbered from 1; those before numbers were written have none.
constexpr std::string_view begins = "  # >>> adopted ";
constexpr std::string_view ends = "  # <<< adopted ";
constexpr std::string_view with_heading = " (with the heading)";

// The digits that a twentieth of a percent of the deviation asks for, at least four.
double rounded(double value, double deviation) {
  if (std::isnan(deviation) || !(deviation > 0) || value == 0) return value;
  const double asked = std::ceil(std::log10(std::abs(value) / deviation)) + 4;
  const int digits = static_cast<int>(std::clamp(asked, 4.0, 17.0));
  return std::stod(fmt::format("{:.{}e}", value, digits - 1));
}

std::string quantity(double value, const std::string& unit) {
  return unit.empty() ? fmt::format("{}", value) : fmt::format("{} {}", value, unit);
}

// "gap: {value: 0.05 mm, sd: 0.003 mm}"
std::string entry(const AdoptedValue& v) {
  const std::string value = quantity(rounded(v.value, v.deviation), v.unit);
  if (std::isnan(v.deviation)) return fmt::format("{}: {}", v.name, value);
  return fmt::format("{}: {{value: {}, sd: {}}}", v.name, value,
                     quantity(rounded(v.deviation, v.deviation), v.unit));
}

std::string block_of(const std::vector<AdoptedEffect>& effects) {
  std::string text;
  for (const AdoptedEffect& adopted : effects) {
    for (const std::string& reason : adopted.reasons)
      text += "  # " + common::printable(reason) + "\n";
    std::vector<std::string> values;
    for (const AdoptedValue& v : adopted.values) values.push_back(entry(v));
    text += fmt::format("  - {{effect: {}, at: {}, {}}}\n", io::yaml_scalar(adopted.effect),
                        io::yaml_scalar(adopted.at), fmt::join(values, ", "));
  }
  return text;
}

std::string block_of(const std::vector<AdoptedParameter>& fitted) {
  std::string text;
  for (const AdoptedParameter& p : fitted) {
    const std::string what =
        p.effect.empty()
            ? fmt::format("stiffness: {}", io::yaml_scalar(p.stiffness))
            : fmt::format("effect: {}, at: {}, parameter: {}", io::yaml_scalar(p.effect),
                          io::yaml_scalar(p.at), io::yaml_scalar(p.parameter));
    text += fmt::format("  - {{{}, {}}}", what, entry(p.value));
    text += p.remark.empty() ? "\n" : "  # " + common::printable(p.remark) + "\n";
  }
  return text;
}

bool is_superseded(const Adoption& adoption, const std::string& a, const std::string& b) {
  return std::any_of(adoption.superseded.begin(), adoption.superseded.end(), [&](const auto& pair) {
    return (pair[0] == a && pair[1] == b) || (pair[0] == b && pair[1] == a);
  });
}

// What one name is correlated with, each pair at the first of its names.
std::vector<std::string> correlated_with(const Adoption& adoption, std::size_t i) {
  const auto& [names, matrix] = adoption.correlation;
  constexpr double least = 5e-4;  // less is written as zero
  std::vector<std::string> with;
  for (std::size_t j = i + 1; j < names.size(); ++j) {
    const double value =
        std::clamp(matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)), -1.0, 1.0);
    if (std::abs(value) >= least || is_superseded(adoption, names[i], names[j]))
      with.push_back(fmt::format("{}: {:.3f}", io::yaml_scalar(names[j]), value));
  }
  for (const auto& pair : adoption.superseded)
    for (const auto& [own, other] : {std::pair(pair[0], pair[1]), std::pair(pair[1], pair[0])})
      if (own == names[i] && std::find(names.begin(), names.end(), other) == names.end())
        with.push_back(io::yaml_scalar(other) + ": 0");
  return with;
}

// "  - {of: fitted stiffness of q1, with: {fitted stiffness of q2: -0.4}}"
std::string correlations_block(const Adoption& adoption) {
  std::string text;
  for (std::size_t i = 0; i < adoption.correlation.names.size(); ++i)
    if (const auto with = correlated_with(adoption, i); !with.empty())
      text += fmt::format("  - {{of: {}, with: {{{}}}}}\n",
                          io::yaml_scalar(adoption.correlation.names[i]), fmt::join(with, ", "));
  return text;
}

// Where the line after the one at `at` starts.
std::size_t next_line(const std::string& text, std::size_t at) {
  const std::size_t end = text.find('\n', at);
  return end == std::string::npos ? text.size() : end + 1;
}

// The start of the line with a top-level key ("effects:"), or npos.
std::size_t heading_of(const std::string& text, const std::string& key) {
  for (std::size_t at = 0; at < text.size(); at = next_line(text, at))
    if (text.compare(at, key.size(), key) == 0) return at;
  return std::string::npos;
}

std::string without_comment(std::string rest) {
  if (const std::size_t comment = rest.find('#'); comment != std::string::npos) rest.erase(comment);
  while (!rest.empty() && (rest.back() == ' ' || rest.back() == '\n' || rest.back() == '\r'))
    rest.pop_back();
  while (!rest.empty() && rest.front() == ' ') rest.erase(0, 1);
  return rest;
}

// Behind the last line of the block under a heading: lines that are indented, or list items.
std::size_t end_of_block(const std::string& text, std::size_t heading) {
  std::size_t end = next_line(text, heading);
  for (std::size_t at = end; at < text.size(); at = next_line(text, at)) {
    const char c = text[at];
    if (c == ' ' || c == '-')
      end = next_line(text, at);
    else if (c != '\n' && c != '\r' && c != '#')
      break;
  }
  return end;
}

// A block of an earlier adoption.
struct Block {
  std::size_t begin = 0, end = 0;  // of its lines, the first and last included
  int number = 0;
  std::string what;  // "effect", "fitted" or "correlations"
  bool has_heading = false;
};

// What the first line of a block says: "effect 2 (with the heading)".
Block block_named(std::string words, std::size_t begin) {
  Block block{.begin = begin, .what = {}};
  if (words.ends_with(with_heading)) {
    block.has_heading = true;
    words.erase(words.size() - with_heading.size());
  }
  const std::size_t blank = words.find(' ');
  block.what = words.substr(0, blank);
  if (blank != std::string::npos) block.number = std::atoi(words.c_str() + blank + 1);
  return block;
}

std::vector<Block> blocks_in(const std::string& text) {
  std::vector<Block> blocks;
  for (std::size_t at = 0; at < text.size(); at = next_line(text, at)) {
    if (text.compare(at, begins.size(), begins) != 0) continue;
    const std::size_t from = at + begins.size();
    Block block = block_named(text.substr(from, text.find('\n', from) - from), at);
    const std::size_t end = text.find(ends, at);
    if (end == std::string::npos)
      throw std::invalid_argument("the end of an adopted effect was taken away");
    block.end = next_line(text, end);
    blocks.push_back(std::move(block));
  }
  return blocks;
}

std::string key_of(const Block& block) {
  return block.what == "effect" ? "effects:" : block.what + ":";
}

std::string without(const std::string& text, const Block& block) {
  std::string before = text.substr(0, block.begin);
  if (block.has_heading) {
    const std::string heading = key_of(block) + "\n";
    if (!before.ends_with(heading))
      throw std::invalid_argument(
          fmt::format("the heading '{}' of what was adopted was changed", key_of(block)));
    before.erase(before.size() - heading.size());
  }
  return before + text.substr(block.end);
}

// The text with lines added under a top-level key.
std::string with_block(const std::string& text, Block block, const std::string& lines) {
  const std::string key = key_of(block);
  const std::size_t heading = heading_of(text, key);
  const std::size_t end = heading == std::string::npos ? text.size() : end_of_block(text, heading);
  if (end > 0 && text[end - 1] != '\n')
    throw std::invalid_argument("the robot file does not end with a line break; add one");
  if (heading != std::string::npos) {
    const std::size_t rest = heading + key.size();
    const std::string inline_part =
        without_comment(text.substr(rest, next_line(text, rest) - rest));
    if (!inline_part.empty())
      throw std::invalid_argument(
          fmt::format("'{} {}' is written in one line; write one entry a line, '  - {{...}}', or "
                      "nothing at all when there is none",
                      key, inline_part));
  }
  block.has_heading = heading == std::string::npos;
  return text.substr(0, end) + (block.has_heading ? key + "\n" : "") +
         fmt::format("{}{} {}{}\n{}{}{}\n", begins, block.what, block.number,
                     block.has_heading ? with_heading : "", lines, ends, block.what) +
         text.substr(end);
}

}  // namespace

AdoptedValue in_units_of(const spatial::UnitSystem& units, AdoptedValue v) {
  if (v.unit.empty()) return v;
  const spatial::Unit stated = spatial::parse_unit(v.unit);
  for (const auto& [dimension, unit] :
       {std::pair(spatial::dimension::length, units.length),
        std::pair(spatial::dimension::angle, units.angle),
        std::pair(spatial::dimension::force, units.force),
        std::pair(spatial::dimension::linear_stiffness, units.force + "/" + units.length)}) {
    if (stated.dimension != dimension) continue;
    const double factor = stated.factor / spatial::parse_unit(unit).factor;
    return {v.name, unit, v.value * factor, v.deviation * factor};
  }
  return v;
}

void add_correlation(const vjm::Robot& robot, EstimateCorrelation correlation, Adoption& adoption) {
  adoption.correlation = std::move(correlation);
  const std::vector<std::string>& names = adoption.correlation.names;
  const auto is_new = [&](Eigen::Index i) {
    const std::string& name = robot.sources[static_cast<std::size_t>(i)].name;
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  for (Eigen::Index i = 0; i < robot.correlation.rows(); ++i)
    for (Eigen::Index j = i + 1; j < robot.correlation.cols(); ++j)
      if (robot.correlation(i, j) != 0 && (is_new(i) || is_new(j)))
        adoption.superseded.push_back({robot.sources[static_cast<std::size_t>(i)].name,
                                       robot.sources[static_cast<std::size_t>(j)].name});
}

std::string adopted(const std::string& robot_file, const Adoption& adoption) {
  const std::vector<Block> earlier = blocks_in(robot_file);
  int number = static_cast<int>(earlier.size()) + 1;
  for (const Block& block : earlier) number = std::max(number, block.number + 1);
  std::string text = robot_file;
  if (!adoption.effects.empty())
    text = with_block(text, {.number = number, .what = "effect"}, block_of(adoption.effects));
  if (!adoption.fitted.empty())
    text = with_block(text, {.number = number, .what = "fitted"}, block_of(adoption.fitted));
  if (const std::string lines = correlations_block(adoption); !lines.empty())
    text = with_block(text, {.number = number, .what = "correlations"}, lines);
  return text;
}

std::string reverted(const std::string& robot_file) {
  const std::vector<Block> blocks = blocks_in(robot_file);
  if (blocks.empty()) throw std::invalid_argument("no adopted effect is in this robot file");
  int last = 0;
  for (const Block& block : blocks) last = std::max(last, block.number);
  std::string text = robot_file;
  for (auto block = blocks.rbegin(); block != blocks.rend(); ++block) {
    if (block->number != last) continue;
    text = without(text, *block);
    if (last == 0) break;  // one at a time, where they have no numbers
  }
  return text;
}

}  // namespace kinetostat::calibration

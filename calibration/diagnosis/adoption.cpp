#include "kinetostat/calibration/diagnosis/adoption.h"

#include <cmath>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/printable.h"
#include "kinetostat/io/yaml.h"

namespace kinetostat::calibration {
namespace {

constexpr const char* begins = "  # >>> adopted effect";
constexpr const char* ends = "  # <<< adopted effect";
constexpr const char* heading_added = " (with the heading)";

std::string quantity(double value, const std::string& unit) {
  return unit.empty() ? fmt::format("{}", value) : fmt::format("{} {}", value, unit);
}

std::string block_of(const Adoption& adoption, bool adds_heading) {
  std::string text = fmt::format("{}{}\n", begins, adds_heading ? heading_added : "");
  for (const std::string& reason : adoption.reasons)
    text += "  # " + common::printable(reason) + "\n";
  std::vector<std::string> values;
  for (const Adoption::Value& v : adoption.values)
    values.push_back(std::isnan(v.deviation)
                         ? fmt::format("{}: {}", v.name, quantity(v.value, v.unit))
                         : fmt::format("{}: {{value: {}, sd: {}}}", v.name,
                                       quantity(v.value, v.unit), quantity(v.deviation, v.unit)));
  text += fmt::format("  - {{effect: {}, at: {}, {}}}\n", io::yaml_scalar(adoption.effect),
                      io::yaml_scalar(adoption.at), fmt::join(values, ", "));
  return text + ends + "\n";
}

// Where the line after the one at `at` starts.
std::size_t next_line(const std::string& text, std::size_t at) {
  const std::size_t end = text.find('\n', at);
  return end == std::string::npos ? text.size() : end + 1;
}

// The start of the line with a top-level `effects:`, or npos.
std::size_t heading_of(const std::string& text) {
  for (std::size_t at = 0; at < text.size(); at = next_line(text, at))
    if (text.compare(at, 8, "effects:") == 0) return at;
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

}  // namespace

std::string adopted(const std::string& robot_file, const Adoption& adoption) {
  const std::size_t heading = heading_of(robot_file);
  if (heading == std::string::npos) {
    const std::string gap = robot_file.empty() || robot_file.back() == '\n' ? "" : "\n";
    if (!gap.empty())
      throw std::invalid_argument("the robot file does not end with a line break; add one");
    return robot_file + "effects:\n" + block_of(adoption, true);
  }
  const std::size_t line_end = next_line(robot_file, heading);
  const std::string inline_part =
      without_comment(robot_file.substr(heading + 8, line_end - heading - 8));
  if (!inline_part.empty())
    throw std::invalid_argument(
        fmt::format("'effects: {}' is written in one line; write one effect a line, '  - {{effect: "
                    "...}}', or nothing at all when there is none",
                    inline_part));
  const std::size_t at = end_of_block(robot_file, heading);
  std::string before = robot_file.substr(0, at);
  if (before.back() != '\n')
    throw std::invalid_argument("the robot file does not end with a line break; add one");
  return before + block_of(adoption, false) + robot_file.substr(at);
}

std::string reverted(const std::string& robot_file) {
  const std::size_t begin = robot_file.rfind(begins);
  const std::size_t end = robot_file.rfind(ends);
  if (begin == std::string::npos || end == std::string::npos || end < begin)
    throw std::invalid_argument("no adopted effect is in this robot file");
  std::string before = robot_file.substr(0, begin);
  const std::string after = robot_file.substr(next_line(robot_file, end));
  const std::size_t line = next_line(robot_file, begin);
  if (robot_file.substr(begin, line - begin).find(heading_added) != std::string::npos) {
    const std::string heading = "effects:\n";
    if (!before.ends_with(heading))
      throw std::invalid_argument("the heading 'effects:' of the adopted effect was changed");
    before.erase(before.size() - heading.size());
  }
  return before + after;
}

}  // namespace kinetostat::calibration

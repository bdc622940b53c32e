#include "kinetostat/apps/cli/option_values.h"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/io/largest_number.h"

namespace kinetostat::apps {
namespace {

[[noreturn]] void refuse_count(const std::string& option, const std::string& text,
                               std::size_t count, const char* expected) {
  throw UsageError(option, fmt::format("'{}' has {} values, not {}", text, count, expected),
                   "Separate them with commas and no blanks, such as 0,0,-100");
}

}  // namespace

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == separator) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

io::Part part_of(const std::string& option, const std::string& text) {
  if (text.empty()) return {};
  io::Part part;
  const char* const end = text.data() + text.size();
  const auto [slash, first] = std::from_chars(text.data(), end, part.number);
  bool good = first == std::errc() && slash != end && *slash == '/';
  if (good) {
    const auto [rest, second] = std::from_chars(slash + 1, end, part.count);
    good = second == std::errc() && rest == end;
  }
  if (!good || part.number < 1 || part.number > part.count)
    throw UsageError(option, fmt::format("'{}' is not i/n", text),
                     fmt::format("Write {} 2/8 for the second of eight parts", option));
  return part;
}

double quantity(const std::string& option, const std::string& text,
                const spatial::Dimension& dimension, const spatial::UnitSystem& units) {
  try {
    const std::string bare =
        dimension == spatial::dimension::none ? std::string() : units.unit_for(dimension);
    const double value = spatial::parse_quantity(text, dimension, bare);
    if (std::abs(value) <= io::largest_number) return value;
  } catch (const std::invalid_argument& error) {
    throw UsageError(option, error.what());
  }
  throw UsageError(option, fmt::format("'{}' is too large to compute with", text));
}

spatial::Vector6 six_values(const std::string& option, const std::string& text,
                            const spatial::Dimension& first, const spatial::Dimension& second,
                            const spatial::UnitSystem& units) {
  const std::vector<std::string> parts = split(text);
  if (parts.size() != 3 && parts.size() != 6) refuse_count(option, text, parts.size(), "3 or 6");
  spatial::Vector6 values = spatial::Vector6::Zero();
  for (std::size_t i = 0; i < parts.size(); ++i)
    values[static_cast<Eigen::Index>(i)] =
        quantity(option, parts[i], i < 3 ? first : second, units);
  return values;
}

spatial::Vector3 three_values(const std::string& option, const std::string& text,
                              const spatial::Dimension& dimension,
                              const spatial::UnitSystem& units) {
  const std::vector<std::string> parts = split(text);
  if (parts.size() != 3) refuse_count(option, text, parts.size(), "3");
  spatial::Vector3 values;
  for (std::size_t i = 0; i < 3; ++i)
    values[static_cast<Eigen::Index>(i)] = quantity(option, parts[i], dimension, units);
  return values;
}

}  // namespace kinetostat::apps

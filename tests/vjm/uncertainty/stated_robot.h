// Shipped robots whose files state how well their numbers are known.
#pragma once

#include <filesystem>
#include <functional>
#include <regex>
#include <string>

#include <fmt/format.h>

#include "kinetostat/io/text_file.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::vjm {

inline std::filesystem::path shipped_robot(const std::string& name) {
  return std::filesystem::path(KINETOSTAT_SOURCE_DIR) / "data" / "robots" / name;
}

/// The text of a shipped robot file with every stiffness of a joint, modulus and property of a
/// general section as `written` writes it, given its number and what follows that (a unit, or
/// nothing).
inline std::string stated_text(
    const std::string& name,
    const std::function<std::string(double number, const std::string& unit)>& written) {
  const std::string text = io::read_text(shipped_robot(name));
  const std::regex number(R"re(((?:stiffness|E|G|A|Iy|Iz|J): )([0-9][0-9.eE+-]*)([^,}\n]*))re");
  std::string result;
  auto at = text.cbegin();
  for (std::sregex_iterator found(text.begin(), text.end(), number), end; found != end; ++found) {
    result.append(at, text.cbegin() + found->position());
    result += (*found)[1].str() + written(std::stod((*found)[2].str()), (*found)[3].str());
    at = text.cbegin() + found->position() + found->length();
  }
  return result.append(at, text.cend());
}

/// With a standard deviation of `share` of each.
inline Robot stated_robot(const std::string& name, double share) {
  return parse_robot(stated_text(name,
                                 [share](double value, const std::string& unit) {
                                   return fmt::format("{{value: {}{}, sd: {} %}}", value, unit,
                                                      100 * share);
                                 }),
                     shipped_robot(name));
}

}  // namespace kinetostat::vjm

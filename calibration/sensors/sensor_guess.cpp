#include "kinetostat/calibration/sensors/sensor_guess.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace kinetostat::calibration {
namespace {

struct Word {
  std::string_view word, kind;
};
constexpr std::array words = {
    Word{"dial", "gauge"},        Word{"dialgauge", "gauge"},  Word{"gauge", "gauge"},
    Word{"messuhr", "gauge"},     Word{"lvdt", "gauge"},       Word{"probe", "gauge"},
    Word{"taster", "gauge"},      Word{"tilt", "tilt"},        Word{"level", "tilt"},
    Word{"inclinometer", "tilt"}, Word{"neigung", "tilt"},     Word{"libelle", "tilt"},
    Word{"ballbar", "distance"},  Word{"dbb", "distance"},     Word{"wire", "distance"},
    Word{"distance", "distance"}, Word{"abstand", "distance"}, Word{"encoder", "joint"},
    Word{"theta", "joint"},       Word{"torque", "torque"},    Word{"tau", "torque"},
    Word{"motor", "torque"},      Word{"drehmoment", "torque"}};

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

// "Dial 1" -> "Dial", "1".
std::vector<std::string> parts_of(std::string_view column) {
  std::vector<std::string> parts(1);
  for (const char c : column) {
    if (std::string_view(" _-.").find(c) == std::string_view::npos)
      parts.back() += c;
    else if (!parts.back().empty())
      parts.emplace_back();
  }
  if (parts.back().empty()) parts.pop_back();
  return parts;
}

std::string_view kind_of(const std::string& part) {
  const std::string word = lower(part.substr(0, part.find_last_not_of("0123456789") + 1));
  const auto* const found =
      std::find_if(words.begin(), words.end(), [&](const Word& w) { return w.word == word; });
  return found == words.end() ? std::string_view() : found->kind;
}

char axis_of(const std::string& part) {
  const std::string axis = lower(part);
  const bool is_axis = axis.size() == 1 && axis[0] >= 'x' && axis[0] <= 'z';
  const bool turns = axis.size() == 2 && axis[0] == 'r' && axis[1] >= 'x' && axis[1] <= 'z';
  return is_axis || turns ? axis.back() : '\0';
}

std::string joint_among(const std::vector<std::string>& parts,
                        const std::vector<std::string>& joints) {
  for (const std::string& joint : joints)
    for (const std::string& part : parts)
      if (lower(part) == lower(joint)) return joint;
  return {};
}

std::string joined(const std::vector<std::string>& parts) {
  std::string name;
  for (const std::string& part : parts) name += (name.empty() ? "" : "_") + part;
  return name;
}

}  // namespace

std::optional<SensorGuess> sensor_guess(std::string_view column,
                                        const std::vector<std::string>& joints) {
  std::vector<std::string> parts = parts_of(column);
  const auto found = std::find_if(parts.begin(), parts.end(),
                                  [](const auto& part) { return !kind_of(part).empty(); });
  if (found == parts.end()) return std::nullopt;
  SensorGuess guess{.kind = std::string(kind_of(*found))};
  if (guess.kind == "joint" || guess.kind == "torque") {
    guess.joint = joint_among(parts, joints);
    if (guess.joint.empty()) return std::nullopt;
  } else if (parts.size() > 1) {
    guess.axis = axis_of(parts.back());
  }
  if (guess.kind == "tilt" && guess.axis != 0) parts.pop_back();
  guess.name = joined(parts);
  return guess;
}

}  // namespace kinetostat::calibration

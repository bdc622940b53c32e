// An effect that was found goes into the robot file, and can be taken out again.
#pragma once

#include <string>
#include <vector>

namespace kinetostat::calibration {

/// The effect that is written, and why it is there.
struct Adoption {
  struct Value {
    std::string name, unit;  // SI; no unit for a plain number
    double value = 0;
    double deviation = 0;  // NaN when not known
  };
  std::string effect, at;
  std::vector<Value> values;
  std::vector<std::string> reasons;  // lines of provenance, written as comments
};

/// The text of a robot file with the effect added to `effects:` at its end: all else stays as it
/// is, byte for byte. Numbers read back exactly. Throws std::invalid_argument when `effects:` is
/// written in one line with something in it.
std::string adopted(const std::string& robot_file, const Adoption& adoption);

/// The text without what the last adopted() added: byte for byte what it was before. Throws
/// std::invalid_argument when nothing was adopted, or somebody changed it since.
std::string reverted(const std::string& robot_file);

}  // namespace kinetostat::calibration

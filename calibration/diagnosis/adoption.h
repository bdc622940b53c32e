// What a diagnosis found goes into the robot file, and can be taken out again.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "kinetostat/calibration/regression/correlation.h"
#include "kinetostat/spatial/units.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::calibration {

/// A number with its standard deviation, in SI or in the unit given (none for a plain number). It
/// is written with four digits, or with as many more as a twentieth of a percent of its deviation
/// asks for; in full where nothing is known of its deviation (NaN).
struct AdoptedValue {
  std::string name, unit;
  double value = 0, deviation = 0;
};

/// The same in the units of a file, where it is a length, an angle, a force or a linear stiffness.
AdoptedValue in_units_of(const spatial::UnitSystem& units, AdoptedValue value);

/// An effect that is written under `effects:`.
struct AdoptedEffect {
  std::string effect, at;
  std::vector<AdoptedValue> values;
  std::vector<std::string> reasons;  // lines of provenance, written as comments
};

/// A factor on a stiffness of the robot file, or (`effect` not empty) the new value of an effect
/// that the file has; written under `fitted:`.
struct AdoptedParameter {
  std::string stiffness;              // as under `uncertain:`
  std::string effect, at, parameter;  // instead of it
  AdoptedValue value;                 // "factor", or "value"
  std::string remark;                 // what it was and what it is now, written as a comment
};

/// All that is written together, and taken out together.
struct Adoption {
  std::vector<AdoptedEffect> effects;
  std::vector<AdoptedParameter> fitted;
  /// Of what has a standard deviation; written under `correlations:` with three digits.
  EstimateCorrelation correlation = {};
  /// Names of sources that the file has as correlated with one of these, now estimated anew: their
  /// correlation becomes 0 unless it is given.
  std::vector<std::array<std::string, 2>> superseded = {};
};

/// Takes the correlation in, and what it supersedes in the file of a robot.
void add_correlation(const vjm::Robot& robot, EstimateCorrelation correlation, Adoption& adoption);

/// The text of a robot file with the adoption added to `effects:`, `fitted:` and `correlations:`,
/// or at its end: all else stays as it is, byte for byte. Throws std::invalid_argument when one of
/// these is written in one line with something in it.
std::string adopted(const std::string& robot_file, const Adoption& adoption);

/// The text without what the last adopted() added: byte for byte what it was before. Throws
/// std::invalid_argument when nothing was adopted, or somebody changed it since.
std::string reverted(const std::string& robot_file);

}  // namespace kinetostat::calibration

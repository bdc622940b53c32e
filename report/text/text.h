// Results as plain text for people: aligned tables, and 6x6 matrices that say what they are.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/spatial/stiffness.h"
#include "kinetostat/spatial/units.h"
#include "kinetostat/spatial/wrench_twist.h"

namespace kinetostat::report {

/// `digits` significant digits without needless 0s: "0.0125", "1.2e-07", "inf".
std::string number(double value, int digits = 4);
/// A share in percent with two significant digits: "0.2 %".
std::string percent(double share);
/// A probability in percent, a small one with its odds: "over 99.9 %", "56.3 %", "0.11 % (odds 1 :
/// 876)".
std::string probability_in_words(double probability);

/// A table with one header row. Columns whose cells are all numbers (or "-", or empty) are aligned
/// right, others left.
class Table {
 public:
  explicit Table(std::vector<std::string> header);

  /// Throws std::invalid_argument when the number of cells differs from the header's.
  void add_row(std::vector<std::string> cells);
  /// Lines of the table, each indented by two blanks, without trailing blanks.
  std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

/// A heading line (what, reference point, axes, units) and six labelled rows. Entries below 1e-10
/// of the size of their block are printed as 0. Units for length and force are taken from `units`;
/// angles are in rad, as in every published stiffness matrix.
std::string text(const spatial::Compliance6& compliance, const spatial::UnitSystem& units);
std::string text(const spatial::Stiffness6& stiffness, const spatial::UnitSystem& units);

/// One line each for the two vectors, headed like the matrices.
std::string text(const spatial::Wrench& wrench, const spatial::UnitSystem& units);
std::string text(const spatial::Twist& twist, const spatial::UnitSystem& units);

}  // namespace kinetostat::report

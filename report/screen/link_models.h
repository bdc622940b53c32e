// One figure of a robot with its links by several models, and the link that makes the difference.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "kinetostat/io/json.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::report {

/// The last of several rows is the one that others are compared to.
struct LinkModelRow {
  std::string model;  // "1 beam"
  double value = 0;   // [SI]
  /// The same with this model in one link alone, [SI] by its name; empty in the last row.
  std::vector<std::pair<std::string, double>> by_link;
};

/// What is compared, and the unit it is written in.
struct LinkModelFigure {
  std::string name;   // "stiffness along the softest direction"
  std::string unit;   // "N/mm"
  double factor = 1;  // [SI] of one unit
};

/// "stiffness along the softest direction", in the units of a robot file.
LinkModelFigure stiffness_figure(const spatial::UnitSystem& units);

/// "one beam 12 % stiffer than FEA, 4 beams 3 %; most by link foot".
std::string in_short(const std::vector<LinkModelRow>& rows);
/// A table: each model, its value, its difference, and the link that causes most of it.
std::string text(const LinkModelFigure& figure, const std::vector<LinkModelRow>& rows);
io::Json to_json(const LinkModelFigure& figure, const std::vector<LinkModelRow>& rows);

}  // namespace kinetostat::report

// First screen of `readings`: how a table was understood.
#pragma once

#include <string>

#include "kinetostat/calibration/campaign/readings_overview.h"

namespace kinetostat::report {

/// One line a column: name, meaning, unit, values, missing cells.
std::string table_text(const calibration::ReadingsOverview& overview);
/// The same, where columns are many without those that their names say enough of; then what was
/// assumed, and what keeps the table from being used.
std::string readings_text(const calibration::ReadingsOverview& overview);

}  // namespace kinetostat::report

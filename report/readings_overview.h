// How a table of readings was understood, as text and JSON.
#pragma once

#include <string>

#include "kinetostat/calibration/campaign/readings_overview.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

/// One line a column: name, meaning, unit, values, missing cells; then what was assumed, and what
/// keeps the table from being used.
std::string readings_text(const calibration::ReadingsOverview& overview);
io::Json readings_json(const calibration::ReadingsOverview& overview);

}  // namespace kinetostat::report

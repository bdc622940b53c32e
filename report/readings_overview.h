// How a table of readings was understood, as JSON.
#pragma once

#include "kinetostat/calibration/campaign/readings_overview.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

io::Json readings_json(const calibration::ReadingsOverview& overview);

}  // namespace kinetostat::report

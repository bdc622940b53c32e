// Fitted parameters, zero offsets and frames, for people and for programs.
#pragma once

#include <string>

#include "kinetostat/calibration/regression/base_fit.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

/// Tables in the units of the campaign, and what must be known to believe them: bounds that were
/// hit, combinations that the readings hardly determine, readings that counted less.
std::string text(const calibration::Campaign& campaign, const calibration::BaseFit& fit);

/// Name, value and standard error of one parameter; a stiffness by its factor, too. SI.
io::Json to_json(const calibration::ParameterEstimate& estimate);
/// Every figure, in SI units.
io::Json to_json(const calibration::Campaign& campaign, const calibration::BaseFit& fit);

}  // namespace kinetostat::report

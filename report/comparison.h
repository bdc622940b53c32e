// Comparison of a model with measurements, for people and for programs.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/comparison/compare.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

/// Findings of the comparison, in sentences with their numbers, worst first.
std::vector<std::string> findings(const calibration::Campaign& campaign,
                                  const calibration::Comparison& comparison);

/// Sentences, fitted parameters, and tables of residuals by component and session, in the units of
/// the campaign.
std::string text(const calibration::Campaign& campaign, const calibration::Comparison& comparison);

/// Every figure, in SI units, and every reading.
io::Json to_json(const calibration::Campaign& campaign, const calibration::Comparison& comparison);

/// One row a reading: measured, predicted, residual and whitened residual of each measured
/// component, nominal and fitted, in the units of the campaign.
std::string residual_table(const calibration::Campaign& campaign,
                           const calibration::Comparison& comparison);

}  // namespace kinetostat::report

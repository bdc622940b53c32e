// Readings and what models say of them, in columns: what charts of a comparison need.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/comparison/compare.h"
#include "kinetostat/calibration/diagnosis/diagnosis_result.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

/// A model, by the name under which it is drawn, and its residuals [m; rad], one entry a reading.
struct ReadingsModel {
  std::string name;
  std::vector<Eigen::VectorXd> residual;
  /// In units of the noise, what readings share taken out; may be empty.
  std::vector<Eigen::VectorXd> whitened = {};
};

/// "nominal", and "fitted" when there is a fit.
std::vector<ReadingsModel> readings_models(const calibration::Comparison& comparison);

/// Postures as charts name them: one entry a configuration of the campaign, {"label", "position"}:
/// the command, and the platform's position in base axes [m].
io::Json configurations(const vjm::Robot& robot, const calibration::Campaign& campaign);

/// One entry a reading in every column; SI, six significant digits; null where nothing was
/// measured. `noise`: of these readings.
io::Json readings_picture(const vjm::Robot& robot, const calibration::Campaign& campaign,
                          const calibration::Noise& noise,
                          const std::vector<ReadingsModel>& models);

/// The robot with the effects that a diagnosis found, at their fitted values.
vjm::Robot with_found(const vjm::Robot& robot, const calibration::Diagnosis& diagnosis);

}  // namespace kinetostat::report

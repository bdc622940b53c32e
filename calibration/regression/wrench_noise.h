// Effect of the noise of a load cell on displacements: a load that differs from the one that is
// written down moves the robot elsewhere.
#pragma once

#include "kinetostat/calibration/campaign/noise.h"
#include "kinetostat/calibration/regression/base_fit.h"

namespace kinetostat::calibration {

/// `noise` of the displacements with that of the wrenches added, reading by reading: S + C W C', C
/// the compliance of the model at `values` under the load of the reading, W the covariance of its
/// wrench about the point that it is stated about: there the force alone has no moment, and C,
/// which is for forces at that point, carries its lever arm (first order; ISO/IEC Guide 98-3,
/// section 5.1.2). With `found`, C is that of the target and in the frames of that fit. Unchanged
/// where the campaign takes its wrenches to be exact, and for readings without an equilibrium.
Noise with_wrench_noise(const Noise& noise, const Campaign& campaign, const Predictor& predictor,
                        const std::vector<Parameter>& parameters, const Eigen::VectorXd& values,
                        common::Progress& progress, const BaseFit* found = nullptr);

}  // namespace kinetostat::calibration

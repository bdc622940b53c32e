// What the scatter of repeated readings says about the noise.
#pragma once

#include <optional>
#include <vector>

#include "kinetostat/calibration/campaign/noise.h"
#include "kinetostat/calibration/campaign/replicates.h"
#include "kinetostat/calibration/statistics/goodness_of_fit.h"

namespace kinetostat::calibration {

/// Scatter within groups.
struct PureError {
  double sum = 0;                       // of squares about the weighted group means, over sigma^2
  Eigen::Index degrees_of_freedom = 0;  // number of values minus number of groups
};

/// Over these components (none: all), in units of the noise. What readings share by their
/// datums is no scatter of theirs: the sum is that of generalised least squares.
PureError pure_error(const Campaign& campaign, const std::vector<ReplicateGroup>& groups,
                     const Noise& noise, const std::vector<Eigen::Index>& components = {});

/// Does the scatter agree with the stated noise? Nothing where either is missing.
std::optional<ChiSquareTest> test_of_stated_noise(const PureError& scatter, const Noise& noise);

}  // namespace kinetostat::calibration

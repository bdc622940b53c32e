// Readings repeated under the same conditions, and what their scatter says about the noise.
#pragma once

#include <optional>
#include <vector>

#include "kinetostat/calibration/campaign.h"
#include "kinetostat/calibration/goodness_of_fit.h"

namespace kinetostat::calibration {

struct Noise;  // noise.h

/// Readings of one component that every model predicts to be equal; a single one also is a group.
struct ReplicateGroup {
  Eigen::Index component = 0;
  std::vector<std::size_t> readings;
};

/// Groups of readings in use with exactly the same configuration, load and point, branch (stated
/// direction of load, else the order within a cycle) and setting (and session, when zero offsets
/// are estimated per session); without load also the side of the load from which the cycle comes
/// back. Where the table has a column `replicate`, the k-th visit to a state in one replicate
/// belongs with the k-th visit in the others: rows of the same replicate never form a group, since
/// what differs between them (creep, return to zero) is not pure error. Visits are counted in the
/// order of time, step, id.
std::vector<ReplicateGroup> replicate_groups(const Campaign& campaign);

/// Scatter within groups.
struct PureError {
  double sum = 0;                       // of squares about the weighted group means, over sigma^2
  Eigen::Index degrees_of_freedom = 0;  // number of values minus number of groups
};

/// Pure error of the components [first, first + count), in units of the noise.
PureError pure_error(const Campaign& campaign, const std::vector<ReplicateGroup>& groups,
                     const Noise& noise, Eigen::Index first = 0, Eigen::Index count = 6);

/// Does the scatter agree with the stated noise? Nothing where either is missing.
std::optional<ChiSquareTest> test_of_stated_noise(const PureError& scatter, const Noise& noise);

}  // namespace kinetostat::calibration

// Readings repeated under the same conditions.
#pragma once

#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"

namespace kinetostat::calibration {

/// Readings of one component that every model predicts to be equal; a single one also is a group.
struct ReplicateGroup {
  Eigen::Index component = 0;
  std::vector<std::size_t> readings;
};

/// Groups of readings in use with exactly the same configuration, load and point, branch (stated
/// direction of load, else the order within a cycle) and setting (and session, when zero offsets
/// or frames are estimated per session); under load on its way back also the load
/// that it comes back from, without load the side of the load from which the
/// cycle comes back. Where the table has a column `replicate`, the k-th visit to a state in one
/// replicate belongs with the k-th visit in the others: rows of the same replicate never form a
/// group, since what differs between them (creep, return to zero) is not pure error. Visits are
/// counted in the order of time, step, id.
///
/// Where time or temperature is known of all, and readings of one state that lie far apart in it
/// scatter more than neighbours, beyond an F test at 0.5 % of the orthogonal contrasts
///
///   near = sum of (x_2k - x_2k-1)^2 / 2,   far = sum of (x_i - mean)^2 - near
///
/// only such pairs of neighbours are groups: what lies between them is drift, creep or expansion.
std::vector<ReplicateGroup> replicate_groups(const Campaign& campaign);

}  // namespace kinetostat::calibration

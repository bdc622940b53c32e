// The order in which loads were applied, and how one load compares with another.
#pragma once

#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"

namespace kinetostat::calibration {

/// Loads that differ by less than this share are meant to be the same: a load cell never reads the
/// same twice.
inline constexpr double same_load = 0.02;

/// How large a load is: its force [N], or its moment [N m] where it has no force, those at nodes
/// and in joints included. It does not depend on the point about which the wrench is stated.
double level_of(const vjm::Load& load);

/// Unit vector of the force (first three), or of the moment (last three) where there is no force; 0
/// without load.
spatial::Vector6 direction_of(const vjm::Load& load);

/// The loads of all readings less what is on them all the time: forces and moments that stay within
/// same_load while others change, and the load with which every cycle starts. As they are where
/// some reading is without load, where nothing changes, or where points of application differ.
/// Directions, levels, branches and reversals follow from these.
std::vector<vjm::Load> changing_loads(const Campaign& campaign);

/// One load cycle: readings of one session and one name in the column `cycle`, in the order of step
/// and time, else of rows.
using Cycle = std::vector<std::size_t>;

/// As they were run, masked readings included; empty when the table has no column `cycle`, or
/// leaves it empty.
std::vector<Cycle> cycles_as_run(const Campaign& campaign);
/// The same, and each reading that belongs to no cycle by itself.
std::vector<Cycle> all_cycles(const Campaign& campaign);
/// Of such cycles, stretches in which readings of one configuration follow each other.
std::vector<Cycle> stretches_of(const Campaign& campaign, const std::vector<Cycle>& cycles);
/// Readings along which histories are carried: the same without a change of configuration inside;
/// where the campaign says that the history continues, all cycles of a session in one.
std::vector<Cycle> histories_of(const Campaign& campaign);
/// The cycles as they were run, without masked readings.
std::vector<Cycle> load_cycles(const Campaign& campaign);

/// One entry a reading: what the table states, else whether its load is larger or smaller than the
/// one before it in the same cycle and posture; `unstated` where neither is known.
std::vector<LoadDirection> branches(const Campaign& campaign);
/// The same where changing_loads() are known.
std::vector<LoadDirection> branches(const Campaign& campaign, const std::vector<vjm::Load>& loads);

/// Whether a reading in use was taken while its load was rising, or falling.
bool has_branch(const Campaign& campaign, LoadDirection branch);

/// Readings in use at the same configuration whose loads are equal and opposite (within same_load),
/// in pairs; each reading is in one pair at most.
std::vector<std::pair<std::size_t, std::size_t>> reversed_pairs(const Campaign& campaign);

/// Whether some load is taken back or reversed. Without that friction looks like a clearance.
bool takes_loads_back(const Campaign& campaign);

/// Distinct values, ascending; those within `tolerance` of the largest magnitude count as one: by
/// default what rounding makes of a change of units.
std::vector<double> distinct_values(std::vector<double> values, double tolerance = 1e-9);

/// A reading of which at least one component is in use.
bool is_used(const Reading& reading);

}  // namespace kinetostat::calibration

#include "kinetostat/calibration/campaign/replicates.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>

#include "kinetostat/calibration/campaign/load_history.h"

namespace kinetostat::calibration {
namespace {

using LoadKey = std::array<double, 9>;

LoadKey key_of(const vjm::Load& load) {
  LoadKey key;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    key[i] = load.force[k];
    key[3 + i] = load.moment[k];
    key[6 + i] = load.point_on_platform[k];
  }
  return key;
}

// The axis along which a load acts above all, and its sign: 1 to 6, or -1 to -6; 0 without load.
int side_of(const vjm::Load& load) {
  const spatial::Vector6 direction = direction_of(load);
  Eigen::Index axis = 0;
  const double size = direction.cwiseAbs().maxCoeff(&axis);
  if (size == 0) return 0;
  return static_cast<int>(axis + 1) * (direction[axis] > 0 ? 1 : -1);
}

// From which side a reading without load comes back within its cycle: friction and clearance keep
// it apart from those of the other side. 0 where it has load, or comes from none.
std::vector<int> sides_of_return(const Campaign& campaign) {
  std::vector<int> result(campaign.readings.size(), 0);
  const std::vector<vjm::Load> loads = changing_loads(campaign);
  for (const Cycle& cycle : cycles_as_run(campaign))
    for (std::size_t k = 1; k < cycle.size(); ++k) {
      const Reading &now = campaign.readings[cycle[k]], &before = campaign.readings[cycle[k - 1]];
      const vjm::Load& load_before = loads[cycle[k - 1]];
      if (level_of(loads[cycle[k]]) == 0 && now.configuration == before.configuration)
        result[cycle[k]] = level_of(load_before) == 0 ? result[cycle[k - 1]] : side_of(load_before);
    }
  return result;
}

using StateKey = std::tuple<std::size_t, LoadKey, LoadDirection, int, std::string, std::size_t>;

StateKey state_of(const Campaign& campaign, const Reading& reading, LoadDirection branch,
                  int side) {
  const bool own_zero = campaign.zero == ZeroReading::estimated;
  return {reading.configuration, key_of(reading.load),          branch, side,
          reading.setting,       own_zero ? reading.session : 0};
}

std::vector<std::size_t> in_order_of_time(const std::vector<Reading>& readings) {
  std::vector<std::size_t> order(readings.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&readings](std::size_t i) {
    const Reading& r = readings[i];
    return std::tuple(r.time, r.step, std::string_view(r.id));
  };
  std::stable_sort(order.begin(), order.end(),
                   [&key](std::size_t a, std::size_t b) { return key(a) < key(b); });
  return order;
}

}  // namespace

std::vector<ReplicateGroup> replicate_groups(const Campaign& campaign) {
  // Value: number of the visit to this state within one replicate.
  std::map<std::tuple<StateKey, std::string, Eigen::Index>, int> visits;
  std::map<std::tuple<StateKey, int, Eigen::Index>, std::vector<std::size_t>> groups;
  const std::vector<LoadDirection> branch = branches(campaign);
  const std::vector<int> side = sides_of_return(campaign);
  for (const std::size_t i : in_order_of_time(campaign.readings)) {
    const Reading& reading = campaign.readings[i];
    const StateKey state = state_of(campaign, reading, branch[i], side[i]);
    for (Eigen::Index k = 0; k < 6; ++k) {
      if (!reading.uses(k)) continue;
      const int visit = reading.replicate.empty() ? 0 : visits[{state, reading.replicate, k}]++;
      groups[{state, visit, k}].push_back(i);
    }
  }
  std::vector<ReplicateGroup> result;
  for (auto& [key, members] : groups) result.push_back({std::get<2>(key), std::move(members)});
  return result;
}

}  // namespace kinetostat::calibration

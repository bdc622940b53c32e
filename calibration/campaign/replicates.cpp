#include "kinetostat/calibration/campaign/replicates.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/calibration/statistics/goodness_of_fit.h"

namespace kinetostat::calibration {
namespace {

using LoadKey = std::vector<double>;

LoadKey key_of(const vjm::Load& load) {
  LoadKey key(9);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    key[i] = load.force[k];
    key[3 + i] = load.moment[k];
    key[6 + i] = load.point_on_platform[k];
  }
  for (const vjm::NodeLoad& node : load.nodes)
    key.insert(key.end(), {static_cast<double>(node.chain), static_cast<double>(node.node),
                           node.force.x(), node.force.y(), node.force.z()});
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

// The load from which a loaded reading is on its way back within its cycle: hysteresis depends on
// it. None on the way up.
std::vector<LoadKey> peaks(const Campaign& campaign, const std::vector<LoadDirection>& branch) {
  std::vector<LoadKey> result(campaign.readings.size(), LoadKey{});
  const std::vector<vjm::Load> loads = changing_loads(campaign);
  for (const Cycle& cycle : cycles_as_run(campaign))
    for (std::size_t k = 1; k < cycle.size(); ++k) {
      const std::size_t now = cycle[k], before = cycle[k - 1];
      if (branch[now] != LoadDirection::unloading || level_of(loads[now]) == 0 ||
          campaign.readings[now].configuration != campaign.readings[before].configuration)
        continue;
      result[now] = branch[before] == LoadDirection::unloading
                        ? result[before]
                        : key_of(campaign.readings[before].load);
    }
  return result;
}

using StateKey =
    std::tuple<std::size_t, LoadKey, LoadDirection, LoadKey, int, std::string, std::size_t>;

StateKey state_of(const Campaign& campaign, const Reading& reading, LoadDirection branch,
                  const LoadKey& peak, int side) {
  const bool own_datum =
      campaign.zero == ZeroReading::estimated || campaign.session_frame == SessionFrame::estimated;
  return {reading.configuration, key_of(reading.load),           branch, peak, side,
          reading.setting,       own_datum ? reading.session : 0};
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

double mean_sigma_square(const Campaign& campaign, const ReplicateGroup& group) {
  if (!campaign.noise_stated) return 1;
  double sum = 0;
  for (const std::size_t i : group.readings)
    sum += std::pow(campaign.readings[i].sigma[group.component], 2);
  return sum / static_cast<double>(group.readings.size());
}

// Half the squared differences of the first and second reading, the third and fourth, and so on.
double sum_over_pairs(const Campaign& campaign, const ReplicateGroup& group) {
  double sum = 0;
  for (std::size_t k = 1; k < group.readings.size(); k += 2) {
    const auto value = [&](std::size_t i) {
      return campaign.readings[group.readings[i]].displacement[group.component];
    };
    sum += std::pow(value(k) - value(k - 1), 2) / 2;
  }
  return sum;
}

double sum_about_mean(const Campaign& campaign, const ReplicateGroup& group) {
  double sum = 0, squares = 0;
  const auto count = static_cast<double>(group.readings.size());
  const double first = campaign.readings[group.readings[0]].displacement[group.component];
  for (const std::size_t i : group.readings) {
    const double value = campaign.readings[i].displacement[group.component] - first;
    sum += value;
    squares += value * value;
  }
  return squares - sum * sum / count;
}

// Chance that readings as far apart as these, in the order of their groups, scatter so much more
// than neighbours if all scatter alike: the contrasts are orthogonal, and the F test exact.
double chance_of_no_trend(const Campaign& campaign, const std::vector<ReplicateGroup>& groups) {
  double least = 1;
  for (const std::vector<Eigen::Index>& kind : component_kinds(campaign)) {
    double near = 0, far = 0, near_freedom = 0, far_freedom = 0;
    for (const ReplicateGroup& group : groups) {
      const bool is_of_kind = std::find(kind.begin(), kind.end(), group.component) != kind.end();
      if (!is_of_kind || group.readings.size() < 2) continue;
      const double unit = mean_sigma_square(campaign, group);
      const double pairs = sum_over_pairs(campaign, group) / unit;
      const auto number = static_cast<double>(group.readings.size() / 2);
      near += pairs;
      near_freedom += number;
      far += sum_about_mean(campaign, group) / unit - pairs;
      far_freedom += static_cast<double>(group.readings.size() - 1) - number;
    }
    if (near > 0 && far > 0 && far_freedom > 0)
      least = std::min(least, chance_of_larger_f((far / far_freedom) / (near / near_freedom),
                                                 far_freedom, near_freedom));
  }
  return least;
}

std::vector<ReplicateGroup> in_order_of(std::optional<double> Reading::*key,
                                        const Campaign& campaign,
                                        std::vector<ReplicateGroup> groups) {
  for (ReplicateGroup& group : groups)
    std::stable_sort(group.readings.begin(), group.readings.end(),
                     [&](std::size_t a, std::size_t b) {
                       return campaign.readings[a].*key < campaign.readings[b].*key;
                     });
  return groups;
}

std::vector<ReplicateGroup> in_pairs(const std::vector<ReplicateGroup>& groups) {
  std::vector<ReplicateGroup> result;
  for (const ReplicateGroup& group : groups)
    for (std::size_t k = 0; k < group.readings.size(); k += 2) {
      result.push_back({group.component, {group.readings[k]}});
      if (k + 1 < group.readings.size()) result.back().readings.push_back(group.readings[k + 1]);
    }
  return result;
}

// Where readings of one state differ the more the further apart in time or temperature they were
// taken, only neighbours are repetitions: the rest is drift, creep or expansion, and no noise.
std::vector<ReplicateGroup> without_trends(const Campaign& campaign,
                                           std::vector<ReplicateGroup> groups) {
  double least = 0.005;
  std::vector<ReplicateGroup> result = groups;
  for (const auto key : {&Reading::time, &Reading::temperature}) {
    if (!std::all_of(campaign.readings.begin(), campaign.readings.end(),
                     [key](const Reading& reading) { return (reading.*key).has_value(); }))
      continue;
    const std::vector<ReplicateGroup> ordered = in_order_of(key, campaign, groups);
    const double chance = chance_of_no_trend(campaign, ordered);
    if (chance >= least) continue;
    least = chance;
    result = in_pairs(ordered);
  }
  return result;
}

}  // namespace

std::vector<ReplicateGroup> replicate_groups(const Campaign& campaign) {
  // Value: number of the visit to this state within one replicate.
  std::map<std::tuple<StateKey, std::string, Eigen::Index>, int> visits;
  std::map<std::tuple<StateKey, int, Eigen::Index>, std::vector<std::size_t>> groups;
  const std::vector<LoadDirection> branch = branches(campaign);
  const std::vector<LoadKey> peak = peaks(campaign, branch);
  const std::vector<int> side = sides_of_return(campaign);
  for (const std::size_t i : in_order_of_time(campaign.readings)) {
    const Reading& reading = campaign.readings[i];
    const StateKey state = state_of(campaign, reading, branch[i], peak[i], side[i]);
    for (const Eigen::Index k : components_in_use(reading)) {
      const int visit = reading.replicate.empty() ? 0 : visits[{state, reading.replicate, k}]++;
      groups[{state, visit, k}].push_back(i);
    }
  }
  std::vector<ReplicateGroup> result;
  for (auto& [key, members] : groups) result.push_back({std::get<2>(key), std::move(members)});
  return without_trends(campaign, std::move(result));
}

}  // namespace kinetostat::calibration

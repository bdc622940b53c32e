#include "kinetostat/calibration/campaign/replicates.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <map>
#include <numeric>
#include <optional>
#include <string_view>
#include <tuple>

#include "kinetostat/calibration/campaign/datum.h"
#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/calibration/statistics/goodness_of_fit.h"

namespace kinetostat::calibration {
namespace {

// Directions that loads have, each with a number from 1.
class Sides {
 public:
  // 0 without load.
  int number_of(const vjm::Load& load) {
    constexpr double same = 0.95;  // cosine
    const spatial::Vector6 direction = direction_of(load);
    if (direction.isZero(0)) return 0;
    const auto found = std::find_if(known_.begin(), known_.end(), [&](const spatial::Vector6& d) {
      return d.dot(direction) > same;
    });
    const auto number = static_cast<int>(found - known_.begin()) + 1;
    if (found == known_.end()) known_.push_back(direction);
    return number;
  }

 private:
  std::vector<spatial::Vector6> known_;
};

// From which side a reading without load comes back within its cycle: friction and clearance keep
// it apart from those of other sides. 0 where it has load, or comes from none.
std::vector<int> sides_of_return(const Campaign& campaign) {
  std::vector<int> result(campaign.readings.size(), 0);
  const std::vector<vjm::Load> loads = changing_loads(campaign);
  Sides sides;
  for (const Cycle& cycle : cycles_as_run(campaign))
    for (std::size_t k = 1; k < cycle.size(); ++k) {
      const Reading &now = campaign.readings[cycle[k]], &before = campaign.readings[cycle[k - 1]];
      const vjm::Load& load_before = loads[cycle[k - 1]];
      if (level_of(loads[cycle[k]]) == 0 && now.configuration == before.configuration)
        result[cycle[k]] =
            level_of(load_before) == 0 ? result[cycle[k - 1]] : sides.number_of(load_before);
    }
  return result;
}

// The reading from whose load a loaded one is on its way back within its cycle: hysteresis depends
// on it. None on the way up.
std::vector<std::optional<std::size_t>> peaks(const Campaign& campaign,
                                              const std::vector<LoadDirection>& branch) {
  std::vector<std::optional<std::size_t>> result(campaign.readings.size());
  const std::vector<vjm::Load> loads = changing_loads(campaign);
  for (const Cycle& cycle : cycles_as_run(campaign))
    for (std::size_t k = 1; k < cycle.size(); ++k) {
      const std::size_t now = cycle[k], before = cycle[k - 1];
      if (branch[now] != LoadDirection::unloading || level_of(loads[now]) == 0 ||
          campaign.readings[now].configuration != campaign.readings[before].configuration)
        continue;
      result[now] = branch[before] == LoadDirection::unloading ? result[before] : before;
    }
  return result;
}

// What every model predicts to be equal has the same state.
class States {
 public:
  explicit States(const Campaign& campaign)
      : campaign_(campaign),
        own_datum_(campaign.zero == ZeroReading::estimated ||
                   campaign.session_frame == SessionFrame::estimated),
        branch_(branches(campaign)),
        peak_(peaks(campaign, branch_)),
        side_(sides_of_return(campaign)) {}

  /// Number of each reading's state, in their order.
  std::vector<std::size_t> numbers() const {
    std::vector<std::size_t> sorted(campaign_.readings.size());
    std::iota(sorted.begin(), sorted.end(), 0);
    std::sort(sorted.begin(), sorted.end(),
              [this](std::size_t a, std::size_t b) { return order(a, b) < 0; });
    std::vector<std::size_t> result(sorted.size());
    for (std::size_t k = 1; k < sorted.size(); ++k)
      result[sorted[k]] = result[sorted[k - 1]] + (order(sorted[k - 1], sorted[k]) < 0 ? 1 : 0);
    return result;
  }

 private:
  std::strong_ordering order(std::size_t a, std::size_t b) const {
    const Reading &first = campaign_.readings[a], &second = campaign_.readings[b];
    if (const auto o = first.configuration <=> second.configuration; o != 0) return o;
    if (const auto o = order_of_loads(a, b); o != 0) return o;
    if (const auto o = branch_[a] <=> branch_[b]; o != 0) return o;
    if (const auto o = peak_[a].has_value() <=> peak_[b].has_value(); o != 0) return o;
    if (peak_[a])
      if (const auto o = order_of_loads(*peak_[a], *peak_[b]); o != 0) return o;
    if (const auto o = side_[a] <=> side_[b]; o != 0) return o;
    if (const auto o = first.setting <=> second.setting; o != 0) return o;
    return own_datum_ ? first.session <=> second.session : std::strong_ordering::equal;
  }

  // Of what was set: that is the displacement where it is controlled.
  std::strong_ordering order_of_loads(std::size_t a, std::size_t b) const {
    if (!campaign_.control)
      return vjm::order_of(campaign_.readings[a].load, campaign_.readings[b].load);
    const auto& [set, force, to, beside, along] = *campaign_.control;
    if (to[a] < to[b]) return std::strong_ordering::less;
    if (to[b] < to[a]) return std::strong_ordering::greater;
    return vjm::order_of(beside[a], beside[b]);
  }

  const Campaign& campaign_;
  bool own_datum_;
  std::vector<LoadDirection> branch_;
  std::vector<std::optional<std::size_t>> peak_;
  std::vector<int> side_;
};

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

using Key = std::optional<double> Reading::*;

ReplicateGroup in_order_of(Key key, const Campaign& campaign, ReplicateGroup group) {
  std::stable_sort(group.readings.begin(), group.readings.end(), [&](std::size_t a, std::size_t b) {
    return campaign.readings[a].*key < campaign.readings[b].*key;
  });
  return group;
}

// Chance that readings as far apart as these, in the order of `key`, scatter so much more than
// neighbours if all scatter alike: the contrasts are orthogonal, and the F test exact.
double chance_of_no_trend(const Campaign& campaign, const std::vector<ReplicateGroup>& groups,
                          Key key) {
  double least = 1;
  for (const std::vector<Eigen::Index>& kind : component_kinds(campaign)) {
    double near = 0, far = 0, near_freedom = 0, far_freedom = 0;
    for (const ReplicateGroup& unordered : groups) {
      const bool is_of_kind =
          std::find(kind.begin(), kind.end(), unordered.component) != kind.end();
      if (!is_of_kind || unordered.readings.size() < 2) continue;
      const ReplicateGroup group = in_order_of(key, campaign, unordered);
      const double unit = mean_sigma_square(campaign, group);
      const double pairs = sum_over_pairs(campaign, group) / unit;
      const std::size_t number = group.readings.size() / 2;
      near += pairs;
      near_freedom += static_cast<double>(number);
      far += sum_about_mean(campaign, group) / unit - pairs;
      far_freedom += static_cast<double>(group.readings.size() - 1 - number);
    }
    if (near > 0 && far > 0 && far_freedom > 0)
      least = std::min(least, chance_of_larger_f((far / far_freedom) / (near / near_freedom),
                                                 far_freedom, near_freedom));
  }
  return least;
}

std::vector<ReplicateGroup> in_pairs(const Campaign& campaign,
                                     const std::vector<ReplicateGroup>& groups, Key key) {
  std::vector<ReplicateGroup> result;
  for (const ReplicateGroup& unordered : groups) {
    const ReplicateGroup group = in_order_of(key, campaign, unordered);
    for (std::size_t k = 0; k < group.readings.size(); k += 2) {
      result.push_back({group.component, {group.readings[k]}});
      if (k + 1 < group.readings.size()) result.back().readings.push_back(group.readings[k + 1]);
    }
  }
  return result;
}

// Where readings of one state differ the more the further apart in time or temperature they were
// taken, only neighbours are repetitions: the rest is drift, creep or expansion, and no noise.
std::vector<ReplicateGroup> without_trends(const Campaign& campaign,
                                           std::vector<ReplicateGroup> groups) {
  double least = 0.005;
  Key trend = nullptr;
  for (const Key key : {&Reading::time, &Reading::temperature}) {
    if (!std::all_of(campaign.readings.begin(), campaign.readings.end(),
                     [key](const Reading& reading) { return (reading.*key).has_value(); }))
      continue;
    const double chance = chance_of_no_trend(campaign, groups, key);
    if (chance >= least) continue;
    least = chance;
    trend = key;
  }
  if (trend == nullptr) return groups;
  return in_pairs(campaign, groups, trend);
}

// A value that is measured at a state: by the number of the state, of the visit to it within one
// replicate, and its component.
struct Visit {
  std::size_t state = 0, number = 0;
  Eigen::Index component = 0;
  std::size_t reading = 0;

  auto place() const { return std::tie(state, number, component); }
};

// In the order of time within a place.
std::vector<Visit> visits_of(const Campaign& campaign) {
  const std::vector<std::size_t> states = States(campaign).numbers();
  const std::vector<bool> is_datum = are_datums(campaign);
  std::map<std::tuple<std::size_t, std::string_view, Eigen::Index>, std::size_t> counts;
  std::vector<Visit> visits;
  for (const std::size_t i : in_order_of_time(campaign.readings)) {
    if (is_datum[i]) continue;
    const std::string& replicate = campaign.readings[i].replicate;
    for (const Eigen::Index k : components_in_use(campaign.readings[i])) {
      const std::size_t number = replicate.empty() ? 0 : counts[{states[i], replicate, k}]++;
      visits.push_back({states[i], number, k, i});
    }
  }
  std::stable_sort(visits.begin(), visits.end(),
                   [](const Visit& a, const Visit& b) { return a.place() < b.place(); });
  return visits;
}

}  // namespace

std::vector<ReplicateGroup> replicate_groups(const Campaign& campaign) {
  const std::vector<Visit> visits = visits_of(campaign);
  std::vector<ReplicateGroup> result;
  for (std::size_t k = 0; k < visits.size(); ++k) {
    if (k == 0 || visits[k - 1].place() != visits[k].place())
      result.push_back({visits[k].component, {}});
    result.back().readings.push_back(visits[k].reading);
  }
  return without_trends(campaign, std::move(result));
}

}  // namespace kinetostat::calibration

#include "kinetostat/calibration/campaign/load_history.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "kinetostat/calibration/sensors/weight.h"

namespace kinetostat::calibration {
namespace {

// A load that differs by less from the one before it is held, as a load cell reads it.
constexpr double held = 0.005;

spatial::Vector3 force_of(const vjm::Load& load) {
  return load.force + force_at_nodes(load) + load_in_joints(load).head<3>();
}
spatial::Vector3 moment_of(const vjm::Load& load) {
  return load.moment + load_in_joints(load).tail<3>();
}

// A load about the reference point, for comparing many with many.
struct Wrench {
  spatial::Vector3 force, moment;
  double level = 0, arm = 0;

  explicit Wrench(const vjm::Load& load)
      : force(force_of(load)),
        moment(load.at_reference_point(spatial::Pose()).tail<3>() + load_in_joints(load).tail<3>()),
        level(level_of(load)),
        arm(load.point_on_platform.norm()) {}
};

// Equal and opposite, as nearly as loads are that a cell has read. A wrench may be stated about
// another point: then the moments agree about the reference point.
bool opposite(const Wrench& a, const Wrench& b) {
  if (!(a.level > 0) || a.force.dot(b.force) > 0) return false;
  if ((a.force + b.force).norm() > same_load * a.level) return false;
  const double moment =
      std::max({a.moment.norm(), b.moment.norm(), std::max(a.arm, b.arm) * a.force.norm()});
  return (a.moment + b.moment).norm() <= same_load * moment;
}

bool is_constant(const std::vector<vjm::Load>& loads, const auto& component) {
  double least = component(loads.front()), most = least;
  for (const vjm::Load& load : loads) {
    least = std::min(least, component(load));
    most = std::max(most, component(load));
  }
  return most - least <= same_load * std::max(std::abs(least), std::abs(most));
}

bool share_a_point(const std::vector<vjm::Load>& loads) {
  return std::all_of(loads.begin(), loads.end(), [&](const vjm::Load& load) {
    return load.point_on_platform == loads.front().point_on_platform;
  });
}

bool is_ever_without(const std::vector<vjm::Load>& loads) {
  double force = 0, moment = 0;
  for (const vjm::Load& load : loads) {
    force = std::max(force, load.force.norm());
    moment = std::max(moment, load.moment.norm());
  }
  return std::any_of(loads.begin(), loads.end(), [&](const vjm::Load& load) {
    return load.force.norm() <= same_load * force && load.moment.norm() <= same_load * moment;
  });
}

// Forces and moments that all have in common become 0; where that is all there is, nothing does,
// and the answer is false.
bool take_off_constant(std::vector<vjm::Load>& loads) {
  spatial::Vector3 force, moment;  // 0 of what is constant, else 1
  for (Eigen::Index k = 0; k < 3; ++k) {
    force[k] = is_constant(loads, [k](const vjm::Load& load) { return load.force[k]; }) ? 0 : 1;
    moment[k] = is_constant(loads, [k](const vjm::Load& load) { return load.moment[k]; }) ? 0 : 1;
  }
  if (force.isZero(0) && moment.isZero(0)) return false;
  for (vjm::Load& load : loads) {
    load.force = load.force.cwiseProduct(force);
    load.moment = load.moment.cwiseProduct(moment);
  }
  return true;
}

// The load with which all cycles start, within same_load of how far loads go from it.
void take_off_start(const std::vector<Cycle>& cycles, std::vector<vjm::Load>& loads) {
  if (cycles.empty()) return;
  const vjm::Load start = loads[cycles.front().front()];
  const auto from_start = [&start](const vjm::Load& load) {
    return vjm::Load{.force = load.force - start.force, .moment = load.moment - start.moment};
  };
  double farthest = 0;
  for (const vjm::Load& load : loads) farthest = std::max(farthest, level_of(from_start(load)));
  for (const Cycle& cycle : cycles)
    if (level_of(from_start(loads[cycle.front()])) > same_load * farthest) return;
  for (vjm::Load& load : loads) {
    load.force -= start.force;
    load.moment -= start.moment;
  }
}

}  // namespace

std::vector<vjm::Load> changing_loads(const Campaign& campaign) {
  std::vector<vjm::Load> loads;
  loads.reserve(campaign.readings.size());
  bool others = false;  // weights, cylinders and torques
  for (const Reading& reading : campaign.readings) {
    loads.push_back(reading.load);
    others = others || !reading.load.nodes.empty() || !reading.load.joints.empty();
  }
  if (others || loads.empty() || !share_a_point(loads) || is_ever_without(loads)) return loads;
  if (take_off_constant(loads) && !is_ever_without(loads))
    take_off_start(cycles_as_run(campaign), loads);
  return loads;
}

double level_of(const vjm::Load& load) {
  const spatial::Vector3 force = force_of(load);
  return force.isZero(0) ? moment_of(load).norm() : force.norm();
}

spatial::Vector6 direction_of(const vjm::Load& load) {
  spatial::Vector6 direction = spatial::Vector6::Zero();
  if (const spatial::Vector3 force = force_of(load); !force.isZero(0))
    direction.head<3>() = force.normalized();
  else if (const spatial::Vector3 moment = moment_of(load); !moment.isZero(0))
    direction.tail<3>() = moment.normalized();
  return direction;
}

bool is_used(const Reading& reading) {
  return !reading.masked && !reading.displacement.array().isNaN().all();
}

std::vector<Cycle> cycles_as_run(const Campaign& campaign) {
  std::map<std::pair<std::size_t, std::string>, Cycle> found;
  for (std::size_t i = 0; i < campaign.readings.size(); ++i)
    if (const Reading& r = campaign.readings[i]; !r.cycle.empty())
      found[{r.session, r.cycle}].push_back(i);
  std::vector<Cycle> cycles;
  for (auto& [key, members] : found) {
    std::stable_sort(members.begin(), members.end(), [&campaign](std::size_t a, std::size_t b) {
      const Reading &x = campaign.readings[a], &y = campaign.readings[b];
      return std::tuple(x.step, x.time) < std::tuple(y.step, y.time);
    });
    cycles.push_back(std::move(members));
  }
  return cycles;
}

std::vector<Cycle> all_cycles(const Campaign& campaign) {
  std::vector<Cycle> result = cycles_as_run(campaign);
  for (std::size_t i = 0; i < campaign.readings.size(); ++i)
    if (campaign.readings[i].cycle.empty()) result.push_back({i});
  return result;
}

namespace {

// Those of a session as one where the history continues: in the order of time where all have one,
// else of rows.
std::vector<Cycle> runs_of(const Campaign& campaign) {
  std::vector<Cycle> cycles = all_cycles(campaign);
  if (!campaign.history_continues) return cycles;
  const bool timed = std::all_of(campaign.readings.begin(), campaign.readings.end(),
                                 [](const Reading& r) { return r.time.has_value(); });
  const auto key = [&](const Cycle& cycle) {
    const Reading& first = campaign.readings[cycle.front()];
    return std::tuple(first.session, timed ? *first.time : 0.0,
                      *std::min_element(cycle.begin(), cycle.end()));
  };
  std::sort(cycles.begin(), cycles.end(),
            [&key](const Cycle& a, const Cycle& b) { return key(a) < key(b); });
  std::vector<Cycle> result;
  for (const Cycle& cycle : cycles) {
    const bool goes_on = !result.empty() && campaign.readings[result.back().back()].session ==
                                                campaign.readings[cycle.front()].session;
    if (!goes_on) result.emplace_back();
    result.back().insert(result.back().end(), cycle.begin(), cycle.end());
  }
  return result;
}

}  // namespace

std::vector<Cycle> stretches_of(const Campaign& campaign, const std::vector<Cycle>& cycles) {
  std::vector<Cycle> result;
  for (const Cycle& cycle : cycles)
    for (std::size_t k = 0; k < cycle.size(); ++k) {
      const bool same = k > 0 && campaign.readings[cycle[k]].configuration ==
                                     campaign.readings[cycle[k - 1]].configuration;
      if (!same) result.emplace_back();
      result.back().push_back(cycle[k]);
    }
  return result;
}

std::vector<Cycle> histories_of(const Campaign& campaign) {
  return stretches_of(campaign, runs_of(campaign));
}

std::vector<Cycle> load_cycles(const Campaign& campaign) {
  std::vector<Cycle> cycles = cycles_as_run(campaign);
  for (Cycle& cycle : cycles)
    std::erase_if(cycle, [&](std::size_t i) { return !is_used(campaign.readings[i]); });
  std::erase_if(cycles, [](const Cycle& cycle) { return cycle.empty(); });
  return cycles;
}

std::vector<LoadDirection> branches(const Campaign& campaign) {
  return branches(campaign, changing_loads(campaign));
}

std::vector<LoadDirection> branches(const Campaign& campaign, const std::vector<vjm::Load>& loads) {
  std::vector<LoadDirection> result;
  for (const Reading& reading : campaign.readings) result.push_back(reading.direction);
  for (const Cycle& cycle : load_cycles(campaign))
    for (std::size_t k = 1; k < cycle.size(); ++k) {
      const Reading &now = campaign.readings[cycle[k]], &before = campaign.readings[cycle[k - 1]];
      if (now.direction != LoadDirection::unstated || now.configuration != before.configuration)
        continue;
      const double a = level_of(loads[cycle[k - 1]]), b = level_of(loads[cycle[k]]);
      if (std::abs(a - b) > held * std::max(a, b))
        result[cycle[k]] = b > a ? LoadDirection::loading : LoadDirection::unloading;
    }
  return result;
}

bool has_branch(const Campaign& campaign, LoadDirection branch) {
  const std::vector<LoadDirection> all = branches(campaign);
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i] == branch && is_used(campaign.readings[i])) return true;
  return false;
}

std::vector<std::pair<std::size_t, std::size_t>> reversed_pairs(const Campaign& campaign) {
  const std::vector<vjm::Load> loads = changing_loads(campaign);
  // In the order of ids, so that it does not depend on that of the rows.
  std::map<std::size_t, std::vector<std::size_t>> by_configuration;
  for (std::size_t i = 0; i < campaign.readings.size(); ++i)
    if (is_used(campaign.readings[i]))
      by_configuration[campaign.readings[i].configuration].push_back(i);
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  std::vector<bool> taken(campaign.readings.size());
  for (auto& [configuration, members] : by_configuration) {
    const auto key = [&](std::size_t i) {
      return std::tuple(level_of(loads[i]), std::string_view(campaign.readings[i].id));
    };
    std::sort(members.begin(), members.end(),
              [&key](std::size_t a, std::size_t b) { return key(a) < key(b); });
    std::vector<Wrench> wrenches;
    wrenches.reserve(members.size());
    for (const std::size_t i : members) wrenches.emplace_back(loads[i]);
    for (std::size_t a = 0; a < members.size(); ++a) {
      const double most = wrenches[a].level * (1 + same_load);
      for (std::size_t b = a + 1; b < members.size() && !taken[members[a]]; ++b) {
        if (wrenches[b].level > most) break;
        if (taken[members[b]] || !opposite(wrenches[a], wrenches[b])) continue;
        taken[members[a]] = taken[members[b]] = true;
        pairs.emplace_back(members[a], members[b]);
      }
    }
  }
  return pairs;
}

bool takes_loads_back(const Campaign& campaign) {
  return has_branch(campaign, LoadDirection::unloading) || !reversed_pairs(campaign).empty();
}

std::vector<double> distinct_values(std::vector<double> values, double tolerance) {
  std::sort(values.begin(), values.end());
  double size = 0;
  for (const double v : values) size = std::max(size, std::abs(v));
  std::vector<double> result;
  for (const double v : values)
    if (result.empty() || v - result.back() > tolerance * size) result.push_back(v);
  return result;
}

}  // namespace kinetostat::calibration

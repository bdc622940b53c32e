#include "kinetostat/calibration/regression/reading_offsets.h"

#include <algorithm>
#include <array>
#include <map>

#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/calibration/regression/instrument_lag.h"
#include "kinetostat/spatial/rotation.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;

constexpr std::size_t fewest = 3;  // readings, and cycles

Index value_that_names(const vjm::EffectKind& kind, vjm::NamesReadings names) {
  for (std::size_t k = 0; k < kind.parameters.size(); ++k)
    if (kind.parameters[k].names_readings == names) return static_cast<Index>(k);
  return -1;
}

// The times of the readings in use of each session, ascending; of those only that all have one.
std::map<std::size_t, std::vector<double>> times_of_sessions(
    const Campaign& campaign, const std::vector<vjm::ReadingMoment>& moments) {
  std::map<std::size_t, std::vector<double>> times;
  std::vector<bool> is_timed(campaign.sessions.size(), true);
  for (std::size_t r = 0; r < campaign.readings.size(); ++r) {
    const Reading& reading = campaign.readings[r];
    if (!is_used(reading)) continue;
    times[reading.session].push_back(moments[r].time);
    if (!reading.time) is_timed[reading.session] = false;
  }
  std::erase_if(times, [&](const auto& of_session) { return !is_timed[of_session.first]; });
  for (auto& [session, of_session] : times) std::sort(of_session.begin(), of_session.end());
  return times;
}

// Those of which enough readings are in use, but for the first, which the others are counted from.
std::vector<std::size_t> later_sessions(const Campaign& campaign) {
  std::map<std::size_t, std::size_t> used;
  for (const Reading& reading : campaign.readings) used[reading.session] += is_used(reading);
  std::erase_if(used, [](const auto& session) { return session.second < fewest; });
  std::vector<std::size_t> result;
  result.reserve(used.size());
  for (const auto& [session, count] : used) result.push_back(session);
  if (!result.empty()) result.erase(result.begin());
  return result;
}

// Whether a slip at that moment is tried for the whole session, which ends with the same cycle.
bool is_slip_of_session(const Campaign& campaign, const std::vector<vjm::ReadingMoment>& moments,
                        const vjm::ReadingMoment& slip) {
  std::size_t before = 0;
  for (std::size_t r = 0; r < moments.size(); ++r) {
    if (!is_used(campaign.readings[r]) || moments[r].session != slip.session) continue;
    if (!campaign.readings[r].time) return false;
    if (moments[r].time >= slip.time && moments[r].cycle != slip.cycle) return false;
    before += moments[r].time < slip.time;
  }
  return before >= fewest;
}

// Within a load cycle, and to its end: where differences are counted anew for each.
void add_slips_of_cycles(const vjm::Effect& effect, const Campaign& campaign,
                         std::vector<vjm::Effect>& slips) {
  const Index session = value_that_names(*effect.kind, vjm::NamesReadings::session);
  const Index time = value_that_names(*effect.kind, vjm::NamesReadings::time);
  const Index cycle = value_that_names(*effect.kind, vjm::NamesReadings::cycle);
  if (campaign.displacement != DisplacementKind::difference) return;
  const std::vector<vjm::ReadingMoment> moments = moments_of(campaign);
  const std::vector<Cycle> cycles = cycles_as_run(campaign);
  for (std::size_t c = 0; c < cycles.size() && cycles.size() > 1; ++c) {
    std::vector<std::size_t> used;
    for (const std::size_t r : cycles[c])
      if (is_used(campaign.readings[r]) && campaign.readings[r].time) used.push_back(r);
    std::stable_sort(used.begin(), used.end(), [&](std::size_t a, std::size_t b) {
      return moments[a].time < moments[b].time;
    });
    for (std::size_t k = 1; k + fewest <= used.size(); ++k) {
      if (moments[used[k]].time == moments[used[k - 1]].time ||
          is_slip_of_session(campaign, moments, moments[used[k]]))
        continue;
      vjm::Effect& slip = slips.emplace_back(effect);
      slip.values[session] = moments[used[k]].session;
      slip.values[time] = moments[used[k]].time;
      slip.values[cycle] = static_cast<double>(c + 1);
    }
  }
}

// Within a session, and between two.
std::vector<vjm::Effect> slips(const vjm::Effect& effect, const Campaign& campaign) {
  const Index session = value_that_names(*effect.kind, vjm::NamesReadings::session);
  const Index time = value_that_names(*effect.kind, vjm::NamesReadings::time);
  std::vector<vjm::Effect> result;
  for (const auto& [number, times] : times_of_sessions(campaign, moments_of(campaign)))
    for (std::size_t k = fewest; k + fewest <= times.size(); ++k) {
      if (times[k] == times[k - 1]) continue;
      vjm::Effect& slip = result.emplace_back(effect);
      slip.values[session] = static_cast<double>(number + 1);
      slip.values[time] = times[k];
    }
  for (const std::size_t number : later_sessions(campaign)) {
    vjm::Effect& slip = result.emplace_back(effect);
    slip.values[session] = static_cast<double>(number + 1);
    slip.values[time] = 0;
  }
  add_slips_of_cycles(effect, campaign, result);
  return result;
}

// Whether the axes of the platform are not the same in all readings in use.
bool turns(const Campaign& campaign, const PlatformAxes& axes) {
  constexpr double least = 0.02;  // [rad]
  std::optional<spatial::Matrix3> first;
  for (std::size_t r = 0; r < axes.size(); ++r) {
    if (!is_used(campaign.readings[r])) continue;
    const spatial::Matrix3 rotation = axes[r].topLeftCorner<3, 3>();
    if (!first) first = rotation;
    if (spatial::log_rotation(first->transpose() * rotation).norm() > least) return true;
  }
  return false;
}

// Then as many that turn along with the platform.
void add_those_that_turn(Index axes, std::vector<vjm::Effect>& all) {
  const std::size_t count = all.size();
  all.reserve(2 * count);
  for (std::size_t i = 0; i < count; ++i) all.emplace_back(all[i]).values[axes] = 1;
}

std::vector<vjm::Effect> bad_cycles(const vjm::Effect& effect, const Campaign& campaign) {
  const Index cycle = value_that_names(*effect.kind, vjm::NamesReadings::cycle);
  const std::vector<Cycle> cycles = cycles_as_run(campaign);
  std::vector<vjm::Effect> result;
  for (std::size_t c = 0; c < cycles.size(); ++c) {
    const auto used = std::count_if(cycles[c].begin(), cycles[c].end(),
                                    [&](std::size_t r) { return is_used(campaign.readings[r]); });
    if (used < static_cast<std::ptrdiff_t>(fewest)) continue;
    result.push_back(effect);
    result.back().values[cycle] = static_cast<double>(c + 1);
  }
  if (result.size() < fewest) result.clear();
  return result;
}

}  // namespace

bool is_of_cycles(const vjm::EffectKind& kind) {
  return value_that_names(kind, vjm::NamesReadings::session) < 0;
}

std::vector<vjm::ReadingMoment> moments_of(const Campaign& campaign) {
  std::vector<vjm::ReadingMoment> moments(campaign.readings.size());
  std::map<std::size_t, double> start;  // of sessions
  for (const Reading& r : campaign.readings)
    if (r.time) {
      const auto [found, fresh] = start.emplace(r.session, *r.time);
      found->second = std::min(found->second, *r.time);
    }
  for (std::size_t r = 0; r < moments.size(); ++r) {
    const Reading& reading = campaign.readings[r];
    moments[r].session = static_cast<double>(reading.session + 1);
    moments[r].time = reading.time ? *reading.time - start[reading.session] : 0;
  }
  const std::vector<Cycle> cycles = cycles_as_run(campaign);
  for (std::size_t c = 0; c < cycles.size(); ++c)
    for (const std::size_t r : cycles[c]) moments[r].cycle = static_cast<double>(c + 1);
  return moments;
}

ReadingOffsets::ReadingOffsets(const Campaign& campaign, const PlatformAxes& axes)
    : campaign_(campaign), axes_(axes), moments_(moments_of(campaign)) {}

Eigen::Matrix<double, 1, 6> ReadingOffsets::shown(const vjm::Effect& effect, std::size_t reading,
                                                  Index component) const {
  if (!may_lag(campaign_, component) || !effect.kind->is_off(moments_[reading], effect.values))
    return Eigen::Matrix<double, 1, 6>::Zero();
  const Index axis = campaign_.component(component).axis;
  if (axes_.empty() || !effect.kind->turns_along(effect.values))
    return spatial::Vector6::Unit(axis).transpose();
  if (campaign_.is_of_platform(component)) return axes_[reading].row(axis);
  return Eigen::Matrix<double, 1, 6>::Zero();
}

void add_offsets(const Campaign& campaign, const PlatformAxes& axes,
                 const std::vector<vjm::Effect>& effects,
                 const std::vector<vjm::ModelParameter>& parameters, Predictions& predictions) {
  const ReadingOffsets offsets(campaign, axes);
  for (std::size_t e = 0; e < effects.size(); ++e) {
    if (!effects[e].kind->offsets_readings) continue;
    std::array<std::optional<Index>, 6> columns;
    for (std::size_t v = 0; v < columns.size(); ++v)
      columns[v] = column_of(parameters, e, static_cast<Index>(v));
    for (std::size_t r = 0; r < campaign.readings.size(); ++r)
      for (Index k = 0; k < campaign.size(); ++k) {
        const auto shown = offsets.shown(effects[e], r, k);
        predictions.displacement[r][k] += shown.dot(effects[e].values.head<6>());
        if (predictions.derivatives.empty() || predictions.derivatives[r].rows() <= k) continue;
        for (std::size_t v = 0; v < columns.size(); ++v)
          if (columns[v])
            predictions.derivatives[r](k, *columns[v]) += shown[static_cast<Index>(v)];
      }
  }
}

std::vector<vjm::Effect> placements(const vjm::Effect& effect, const Campaign& campaign,
                                    const PlatformAxes& axes) {
  std::vector<vjm::Effect> all =
      is_of_cycles(*effect.kind) ? bad_cycles(effect, campaign) : slips(effect, campaign);
  const Index value = value_that_names(*effect.kind, vjm::NamesReadings::axes);
  if (value >= 0 && turns(campaign, axes)) add_those_that_turn(value, all);
  return all;
}

}  // namespace kinetostat::calibration

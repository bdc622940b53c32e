#include "kinetostat/calibration/regression/reading_offsets.h"

#include <algorithm>
#include <map>

#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/calibration/regression/instrument_lag.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;

constexpr std::size_t fewest = 3;  // readings, and cycles

// What one effect adds to one component.
void add_offset(const vjm::EffectKind& kind, const Eigen::VectorXd& values, Index axis,
                std::optional<Index> column, Index component,
                const std::vector<vjm::ReadingMoment>& moments, Predictions& predictions) {
  for (std::size_t r = 0; r < moments.size(); ++r) {
    if (!kind.is_off(moments[r], values)) continue;
    predictions.displacement[r][component] += values[axis];
    if (column && !predictions.derivatives.empty() && predictions.derivatives[r].rows() > component)
      predictions.derivatives[r](component, *column) += 1;
  }
}

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
  return result;
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

void add_offsets(const Campaign& campaign, const std::vector<vjm::Effect>& effects,
                 const std::vector<vjm::ModelParameter>& parameters, Predictions& predictions) {
  const std::vector<vjm::ReadingMoment> moments = moments_of(campaign);
  for (std::size_t e = 0; e < effects.size(); ++e) {
    if (!effects[e].kind->offsets_readings) continue;
    for (Index k = 0; k < campaign.size(); ++k) {
      const Index axis = campaign.component(k).axis;
      if (may_lag(campaign, k))
        add_offset(*effects[e].kind, effects[e].values, axis, column_of(parameters, e, axis), k,
                   moments, predictions);
    }
  }
}

std::vector<vjm::Effect> placements(const vjm::Effect& effect, const Campaign& campaign) {
  const bool is_of_cycles = value_that_names(*effect.kind, vjm::NamesReadings::cycle) >= 0;
  return is_of_cycles ? bad_cycles(effect, campaign) : slips(effect, campaign);
}

}  // namespace kinetostat::calibration

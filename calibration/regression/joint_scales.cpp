#include "kinetostat/calibration/regression/joint_scales.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/calibration/regression/instrument_lag.h"
#include "kinetostat/calibration/regression/reading_offsets.h"
#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;

constexpr double usual_lever = 0.3;  // [m] that is usual

// Least and largest of some values.
struct Range {
  double least = 0, most = 0;
  bool any = false;

  void add(double value) {
    least = any ? std::min(least, value) : value;
    most = any ? std::max(most, value) : value;
    any = true;
  }
};

double travel_of(const Predictor& predictor, const Predictions& predictions,
                 const Campaign& campaign, std::size_t chain, Index coordinate) {
  constexpr double rounding = 1e-9;
  std::map<std::size_t, Range> ranges;
  double farthest = 0;
  for (std::size_t r = 0; r < campaign.readings.size(); ++r) {
    const auto& loaded = predictions.loaded[r].coordinates;
    if (!is_used(campaign.readings[r]) || chain >= loaded.size()) continue;
    const double deflection =
        loaded[chain][coordinate] - predictor.posture_of(r).coordinates[chain][coordinate];
    ranges[campaign.readings[r].configuration].add(deflection);
    farthest = std::max(farthest, std::abs(deflection));
  }
  double travel = 0;
  for (const auto& [configuration, range] : ranges)
    travel = std::max(travel, range.most - range.least);
  return travel > rounding * farthest ? travel : farthest;
}

// Twice the largest distance of a reading of some sensor from the mean of its configuration, of
// translations [m] or of rotations [rad], whatever the axes; 0 where there is none.
double measured_change(const Campaign& campaign, const spatial::Dimension& dimension) {
  struct Mean {
    double sum = 0, count = 0;
    double value() const { return sum / count; }
  };
  double largest = 0;
  for (const std::vector<Index>& kind : component_kinds(campaign)) {
    if (campaign.component(kind.front()).dimension != dimension) continue;
    std::map<std::pair<std::size_t, Index>, Mean> means;  // by configuration
    for (const Reading& reading : campaign.readings)
      for (const Index k : kind) {
        if (!reading.uses(k)) continue;
        Mean& mean = means[{reading.configuration, k}];
        mean.sum += reading.displacement[k];
        mean.count += 1;
      }
    for (const Reading& reading : campaign.readings) {
      double square = 0;
      for (const Index k : kind)
        if (reading.uses(k))
          square +=
              std::pow(reading.displacement[k] - means[{reading.configuration, k}].value(), 2);
      largest = std::max(largest, square);
    }
  }
  return 2 * std::sqrt(largest);
}

// The same from what a fit predicts.
double unpredicted_change(const Campaign& campaign, const BaseFit& fit,
                          const spatial::Dimension& dimension) {
  double largest = 0;
  for (const std::vector<Index>& kind : component_kinds(campaign)) {
    if (campaign.component(kind.front()).dimension != dimension) continue;
    for (std::size_t r = 0; r < campaign.readings.size(); ++r) {
      double square = 0;
      for (const Index k : kind)
        if (campaign.readings[r].uses(k))
          square += std::pow(campaign.readings[r].displacement[k] - fit.predicted[r][k], 2);
      largest = std::max(largest, square);
    }
  }
  return 2 * std::sqrt(largest);
}

// The largest change that is read [m; rad], 0 where none is.
struct LargestChange {
  double shift = 0, turn = 0;

  LargestChange(const Campaign& campaign, const BaseFit& fit)
      : shift(of(campaign, fit, spatial::dimension::length)),
        turn(of(campaign, fit, spatial::dimension::angle)) {}

  // What a joint would move that is alone behind all that was measured; where it turns and only
  // translations were measured, or the reverse, at a usual lever.
  double play(bool turns) const {
    if (turns) return turn > 0 ? turn : shift / usual_lever;
    return shift > 0 ? shift : turn * usual_lever;
  }

 private:
  // Where poses are read, those of one configuration may not change at all.
  static double of(const Campaign& campaign, const BaseFit& fit,
                   const spatial::Dimension& dimension) {
    const double change = measured_change(campaign, dimension);
    if (campaign.displacement == DisplacementKind::difference) return change;
    return std::max(change, unpredicted_change(campaign, fit, dimension));
  }
};

// Of a joint [m or rad], in the order of their size.
std::vector<double> commands_of(const Predictor& predictor, const Campaign& campaign,
                                std::size_t chain, Index coordinate) {
  std::vector<double> commands;
  for (std::size_t r = 0; r < campaign.readings.size(); ++r)
    if (is_used(campaign.readings[r]))
      commands.push_back(predictor.posture_of(r).coordinates[chain][coordinate]);
  std::sort(commands.begin(), commands.end());
  return commands;
}

void add_commands(const std::vector<double>& sorted, vjm::JointScale& scale) {
  constexpr double apart = 0.01;  // of their range
  scale.commands = sorted.empty() ? 0 : 1;
  if (sorted.empty() || sorted.front() == sorted.back()) return;
  scale.span = sorted.back() - sorted.front();
  double last = sorted.front();
  for (const double command : sorted)
    if (command - last >= apart * scale.span) {
      ++scale.commands;
      last = command;
    }
}

// Scales of a thousandth of the largest, at the least.
void lift(const std::vector<vjm::JointScale*>& sort, double play) {
  constexpr double least = 1e-3;
  vjm::JointScale largest{.load = 0, .travel = 0, .play = 0};
  for (const vjm::JointScale* scale : sort) {
    largest.load = std::max(largest.load, scale->load);
    largest.travel = std::max(largest.travel, scale->travel);
  }
  for (vjm::JointScale* scale : sort) {
    if (!(largest.load > 0 && largest.travel > 0))
      *scale = {.commands = scale->commands, .span = scale->span};
    // A joint without a spring bears what the others do.
    if (scale->load == 0) scale->load = largest.load;
    scale->load = std::max(scale->load, least * largest.load);
    scale->travel = std::max(scale->travel, least * largest.travel);
    scale->play = std::max(scale->travel, play);
  }
}

// The longest time from the first reading of a session to its last; 0 where none has a time.
double longest_session(const Campaign& campaign) {
  std::map<std::size_t, Range> times;
  for (const Reading& reading : campaign.readings)
    if (reading.time) times[reading.session].add(*reading.time);
  double longest = 0;
  for (const auto& [session, range] : times) longest = std::max(longest, range.most - range.least);
  return longest;
}

// One row a reading in a cycle: how far it is from the mean of its configuration, in units of the
// noise.
Eigen::MatrixXd changes_in_cycles(const Campaign& campaign, const Noise& noise) {
  std::map<std::size_t, std::vector<std::size_t>> by_configuration;
  Index rows = 0;
  for (const Cycle& cycle : load_cycles(campaign))
    for (const std::size_t r : cycle) {
      by_configuration[campaign.readings[r].configuration].push_back(r);
      ++rows;
    }
  Eigen::MatrixXd changes = Eigen::MatrixXd::Zero(rows, campaign.size());
  for (Index k = 0; k < campaign.size(); ++k) {
    if (!may_lag(campaign, k)) continue;
    Index row = 0;
    for (const auto& [configuration, readings] : by_configuration) {
      double sum = 0, count = 0;
      for (const std::size_t r : readings)
        if (campaign.readings[r].uses(k)) sum += campaign.readings[r].displacement[k], ++count;
      for (const std::size_t r : readings) {
        if (campaign.readings[r].uses(k))
          changes(row, k) =
              (campaign.readings[r].displacement[k] - sum / count) / noise.sigma[r][k];
        ++row;
      }
    }
  }
  return changes;
}

// The play of an instrument differs from friction in a joint in that it does not follow where the
// joint moves the target: readings must move along more than one line, and back.
bool tell_lag(const Campaign& campaign, const Noise& noise) {
  constexpr double least_share = 0.1;  // of the second direction
  constexpr double seen = 3;           // times what noise alone makes of it
  if (campaign.displacement != DisplacementKind::difference ||
      campaign.session_frame == SessionFrame::estimated ||
      !has_branch(campaign, LoadDirection::unloading))
    return false;
  const Eigen::MatrixXd changes = changes_in_cycles(campaign, noise);
  if (changes.rows() < 3 || changes.cols() < 2) return false;
  const Eigen::VectorXd sizes = spatial::singular_values(changes);
  return sizes[1] > least_share * sizes[0] &&
         sizes[1] > seen * std::sqrt(static_cast<double>(changes.rows()));
}

vjm::Effect usual_offset(const std::string& name) {
  vjm::Effect effect{.kind = vjm::effect_kind(name), .at = "sensor", .sites = {}, .values = {}};
  effect.values.setZero(std::ssize(effect.kind->parameters));
  return effect;
}

// The largest force and moment that are stated; of what never is, the other at a usual lever.
void find_loads(const Campaign& campaign, vjm::ReadingScales& scales) {
  double force = 0, moment = 0;
  for (const Reading& reading : campaign.readings) {
    if (!is_used(reading)) continue;
    force = std::max(force, reading.load.force.norm());
    moment = std::max(moment, reading.load.moment.norm());
  }
  if (force == 0 && moment == 0) return;
  scales.force = force > 0 ? force : moment / usual_lever;
  scales.moment = moment > 0 ? moment : force * usual_lever;
}

}  // namespace

vjm::ReadingScales joint_scales(const Predictor& nominal, const vjm::Manipulator& bare,
                                const Campaign& campaign, const Noise& noise, const BaseFit& fit,
                                common::Progress& progress) {
  const Predictions predictions = nominal.predict({}, {}, false, progress);
  if (predictions.failure) return {};
  vjm::ReadingScales scales;
  scales.joints.resize(bare.size());
  const LargestChange change(campaign, fit);
  if (change.shift > 0) scales.shift = change.shift;
  if (change.turn > 0) scales.turn = change.turn;
  if (const double session = longest_session(campaign); session > 0) scales.session = session;
  find_loads(campaign, scales);
  scales.tell_lag = tell_lag(campaign, noise);
  scales.differences = campaign.displacement == DisplacementKind::difference;
  const PlatformAxes axes = nominal.platform_axes();
  scales.slips = placements(usual_offset("target_slip"), campaign, axes).size();
  scales.cycles = placements(usual_offset("cycle_offset"), campaign, axes).size();
  std::vector<vjm::JointScale*> slides, turns;
  for (std::size_t c = 0; c < bare.size(); ++c) {
    const vjm::Chain& chain = bare.chains()[c];
    scales.joints[c].assign(static_cast<std::size_t>(chain.size()),
                            {.load = 0, .travel = 0, .play = 0});
    for (Index k = 0; k < chain.size(); ++k) {
      vjm::JointScale& scale = scales.joints[c][static_cast<std::size_t>(k)];
      const vjm::Coordinate& coordinate = chain.coordinates()[static_cast<std::size_t>(k)];
      (vjm::is_rotation(coordinate.motion) ? turns : slides).push_back(&scale);
      add_commands(commands_of(nominal, campaign, c, k), scale);
      if (!(chain.stiffness()(k, k) > 0) || coordinate.role == vjm::Role::elastic) continue;
      scale.travel = travel_of(nominal, predictions, campaign, c, k);
      scale.load = chain.stiffness()(k, k) * scale.travel;
    }
  }
  lift(slides, change.play(false));
  lift(turns, change.play(true));
  return scales;
}

}  // namespace kinetostat::calibration

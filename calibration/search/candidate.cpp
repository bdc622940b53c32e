#include "kinetostat/calibration/search/candidate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/calibration/regression/reading_offsets.h"
#include "kinetostat/calibration/search/usual_values.h"
#include "kinetostat/vjm/chain/kinematics.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

double within(const vjm::EffectParameter& parameter, double value) {
  return std::clamp(value, parameter.lower, parameter.upper);
}

bool has(const vjm::Robot& robot, const vjm::Effect& wanted) {
  return std::any_of(robot.effects.begin(), robot.effects.end(), [&](const vjm::Effect& effect) {
    return effect.kind->name == wanted.kind->name && effect.at == wanted.at;
  });
}

bool same_sites(const vjm::Effect& a, const vjm::Effect& b) {
  return a.kind->name == b.kind->name &&
         std::equal(a.sites.begin(), a.sites.end(), b.sites.begin(), b.sites.end(),
                    [](const vjm::EffectSite& x, const vjm::EffectSite& y) {
                      return x.chain == y.chain && x.element == y.element;
                    });
}

bool is_fixed(const Candidate& candidate, Index value) {
  return std::find(candidate.fixed.begin(), candidate.fixed.end(), value) != candidate.fixed.end();
}

// Whether nothing weighs in the model with these effects.
bool is_weightless(const vjm::Manipulator& bare, const std::vector<vjm::Effect>& present) {
  return !vjm::with_effects(bare, present).has_weight();
}

// Whether the columns of two signatures are the same but for their lengths.
bool point_alike(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  constexpr double nearly = 0.01;  // between unit vectors
  if (a.cols() != b.cols()) return false;
  for (Index k = 0; k < a.cols(); ++k) {
    const double lengths = a.col(k).norm() * b.col(k).norm();
    if (lengths == 0 ? a.col(k).norm() != b.col(k).norm()
                     : a.col(k).dot(b.col(k)) < (1 - nearly * nearly / 2) * lengths)
      return false;
  }
  return true;
}

// Whether a value is the order of another one of its kind at its place.
bool is_taken(const vjm::Effect& effect, Index value, double order,
              const std::vector<vjm::Effect>& present) {
  if (!effect.kind->parameters[static_cast<std::size_t>(value)].is_order) return false;
  return std::any_of(present.begin(), present.end(), [&](const vjm::Effect& other) {
    return other.kind->name == effect.kind->name && other.at == effect.at &&
           other.values[value] == order;
  });
}

// An axis along gravity that stays so, because all joints before it turn about such axes: no weight
// can have a moment about it. A screw along gravity lifts all the same.
bool stays_vertical(const vjm::Chain& chain, Index coordinate, const spatial::Vector3& gravity) {
  vjm::ChainKinematics kinematics;
  vjm::evaluate(chain, chain.home(), kinematics);
  for (Index k = 0; k <= coordinate; ++k) {
    const vjm::Coordinate& c = chain.coordinates()[static_cast<std::size_t>(k)];
    const spatial::Vector3 axis = kinematics.jacobian.col(k).tail<3>();
    if (c.role == vjm::Role::elastic || axis.isZero(0)) continue;
    if (axis.cross(gravity).norm() > 1e-6 * gravity.norm()) return false;
  }
  const double rise = kinematics.jacobian.col(coordinate).head<3>().dot(gravity);
  return std::abs(rise) <= 1e-6 * gravity.norm() * kinematics.reach;
}

// A drive about which weight may turn a chain, as far as gravity is known.
bool lifts_weight(const vjm::Chain& chain, Index coordinate, const vjm::Manipulator& bare,
                  bool from_base) {
  const vjm::Coordinate& c = chain.coordinates()[static_cast<std::size_t>(coordinate)];
  if (c.role != vjm::Role::actuated || !vjm::is_rotation(c.motion)) return false;
  return bare.gravity().isZero(0) || !from_base ||
         !stays_vertical(chain, coordinate, bare.gravity());
}

// Balancers sit at the first two axes of a chain that lift, which carry all behind them; three
// where it is not known which lift. Elsewhere their five values are but a confounder of other
// errors of a drive.
bool may_be_balanced(const vjm::EffectSite& site, const vjm::Manipulator& bare) {
  const vjm::Chain& chain = bare.chains()[site.chain];
  const bool from_base = bare.span(site.chain).from == vjm::Span::base;
  const Index k = chain.index_of(site.element);
  if (!lifts_weight(chain, k, bare, from_base)) return false;
  int before = 0;
  for (Index i = 0; i < k; ++i) before += lifts_weight(chain, i, bare, from_base) ? 1 : 0;
  return before < (bare.gravity().isZero(0) ? 3 : 2);
}

// What balances a weight that the model does not have is an eccentric drive in poses.
bool is_weightless_in_poses(const vjm::Manipulator& bare, const vjm::ReadingScales& scales) {
  return bare.gravity().isZero(0) && !scales.differences;
}

// How many the readings have of a joint; enough where nothing is known of them.
int commands_of(const vjm::EffectSite& site, const vjm::Manipulator& bare,
                const vjm::ReadingScales& scales) {
  if (scales.joints.empty()) return std::numeric_limits<int>::max();
  const Index k = bare.chains()[site.chain].index_of(site.element);
  return scales.joints[site.chain][static_cast<std::size_t>(k)].commands;
}

// In how many ways an effect may be of some readings only.
std::size_t readings_named(const vjm::EffectKind& kind, const vjm::ReadingScales& scales) {
  const bool of_cycles = is_of_cycles(kind);
  return of_cycles ? scales.cycles : scales.slips;
}

std::optional<Candidate> candidate_at(const vjm::Robot& robot,
                                      const std::shared_ptr<const vjm::EffectKind>& kind,
                                      const std::string& place, const vjm::ReadingScales& scales) {
  const vjm::Manipulator& bare = robot.without_effects();
  Candidate candidate;
  candidate.effect = {.kind = kind,
                      .at = place,
                      .sites = vjm::effect_sites(*kind, bare, place),
                      .values = VectorXd(static_cast<Index>(kind->parameters.size()))};
  if ((has(robot, candidate.effect) && !may_act_again(*kind)) ||
      (kind->lags_behind && !scales.tell_lag) || (kind->is_of_gauges && !scales.differences) ||
      (kind->balances_weight && is_weightless_in_poses(bare, scales)))
    return std::nullopt;
  const bool is_asked_more = kind->balances_weight || kind->least_commands > 1;
  if (is_asked_more &&
      std::none_of(candidate.effect.sites.begin(), candidate.effect.sites.end(),
                   [&](const vjm::EffectSite& site) {
                     return (!kind->balances_weight || may_be_balanced(site, bare)) &&
                            commands_of(site, bare, scales) >= kind->least_commands;
                   }))
    return std::nullopt;
  for (std::size_t k = 0; k < kind->parameters.size(); ++k) {
    const vjm::EffectParameter& parameter = kind->parameters[k];
    const auto i = static_cast<Index>(k);
    candidate.effect.values[i] = parameter.none;
    const double deviation = vjm::prior_deviation(candidate.effect, i, bare, scales);
    candidate.deviations.push_back(deviation);
    if (!(deviation > 0) || !std::isfinite(deviation)) return std::nullopt;
    if (is_size(*kind, k) || parameter.required)
      candidate.effect.values[i] = within(parameter, parameter.none + deviation);
    const bool is_seen = (!parameter.is_of_differences || scales.differences) &&
                         (!parameter.is_of_weight || !bare.gravity().isZero(0));
    if (!is_seen) candidate.fixed.push_back(i);
    // Two or three variants of a law stand for each other.
    constexpr std::size_t few = 3;
    const std::size_t usual = usual_values(candidate.effect, i, bare).size();
    if (is_seen && usual > 0 && (parameter.is_order || usual > few)) candidate.designs *= usual;
  }
  if (kind->offsets_readings) candidate.designs = readings_named(*kind, scales);
  if (candidate.designs == 0) return std::nullopt;
  return candidate;
}

}  // namespace

std::string Candidate::name() const {
  return fmt::format("{} at {}", effect.kind->name, effect.at);
}

std::vector<std::string> names_of(const std::vector<Candidate>& candidates) {
  std::vector<std::string> names;
  names.reserve(candidates.size());
  for (const Candidate& candidate : candidates) names.push_back(candidate.name());
  return names;
}

std::vector<Candidate> candidates(const vjm::Robot& robot, const std::vector<std::string>& kinds,
                                  const vjm::ReadingScales& scales) {
  std::vector<Candidate> result;
  for (const auto& kind : robot.kinds()) {
    if (!kinds.empty() && std::find(kinds.begin(), kinds.end(), kind->name) == kinds.end())
      continue;
    if (kind->parameters.empty()) continue;  // a formula that is what it is: nothing to find
    for (const std::string& place : vjm::effect_places(*kind, robot.without_effects())) {
      // Some kinds cannot act at every place of their sort: a joint without a spring, say.
      try {
        auto candidate = candidate_at(robot, kind, place, scales);
        // With one chain a joint of it and that joint of every chain are the same.
        if (candidate && std::none_of(result.begin(), result.end(), [&](const Candidate& other) {
              return same_sites(other.effect, candidate->effect);
            })) {
          (void)vjm::with_effects(robot.without_effects(), {candidate->effect});
          result.push_back(std::move(*candidate));
        }
      } catch (const std::invalid_argument&) {
        continue;
      }
    }
  }
  return result;
}

std::vector<KindWithoutPlace> kinds_without_place(const vjm::Robot& robot,
                                                  const std::vector<std::string>& kinds,
                                                  const vjm::ReadingScales& scales) {
  const std::vector<Candidate> all = candidates(robot, kinds, scales);
  std::vector<KindWithoutPlace> result;
  for (const auto& kind : robot.kinds()) {
    const auto is_of_kind = [&](const vjm::Effect& effect) {
      return effect.kind->name == kind->name;
    };
    const bool asked =
        kinds.empty() || std::find(kinds.begin(), kinds.end(), kind->name) != kinds.end();
    if (!asked || kind->parameters.empty() ||
        std::any_of(robot.effects.begin(), robot.effects.end(), is_of_kind) ||
        std::any_of(all.begin(), all.end(),
                    [&](const Candidate& candidate) { return is_of_kind(candidate.effect); }))
      continue;
    const std::string reason =
        kind->balances_weight && is_weightless_in_poses(robot.without_effects(), scales)
            ? "the robot file states no 'gravity', and in poses it looks like an eccentric drive"
        : kind->balances_weight
            ? "none of the first axes that lift weight is moved in these readings"
        : kind->least_commands > 1
            ? fmt::format("no joint with a spring is at {} or more commands in these readings",
                          kind->least_commands)
        : kind->offsets_readings
            ? std::string(is_of_cycles(*kind)
                              ? "there are no three load cycles of three readings each"
                              : "no session has six readings or more that all have a time")
        : kind->is_of_gauges ? "it is an error of gauges, and these readings are poses"
        : kind->lags_behind
            ? "the readings do not move along several lines and back, and so look the same with "
              "friction in a joint"
        : kind->place == vjm::EffectPlace::mass
            ? "no link of the robot file yields or has a 'mass'"
            : fmt::format("the robot has no {} on which it could act", vjm::to_string(kind->place));
    result.push_back({kind->name, reason});
  }
  return result;
}

std::vector<FittedValues> fitted_values(const BaseFit& fit, const std::vector<Candidate>& added) {
  auto estimate = fit.parameters.end();
  for (const Candidate& candidate : added) estimate -= candidate.effect.values.size();
  std::vector<FittedValues> result;
  for (const Candidate& candidate : added) {
    const Index count = candidate.effect.values.size();
    FittedValues fitted{VectorXd(count), VectorXd(count)};
    for (Index k = 0; k < count; ++k, ++estimate) {
      fitted.values[k] = estimate->value;
      fitted.deviations[k] = estimate->hit == BoundHit::none
                                 ? estimate->standard_error
                                 : std::numeric_limits<double>::quiet_NaN();
    }
    result.push_back(std::move(fitted));
  }
  return result;
}

std::vector<vjm::Effect> effects_with(const vjm::Robot& robot,
                                      const std::vector<Candidate>& added) {
  std::vector<vjm::Effect> effects = robot.effects;
  for (const Candidate& candidate : added) effects.push_back(candidate.effect);
  return effects;
}

bool is_size(const vjm::EffectKind& kind, std::size_t value) {
  return value == 0 || (kind.acts_on_numbers() && !kind.parameters[value].is_shape);
}

double times_usual(const Candidate& candidate, const Eigen::VectorXd& values) {
  double most = 0;
  for (std::size_t k = 0; k < candidate.deviations.size(); ++k) {
    const vjm::EffectParameter& p = candidate.effect.kind->parameters[k];
    const double size = std::abs(values[static_cast<Eigen::Index>(k)] - p.none);
    if (!p.is_shape) most = std::max(most, size / candidate.deviations[k]);
  }
  return most;
}

bool can_only_grow(const vjm::EffectParameter& parameter) {
  return parameter.lower >= parameter.none;
}

Candidate at_size(const Candidate& candidate, double leading, double others) {
  Candidate result = candidate;
  const auto& parameters = candidate.effect.kind->parameters;
  for (std::size_t k = 0; k < parameters.size(); ++k)
    if (const bool leads = is_size(*candidate.effect.kind, k); leads || parameters[k].required)
      result.effect.values[static_cast<Index>(k)] = within(
          parameters[k], parameters[k].none + (leads ? leading : others) * candidate.deviations[k]);
  return result;
}

std::vector<TriedSizes> sizes_of(const vjm::EffectKind& kind) {
  const auto& parameters = kind.parameters;
  const vjm::EffectParameter& leading = parameters.front();
  std::vector<TriedSizes> all = {{{1, 1}, {0.2, 1}}};
  if (leading.lower == leading.none) all[0].insert(all[0].end(), {{0.04, 1}, {0.008, 1}});
  if (leading.lower < leading.none) all.push_back({{-1, 1}});
  const bool has_others = std::any_of(parameters.begin() + 1, parameters.end(),
                                      [](const auto& parameter) { return parameter.required; });
  if (has_others) all.push_back({{1, 0.2}, {1, 0.04}, {1, 0.008}});
  // A shape of either sign.
  if (std::any_of(parameters.begin() + 1, parameters.end(), [](const auto& parameter) {
        return parameter.required && parameter.lower < parameter.none;
      }))
    all.push_back({{1, -1}, {1, -0.2}});
  return all;
}

bool is_of_series(const vjm::EffectKind& kind) {
  return std::any_of(kind.parameters.begin(), kind.parameters.end(),
                     [](const vjm::EffectParameter& parameter) { return parameter.is_order; });
}

bool may_act_again(const vjm::EffectKind& kind) {
  return kind.offsets_readings || is_of_series(kind);
}

std::vector<Candidate> designs_of(const Candidate& candidate, const vjm::Manipulator& bare,
                                  const std::vector<vjm::Effect>& present) {
  std::vector<Candidate> designs = {candidate};
  for (Index k = 0; k < candidate.effect.values.size(); ++k) {
    const std::vector<double>& usual = usual_values(candidate.effect, k, bare);
    if (usual.empty() || is_fixed(candidate, k)) continue;
    if (candidate.effect.kind->parameters[static_cast<std::size_t>(k)].is_of_weight &&
        is_weightless(bare, present))
      continue;
    std::vector<Candidate> more;
    for (const Candidate& design : designs)
      for (const double value : usual) {
        if (is_taken(candidate.effect, k, value, present)) continue;
        more.push_back(design);
        more.back().effect.values[k] = value;
      }
    designs = std::move(more);
  }
  // The first acts, or there were no candidate.
  std::erase_if(designs, [&](const Candidate& design) {
    return &design != designs.data() && !vjm::can_act(design.effect, bare);
  });
  return designs;
}

void CandidateSignatures::drop_repetitions() {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto end = all.begin() + static_cast<std::ptrdiff_t>(kept);
    if (std::any_of(all.begin(), end, [&](const Signature& earlier) {
          return point_alike(earlier.columns, all[i].columns);
        }))
      continue;
    if (kept != i) {
      all[kept] = std::move(all[i]);
      starts[kept] = std::move(starts[i]);
    }
    ++kept;
  }
  all.resize(kept);
  starts.resize(kept);
}

}  // namespace kinetostat::calibration

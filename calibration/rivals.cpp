#include "kinetostat/calibration/rivals.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "kinetostat/calibration/evidence.h"
#include "kinetostat/calibration/fit_record.h"
#include "kinetostat/calibration/load_history.h"
#include "kinetostat/calibration/undetermined.h"
#include "kinetostat/calibration/unit_slip.h"
#include "kinetostat/files/error.h"
#include "kinetostat/vjm/kinematics.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double within(const vjm::EffectParameter& parameter, double value) {
  return std::clamp(value, parameter.lower, parameter.upper);
}

// The candidate with its leading value at `leading` times its usual distance from nothing, and what
// else must be given at `others` times.
Candidate at_size(const Candidate& candidate, double leading, double others) {
  Candidate result = candidate;
  const auto& parameters = candidate.effect.kind->parameters;
  for (std::size_t k = 0; k < parameters.size(); ++k)
    if (k == 0 || parameters[k].required)
      result.effect.values[static_cast<Index>(k)] =
          within(parameters[k],
                 parameters[k].none + (k == 0 ? leading : others) * candidate.deviations[k]);
  return result;
}

// Sizes at which the shape of a signature is looked at: gaps, breakaway forces and corners show
// another shape when they are small beside what the readings do to them.
std::vector<std::pair<double, double>> sizes_of(const vjm::EffectKind& kind) {
  const auto& parameters = kind.parameters;
  std::vector<std::pair<double, double>> sizes = {{1, 1}, {0.2, 1}};
  if (parameters.front().lower < parameters.front().none) sizes.emplace_back(-1, 1);
  if (parameters.front().lower == parameters.front().none)
    sizes.insert(sizes.end(), {{0.04, 1}, {0.008, 1}});
  const bool has_others = std::any_of(parameters.begin() + 1, parameters.end(),
                                      [](const auto& parameter) { return parameter.required; });
  if (has_others) sizes.insert(sizes.end(), {{1, 0.2}, {1, 0.04}, {1, 0.008}});
  return sizes;
}

// Signatures of two sizes, the first and the one after it, that differ by no more than their
// length.
bool is_proportional(const std::vector<Signature>& signatures, std::size_t first, double ratio) {
  const VectorXd large = signatures[first].columns.col(0);
  const VectorXd small = signatures[first + 1].columns.col(0);
  return (small - ratio * large).norm() < 0.02 * ratio * large.norm();
}

// What design fixes about a value of an effect; empty when readings must tell it.
const std::vector<double>& usual_values(const vjm::Effect& effect, Index value,
                                        const vjm::Manipulator& bare) {
  const vjm::EffectParameter& p = effect.kind->parameters[static_cast<std::size_t>(value)];
  return vjm::turns(effect, bare) ? p.usual_angular : p.usual_linear;
}

// The candidate with each of the values that design may have fixed.
std::vector<Candidate> designs_of(const Candidate& candidate, const vjm::Manipulator& bare) {
  std::vector<Candidate> designs = {candidate};
  for (Index k = 0; k < candidate.effect.values.size(); ++k) {
    const std::vector<double>& usual = usual_values(candidate.effect, k, bare);
    if (usual.empty()) continue;
    std::vector<Candidate> more;
    for (const Candidate& design : designs)
      for (const double value : usual) {
        more.push_back(design);
        more.back().effect.values[k] = value;
      }
    designs = std::move(more);
  }
  return designs;
}

// By how much a signature must grow to be seen. A usual size is a guess; an effect ten times as
// large is rare but real.
double growth_to_be_seen(double length) {
  constexpr double seen = 1, most = 10;
  return length >= seen || length < least_visible / most ? 1 : most;
}

double usual_interval(const Campaign& campaign) {
  std::vector<double> intervals;
  for (const Cycle& cycle : load_cycles(campaign))
    for (std::size_t k = 1; k < cycle.size(); ++k) {
      const auto &now = campaign.readings[cycle[k]].time,
                 &before = campaign.readings[cycle[k - 1]].time;
      if (now && before) intervals.push_back(*now - *before);
    }
  if (intervals.empty()) return 0;
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

// A time over which an effect comes or goes: readings farther apart do not determine it.
bool is_duration(const vjm::EffectParameter& parameter) {
  return parameter.is_shape && parameter.linear == spatial::dimension::time;
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

// A drive of a joint that weight may turn, as far as gravity is known.
bool lifts_weight(const vjm::EffectSite& site, const vjm::Manipulator& bare) {
  const vjm::Chain& chain = bare.chains()[site.chain];
  const Index k = chain.index_of(site.element);
  if (chain.coordinates()[static_cast<std::size_t>(k)].role != vjm::Role::actuated) return false;
  const bool from_base = bare.span(site.chain).from == vjm::Span::base;
  return bare.gravity().isZero(0) || !from_base || !stays_vertical(chain, k, bare.gravity());
}

std::optional<Candidate> candidate_at(const vjm::Robot& robot,
                                      const std::shared_ptr<const vjm::EffectKind>& kind,
                                      const std::string& place) {
  const vjm::Manipulator& bare = robot.without_effects();
  Candidate candidate;
  candidate.effect = {.kind = kind,
                      .at = place,
                      .sites = vjm::effect_sites(*kind, bare, place),
                      .values = VectorXd(static_cast<Index>(kind->parameters.size()))};
  if (has(robot, candidate.effect)) return std::nullopt;
  if (kind->balances_weight &&
      std::none_of(candidate.effect.sites.begin(), candidate.effect.sites.end(),
                   [&](const vjm::EffectSite& site) { return lifts_weight(site, bare); }))
    return std::nullopt;
  for (std::size_t k = 0; k < kind->parameters.size(); ++k) {
    const vjm::EffectParameter& parameter = kind->parameters[k];
    const auto i = static_cast<Index>(k);
    candidate.effect.values[i] = parameter.none;
    const double deviation = vjm::prior_deviation(candidate.effect, i, bare);
    candidate.deviations.push_back(deviation);
    if (!(deviation > 0) || !std::isfinite(deviation)) return std::nullopt;
    if (k == 0 || parameter.required)
      candidate.effect.values[i] = within(parameter, parameter.none + deviation);
    candidate.designs *= std::max<std::size_t>(1, usual_values(candidate.effect, i, bare).size());
  }
  return candidate;
}

// Adds to each uncertain stiffness that design tells it; returns whether there is any. The range
// keeps it where readings still depend on it, for the effect that sets it right.
bool believe_design(std::vector<Parameter>& parameters) {
  constexpr double deviation = 1, farthest = 3;  // factors of e
  bool any = false;
  for (Parameter& p : parameters)
    if (p.is_logarithm() && !p.bounds_stated) {
      p.prior = Parameter::Prior{.mean = p.start, .deviation = deviation};
      p.lower = p.start - farthest * deviation;
      p.upper = p.start + farthest * deviation;
      p.bounds_stated = any = true;
    }
  return any;
}

// The first `count` unknowns start where another fit has them, which may know them by design.
void begin_at(const BaseFit& start, std::size_t count, std::vector<Parameter>& unknowns) {
  for (std::size_t k = 0; k < count; ++k) {
    const auto& [there, value, error, hit] = start.parameters[k];
    Parameter& p = unknowns[k];
    p.start = value;
    if (!there.prior || p.bounds_stated) continue;
    p.prior = there.prior;
    p.lower = there.lower;
    p.upper = there.upper;
    p.bounds_stated = true;
  }
}

}  // namespace

std::string Candidate::name() const {
  return fmt::format("{} at {}", effect.kind->name, effect.at);
}

std::vector<Candidate> candidates(const vjm::Robot& robot, const std::vector<std::string>& kinds) {
  std::vector<Candidate> result;
  for (const auto& kind : robot.kinds()) {
    if (!kinds.empty() && std::find(kinds.begin(), kinds.end(), kind->name) == kinds.end())
      continue;
    if (kind->parameters.empty()) continue;  // a formula that is what it is: nothing to find
    for (const std::string& place : vjm::effect_places(*kind, robot.without_effects())) {
      // Some kinds cannot act at every place of their sort: a joint without a spring, say.
      try {
        auto candidate = candidate_at(robot, kind, place);
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
                                                  const std::vector<std::string>& kinds) {
  const std::vector<Candidate> all = candidates(robot, kinds);
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
    result.push_back({kind->name, kind->place == vjm::EffectPlace::mass
                                      ? "no link of the robot file yields or has a 'mass'"
                                      : fmt::format("the robot has no {} on which it could act",
                                                    vjm::to_string(kind->place))});
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

bool is_held_near_design(const BaseFit& fit) {
  return std::any_of(fit.parameters.begin(), fit.parameters.end(), [](const auto& estimate) {
    return estimate.parameter.is_logarithm() && estimate.parameter.prior;
  });
}

std::vector<vjm::Effect> effects_with(const vjm::Robot& robot,
                                      const std::vector<Candidate>& added) {
  std::vector<vjm::Effect> effects = robot.effects;
  for (const Candidate& candidate : added) effects.push_back(candidate.effect);
  return effects;
}

CandidateFitter::CandidateFitter(const vjm::Robot& robot, const Campaign& campaign,
                                 const Noise& noise, int threads, files::Progress& progress,
                                 FitJournal* journal)
    : robot_(robot),
      campaign_(campaign),
      noise_(noise),
      predictor_(robot.without_effects(), robot.effects, campaign, threads, progress),
      base_(uncertain_parameters(robot)),
      journal_(journal),
      scope_(journal == nullptr ? "" : fit_scope(campaign, noise)),
      interval_(usual_interval(campaign)) {
  kept_ = keep_undetermined(predictor_, campaign, noise, base_, progress);
}

Candidate CandidateFitter::resolved(Candidate candidate) const {
  for (Index k = 0; k < candidate.effect.values.size(); ++k) {
    const auto& parameter = candidate.effect.kind->parameters[static_cast<std::size_t>(k)];
    if (is_duration(parameter))
      candidate.effect.values[k] =
          std::min(std::max(candidate.effect.values[k], interval_), parameter.upper);
  }
  return candidate;
}

// What is uncertain anyway, then all values of the added effects.
std::vector<Parameter> CandidateFitter::parameters(const std::vector<vjm::Effect>& effects,
                                                   const std::vector<Candidate>& added) const {
  std::vector<Parameter> result = base_;
  int group = -1;
  for (std::size_t a = 0; a < added.size(); ++a) {
    const vjm::Effect& effect = added[a].effect;
    std::map<std::string, int> groups;  // of amplitudes, by their unit
    for (Index k = 0; k < effect.values.size(); ++k) {
      const vjm::EffectParameter& described = effect.kind->parameters[static_cast<std::size_t>(k)];
      Parameter p =
          effect_parameter(effects, robot_.effects.size() + a, k, robot_.without_effects());
      if (is_duration(described)) {
        p.lower = std::min(std::max(p.lower, interval_), p.upper);
        p.start = std::max(p.start, p.lower);
      }
      if (!usual_values(effect, k, robot_.without_effects()).empty()) {
        p.lower = p.upper = p.start;
        result.push_back(std::move(p));
        continue;
      }
      Parameter::Prior prior{described.none, added[a].deviations[static_cast<std::size_t>(k)]};
      // What must be given has a size of its own; what need not be has one that is known.
      if (!described.is_shape || described.required) {
        const std::string& key = described.is_shape ? described.name : "in " + p.unit;
        const auto [it, is_new] = groups.try_emplace(key, group + 1);
        group += is_new ? 1 : 0;
        prior.group = it->second;
        prior.deviation *= widest_prior;
      }
      p.prior = prior;
      result.push_back(std::move(p));
    }
  }
  return result;
}

std::vector<Parameter> CandidateFitter::own_parameters(const std::vector<Candidate>& added) const {
  std::vector<Parameter> all = parameters(effects_with(robot_, added), added);
  return {all.end() - added.back().effect.values.size(), all.end()};
}

BaseFit CandidateFitter::fit(const std::vector<Candidate>& added, const BaseFit* start,
                             files::Progress& progress) const {
  const std::vector<vjm::Effect> effects = effects_with(robot_, added);
  std::vector<Parameter> unknowns = parameters(effects, added);
  if (start != nullptr) begin_at(*start, base_.size(), unknowns);
  try {
    return fitted(effects, unknowns, start, progress);
  } catch (const files::NotIdentifiable&) {
    // A missing effect may look like an infinite stiffness; so does a sign error.
    if (start != nullptr || !unit_error(campaign_, predictor_, progress).empty() ||
        !believe_design(unknowns))
      throw;
    return fitted(effects, unknowns, start, progress);
  }
}

BaseFit CandidateFitter::fit_held(const std::vector<Candidate>& added, const BaseFit& start,
                                  std::size_t held, double value, files::Progress& progress) const {
  const std::vector<vjm::Effect> effects = effects_with(robot_, added);
  std::vector<Parameter> unknowns = parameters(effects, added);
  begin_at(start, unknowns.size(), unknowns);
  unknowns[held].start = unknowns[held].lower = unknowns[held].upper = value;
  unknowns[held].bounds_stated = true;  // held, not diverging
  return fitted(effects, unknowns, &start, progress);
}

BaseFit CandidateFitter::fitted(const std::vector<vjm::Effect>& effects,
                                const std::vector<Parameter>& unknowns, const BaseFit* near,
                                files::Progress& progress) const {
  const Predictions* model = near == nullptr ? nullptr : &near->model;
  const auto compute = [&] {
    return fit_base(predictor_.with_effects(effects), campaign_, noise_, unknowns, progress,
                    {.max_iterations = 60,
                     .tolerance = 1e-9,
                     .near = model,
                     .accept_unsettled = unknowns.size() > base_.size()});
  };
  if (journal_ == nullptr) return compute();
  const std::string key = fit_key(scope_, effects, unknowns, model);
  if (const auto record = journal_->find(key))
    if (auto fit = recorded_fit(*record, unknowns)) return *std::move(fit);
  try {
    BaseFit fit = compute();
    journal_->keep(key, record_of(fit));
    return fit;
  } catch (const files::NotIdentifiable& failure) {
    journal_->keep(key, record_of(failure));
    throw;
  }
}

MatrixXd CandidateFitter::by_force(const BaseFit& fit, files::Progress& progress) const {
  const Predictions predictions =
      predictor_.predict_with_compliance(base_, values_of(fit), progress);
  const std::vector<Value> values = values_in_use(campaign_);
  MatrixXd columns = MatrixXd::Zero(static_cast<Index>(values.size()), 3);
  for (std::size_t first = 0, next = 0; first < values.size(); first = next) {
    std::vector<Index> used;
    for (next = first; next < values.size() && values[next].reading == values[first].reading;)
      used.push_back(values[next++].component);
    MatrixXd rows = predictions.by_wrench[values[first].reading](used, Eigen::seqN(0, 3));
    if (!rows.allFinite()) continue;
    noise_.whiten(values[first].reading, used, rows);
    columns.middleRows(static_cast<Index>(first), rows.rows()) = rows;
  }
  return columns;
}

// Of each drive with a spring.
std::vector<FreeFormWays::Drive> CandidateFitter::drives(const BaseFit& fit,
                                                         files::Progress& progress) const {
  std::vector<FreeFormWays::Drive> result;
  std::vector<Parameter> unknowns = base_;
  const auto& chains = robot_.without_effects().chains();
  for (std::size_t c = 0; c < chains.size(); ++c)
    for (const vjm::Spring& spring : chains[c].springs()) {
      const auto& joint = chains[c].coordinates()[static_cast<std::size_t>(spring.first)];
      if (joint.role != vjm::Role::actuated) continue;
      Parameter& parameter = unknowns.emplace_back();
      parameter.name = chains[c].name() + "." + joint.name;
      parameter.springs = {{c, spring.name}};
      VectorXd deflection = VectorXd::Zero(static_cast<Index>(campaign_.readings.size()));
      for (std::size_t r = 0; r < campaign_.readings.size(); ++r) {
        const auto& loaded = fit.model.loaded[r].coordinates;
        if (c < loaded.size())  // there is an equilibrium
          deflection[static_cast<Index>(r)] =
              loaded[c][spring.first] - predictor_.posture_of(r).coordinates[c][spring.first];
      }
      result.push_back({parameter.name, std::move(deflection), {}});
    }
  const auto count = static_cast<Index>(result.size());
  VectorXd values = starts_of(unknowns);
  values.head(static_cast<Index>(base_.size())) = values_of(fit);
  const auto there =
      linearised_at(predictor_, campaign_, noise_, unknowns, values, fit, count, progress);
  if (!there || count == 0) return {};
  const MatrixXd columns = there->jacobian.middleCols(static_cast<Index>(base_.size()), count);
  for (Index k = 0; k < count; ++k)
    result[static_cast<std::size_t>(k)].by_stiffness = columns.col(k);
  return result;
}

FreeFormWays CandidateFitter::free_form_ways(const BaseFit& fit, files::Progress& progress) const {
  return {by_force(fit, progress), fit.at.jacobian, drives(fit, progress)};
}

double CandidateFitter::error_on(const Campaign& others, const BaseFit& fit,
                                 const std::vector<Candidate>& added,
                                 files::Progress& progress) const {
  try {
    const BaseFit predicted = predict_others(predictor_.with_effects(effects_with(robot_, added)),
                                             others, noise_, fit, progress);
    return std::sqrt(predicted.squared_error / static_cast<double>(predicted.values));
  } catch (const files::NoConvergence&) {
    return std::numeric_limits<double>::quiet_NaN();
  }
}

std::optional<Signature> CandidateFitter::signature_of(const Predictor& predictor,
                                                       const std::vector<Candidate>& added,
                                                       double growth, const BaseFit& fit,
                                                       files::Progress& progress) const {
  const Candidate& candidate = added.back();
  const std::vector<Parameter> unknowns = parameters(effects_with(robot_, added), added);
  VectorXd values = starts_of(unknowns);
  for (std::size_t k = 0; k < fit.parameters.size(); ++k)
    values[static_cast<Index>(k)] = fit.parameters[k].value;
  const Index count = candidate.effect.values.size();
  const auto there =
      linearised_at(predictor, campaign_, noise_, unknowns, values, fit, count - 1, progress);
  if (!there) return std::nullopt;
  // Whitened residuals are predicted minus measured; so a signature is their change.
  Signature signature{.columns = there->residual - fit.at.residual,
                      .growth = Eigen::RowVectorXd::Constant(1, growth)};
  for (Index k = 1; k < count; ++k) {
    if (!usual_values(candidate.effect, k, robot_.without_effects()).empty()) continue;
    const auto i = static_cast<std::size_t>(k);
    const Index at = signature.columns.cols();
    signature.columns.conservativeResize(Eigen::NoChange, at + 1);
    signature.growth.conservativeResize(at + 1);
    signature.columns.col(at) =
        candidate.deviations[i] *
        there->jacobian.col(static_cast<Index>(unknowns.size()) - count + k);
    // How the effect acts shows as far as the effect itself does.
    signature.growth[at] = candidate.effect.kind->parameters[i].is_shape ? growth : 1;
  }
  return signature;
}

void CandidateFitter::add_signatures(const Predictor& predictor, const Candidate& candidate,
                                     std::vector<Candidate> added, const BaseFit& fit,
                                     Signatures& signatures, files::Progress& progress) const {
  const std::size_t before = signatures.all.size();
  const auto sizes = sizes_of(*candidate.effect.kind);
  double growth = 0;  // not known yet
  for (const auto& [leading, others] : sizes) {
    added.back() = resolved(at_size(candidate, std::max(1.0, growth) * leading, others));
    auto signature = signature_of(predictor, added, std::max(1.0, growth), fit, progress);
    if (signature && growth == 0) {
      growth = growth_to_be_seen(signature->columns.col(0).norm());
      if (growth > 1) {
        added.back() = resolved(at_size(candidate, growth * leading, others));
        signature = signature_of(predictor, added, growth, fit, progress);
      }
    }
    if (!signature) signatures.failure = "the model with it has no equilibrium for some reading";
    if (!signature || !signature->columns.allFinite()) continue;
    signatures.all.push_back(std::move(*signature));
    signatures.starts.push_back(added.back());
    // A signature that only grows with its size is the same direction at every size.
    if (leading == sizes[1].first && signatures.all.size() == before + 2 &&
        sizes.back().second == 1 && is_proportional(signatures.all, before, leading)) {
      signatures.all.pop_back();
      signatures.starts.pop_back();
      break;
    }
  }
}

CandidateFitter::Signatures CandidateFitter::signatures_of(const Candidate& candidate,
                                                           const std::vector<Candidate>& present,
                                                           const BaseFit& fit,
                                                           files::Progress& progress) const {
  if (journal_ == nullptr) return computed_signatures(candidate, present, fit, progress);
  const std::string key = signatures_key(scope_, candidate, present, fit);
  if (const auto record = journal_->find(key))
    if (auto signatures = recorded_signatures(*record, candidate)) return *std::move(signatures);
  Signatures signatures = computed_signatures(candidate, present, fit, progress);
  journal_->keep(key, record_of(signatures));
  return signatures;
}

CandidateFitter::Signatures CandidateFitter::computed_signatures(
    const Candidate& candidate, const std::vector<Candidate>& present, const BaseFit& fit,
    files::Progress& progress) const {
  Signatures signatures;
  for (const Candidate& design : designs_of(candidate, robot_.without_effects())) {
    std::vector<Candidate> added = present;
    added.push_back(design);
    add_signatures(predictor_.with_effects(effects_with(robot_, added)), design, added, fit,
                   signatures, progress);
  }
  if (!signatures.all.empty()) signatures.failure.clear();
  return signatures;
}

}  // namespace kinetostat::calibration

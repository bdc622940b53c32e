#include "kinetostat/calibration/rivals.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kinetostat/files/error.h"

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

// Sizes at which the shape of a mark is looked at: gaps, breakaway forces and corners show another
// shape when they are small beside what the readings do to them.
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

// Marks of the first two sizes that differ by no more than their length.
bool is_proportional(const std::vector<Signature>& signatures, double ratio) {
  const VectorXd large = signatures[0].columns.col(0), small = signatures[1].columns.col(0);
  return (small - ratio * large).norm() < 0.02 * ratio * large.norm();
}

VectorXd values_of(const std::vector<Parameter>& parameters) {
  VectorXd values(static_cast<Index>(parameters.size()));
  for (std::size_t k = 0; k < parameters.size(); ++k)
    values[static_cast<Index>(k)] = parameters[k].start;
  return values;
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
  for (std::size_t k = 0; k < kind->parameters.size(); ++k) {
    const vjm::EffectParameter& parameter = kind->parameters[k];
    const auto i = static_cast<Index>(k);
    candidate.effect.values[i] = parameter.none;
    const double deviation = vjm::prior_deviation(candidate.effect, i, bare);
    candidate.deviations.push_back(deviation);
    if (!(deviation > 0) || !std::isfinite(deviation)) return std::nullopt;
    if (k == 0 || parameter.required)
      candidate.effect.values[i] = within(parameter, parameter.none + deviation);
  }
  return candidate;
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

FittedValues fitted_values(const BaseFit& fit, std::size_t first, Index count) {
  FittedValues result{VectorXd(count), VectorXd(count)};
  for (Index k = 0; k < count; ++k) {
    const ParameterEstimate& estimate = fit.parameters[first + static_cast<std::size_t>(k)];
    result.values[k] = estimate.value;
    result.deviations[k] = estimate.hit == BoundHit::none
                               ? estimate.standard_error
                               : std::numeric_limits<double>::quiet_NaN();
  }
  return result;
}

Rivals::Rivals(const vjm::Robot& robot, const Campaign& campaign, const Noise& noise, int threads,
               files::Progress& progress)
    : robot_(robot),
      campaign_(campaign),
      noise_(noise),
      predictor_(robot.without_effects(), robot.effects, campaign, threads, progress),
      base_(uncertain_parameters(robot)) {}

std::vector<vjm::Effect> Rivals::effects_with(const std::vector<Candidate>& added) const {
  std::vector<vjm::Effect> effects = robot_.effects;
  for (const Candidate& candidate : added) effects.push_back(candidate.effect);
  return effects;
}

// What is uncertain anyway, then all values of the added effects.
std::vector<Parameter> Rivals::parameters(const std::vector<vjm::Effect>& effects,
                                          const std::vector<Candidate>& added) const {
  std::vector<Parameter> result = base_;
  for (std::size_t a = 0; a < added.size(); ++a)
    for (Index k = 0; k < added[a].effect.values.size(); ++k) {
      result.push_back(
          effect_parameter(effects, robot_.effects.size() + a, k, robot_.without_effects()));
      result.back().prior = {added[a].effect.kind->parameters[static_cast<std::size_t>(k)].none,
                             added[a].deviations[static_cast<std::size_t>(k)]};
    }
  return result;
}

BaseFit Rivals::fit(const std::vector<Candidate>& added, const BaseFit* start,
                    files::Progress& progress) const {
  const std::vector<vjm::Effect> effects = effects_with(added);
  std::vector<Parameter> unknowns = parameters(effects, added);
  if (start != nullptr)
    for (std::size_t k = 0; k < base_.size(); ++k) unknowns[k].start = start->parameters[k].value;
  return fitted(effects, unknowns, start, progress);
}

BaseFit Rivals::fit_held(const std::vector<Candidate>& added, const BaseFit& start,
                         std::size_t held, double value, files::Progress& progress) const {
  const std::vector<vjm::Effect> effects = effects_with(added);
  std::vector<Parameter> unknowns = parameters(effects, added);
  for (std::size_t k = 0; k < unknowns.size(); ++k) unknowns[k].start = start.parameters[k].value;
  unknowns[held].start = unknowns[held].lower = unknowns[held].upper = value;
  unknowns[held].bounds_stated = true;  // held, not running away
  return fitted(effects, unknowns, &start, progress);
}

BaseFit Rivals::fitted(const std::vector<vjm::Effect>& effects,
                       const std::vector<Parameter>& unknowns, const BaseFit* near,
                       files::Progress& progress) const {
  return fit_base(
      predictor_.with_effects(effects), campaign_, noise_, unknowns, progress,
      {.max_iterations = 60, .tolerance = 1e-9, .near = near == nullptr ? nullptr : &near->model});
}

double Rivals::error_on(const Campaign& others, const BaseFit& fit,
                        const std::vector<Candidate>& added, files::Progress& progress) const {
  try {
    const BaseFit predicted =
        predict_others(predictor_.with_effects(effects_with(added)), others, noise_, fit, progress);
    return std::sqrt(predicted.squared_error / static_cast<double>(predicted.values));
  } catch (const files::NoConvergence&) {
    return std::numeric_limits<double>::quiet_NaN();
  }
}

Rivals::Marks Rivals::marks_of(const Candidate& candidate, const std::vector<Candidate>& present,
                               const BaseFit& fit, files::Progress& progress) const {
  Marks marks;
  std::vector<Candidate> added = present;
  added.push_back(candidate);
  const Predictor predictor = predictor_.with_effects(effects_with(added));
  const bool has_others = candidate.effect.values.size() > 1;
  const auto sizes = sizes_of(*candidate.effect.kind);
  for (const auto& [leading, others] : sizes) {
    added.back() = at_size(candidate, leading, others);
    const std::vector<vjm::Effect> effects = effects_with(added);
    const std::vector<Parameter> unknowns = parameters(effects, added);
    VectorXd values = values_of(unknowns);
    for (std::size_t k = 0; k < fit.parameters.size(); ++k)
      values[static_cast<Index>(k)] = fit.parameters[k].value;
    const auto there =
        linearised_at(predictor, campaign_, noise_, unknowns, values, fit, has_others, progress);
    if (!there) {
      marks.failure = "the model with it has no equilibrium for some reading";
      continue;
    }
    // Whitened residuals are predicted minus measured; so a mark is their change.
    MatrixXd columns(fit.at.residual.size(), candidate.effect.values.size());
    columns.col(0) = there->residual - fit.at.residual;
    const auto first = static_cast<Index>(unknowns.size()) - candidate.effect.values.size();
    for (Index k = 1; k < columns.cols(); ++k)
      columns.col(k) =
          candidate.deviations[static_cast<std::size_t>(k)] * there->jacobian.col(first + k);
    if (!columns.allFinite()) continue;
    marks.signatures.push_back({columns});
    marks.starts.push_back(added.back());
    // A mark that only grows with its size is the same direction at every size.
    if (leading == sizes[1].first && marks.signatures.size() == 2 && sizes.back().second == 1 &&
        is_proportional(marks.signatures, leading)) {
      marks.signatures.pop_back();
      marks.starts.pop_back();
      break;
    }
  }
  if (!marks.signatures.empty()) marks.failure.clear();
  return marks;
}

}  // namespace kinetostat::calibration

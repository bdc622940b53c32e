#include "kinetostat/calibration/search/candidate_fitter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/datum.h"
#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/calibration/comparison/unit_error.h"
#include "kinetostat/calibration/regression/evidence.h"
#include "kinetostat/calibration/regression/undetermined.h"
#include "kinetostat/calibration/search/fit_record.h"
#include "kinetostat/calibration/search/placement.h"
#include "kinetostat/calibration/search/usual_values.h"
#include "kinetostat/calibration/statistics/median.h"
#include "kinetostat/common/error.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// By how much a signature must grow to be seen. A usual size is a guess; an effect ten times as
// large is rare but real.
double growth_to_be_seen(double length) {
  constexpr double seen = 1, most = 10;
  return length >= seen || length < least_visible / most ? 1 : most;
}

// What of the change of the readings does not grow with the size of the effect, by its derivatives,
// as a share of the change. Where it is next to nothing the effect does the same at every smaller
// size: laws with corners leave the line behind the first. So does one that does nothing, as a
// temperature does that no reading states.
double share_of_bend(const vjm::Effect& effect, const VectorXd& change, const MatrixXd& by_values) {
  constexpr double nothing = 1e-4 * least_visible;
  VectorXd along = VectorXd::Zero(change.size());
  for (Index k = 0; k < by_values.cols(); ++k)
    if (const auto i = static_cast<std::size_t>(k); is_size(*effect.kind, i))
      along += (effect.values[k] - effect.kind->parameters[i].none) * by_values.col(k);
  const double bend = (along - change).norm();
  return bend < nothing ? 0 : bend / change.norm();
}

constexpr double straight = 0.02;  // share of bend of what only grows with its size

// Whether two signatures are the same to rounding.
bool are_equal(const Signature& a, const Signature& b) {
  constexpr double rounding = 1e-9;
  return a.columns.cols() == b.columns.cols() &&
         (a.columns - b.columns).norm() <= rounding * a.columns.norm();
}

// Whether the last two signatures of a law, each at a fifth of the size before, point so nearly the
// same way that the next will do so, too: it turns by a fifth as much again, or by a third where
// corners are narrow.
bool has_settled(std::span<const Signature> smaller_and_smaller) {
  constexpr double still_to_turn = 1.0 / 3;
  const std::size_t count = smaller_and_smaller.size();
  if (count < 2) return false;
  const MatrixXd& before = smaller_and_smaller[count - 2].columns;
  const MatrixXd& last = smaller_and_smaller[count - 1].columns;
  for (Index k = 0; k < last.cols(); ++k)
    if ((before.col(k).normalized() - last.col(k).normalized()).norm() * still_to_turn > straight)
      return false;
  return true;
}

// Whether all that says how large an effect is has grown by a factor, and nothing was at a limit.
bool is_times(double factor, const vjm::Effect& small, const vjm::Effect& large) {
  for (Index k = 0; k < small.values.size(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    const double none = small.kind->parameters[i].none;
    const double expected =
        is_size(*small.kind, i) ? none + factor * (small.values[k] - none) : small.values[k];
    if (std::abs(large.values[k] - expected) > 1e-9 * std::abs(expected)) return false;
  }
  return true;
}

// By how much the columns of a signature are longer where the effect is so many times as large: how
// it acts shows as far as the effect itself does.
Eigen::RowVectorXd growth_of_columns(const vjm::Effect& effect, const vjm::Manipulator& bare,
                                     double growth) {
  const std::vector<Index> values = values_of_columns(effect, bare);
  Eigen::RowVectorXd result(std::ssize(values));
  for (std::size_t at = 0; at < values.size(); ++at) {
    const auto value = static_cast<std::size_t>(values[at]);
    const bool grows = value == 0 || effect.kind->parameters[value].is_shape;
    result[static_cast<Index>(at)] = grows ? growth : 1;
  }
  return result;
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
  return upper_median(std::move(intervals));
}

// A time over which an effect comes or goes: readings farther apart do not determine it. One that
// may be left out may be none.
bool is_duration(const vjm::EffectParameter& parameter) {
  return parameter.is_shape && parameter.required && parameter.linear == spatial::dimension::time;
}

// The first `count` unknowns start where another fit has them, which may know them by design. Fewer
// readings may not determine one: it then stays where it is held.
void begin_at(const BaseFit& start, std::size_t count, std::vector<Parameter>& unknowns) {
  for (std::size_t k = 0; k < count; ++k) {
    const auto& [there, value, error, hit] = start.parameters[k];
    Parameter& p = unknowns[k];
    if (there.prior && !p.prior) {
      p.prior = there.prior;
      p.lower = there.lower;
      p.upper = there.upper;
      p.bounds_stated = true;
    }
    p.start = std::clamp(value, p.lower, p.upper);
  }
}

// In which alone a candidate acts.
std::optional<vjm::JointPlace> own_joint(const Candidate& candidate, const vjm::Manipulator& bare) {
  const vjm::Effect& effect = candidate.effect;
  if (!effect.kind->acts_on_joint_alone || effect.sites.size() != 1) return std::nullopt;
  const auto& [chain, element] = effect.sites[0];
  return vjm::JointPlace{chain, bare.chains()[chain].index_of(element)};
}

}  // namespace

FittedModel::FittedModel(const std::vector<Candidate>& present, const BaseFit& fit,
                         const std::vector<Candidate>& looked_at, const vjm::Manipulator& bare)
    : present_(present), fit_(fit) {
  for (const Candidate& candidate : looked_at) {
    const auto place = own_joint(candidate, bare);
    if (place && std::find(joints_.begin(), joints_.end(), *place) == joints_.end())
      joints_.push_back(*place);
  }
}

const std::string& FittedModel::key() const {
  std::call_once(has_key_, [&] { key_ = fitted_key(present_, fit_); });
  return key_;
}

CandidateFitter::CandidateFitter(const vjm::Robot& robot, const Campaign& campaign,
                                 const Noise& noise, int threads, common::Progress& progress,
                                 FitJournal* journal)
    : robot_(robot),
      campaign_(campaign),
      noise_(noise),
      predictor_(robot.without_effects(), robot.effects, campaign, threads, progress),
      base_(uncertain_parameters(robot)),
      threads_(threads),
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
        prior.times = described.is_shape ? widest_prior : added[a].widest;
        prior.deviation *= prior.times;
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
                             common::Progress& progress) const {
  const std::vector<vjm::Effect> effects = effects_with(robot_, added);
  if (start != nullptr)
    return fitted(effects, unknowns_near(effects, added, *start), start, {}, threads_, progress);
  // A missing effect may look like an infinite stiffness; so does a sign error.
  return fit_near_design(
      parameters(effects, added),
      [&](const std::vector<Parameter>& unknowns) {
        return fitted(effects, unknowns, nullptr, {}, threads_, progress);
      },
      [&] { return unit_error(campaign_, predictor_, progress).empty(); });
}

BaseFit CandidateFitter::fit_on_one_thread(const std::vector<Candidate>& added,
                                           const BaseFit& start,
                                           const std::optional<CondensedFit>& rough,
                                           double least_gain, common::Progress& progress) const {
  const std::vector<vjm::Effect> effects = effects_with(robot_, added);
  std::vector<Parameter> unknowns = unknowns_near(effects, added, start);
  // Not of effects that are there already: their laws may have no sense where a straight line ends.
  const auto own = unknowns.size() - static_cast<std::size_t>(added.back().effect.values.size());
  for (std::size_t k = 0; rough && k < unknowns.size(); ++k)
    if (k < base_.size() || k >= own) unknowns[k].start = rough->values[static_cast<Index>(k)];
  return fitted(effects, unknowns, &start, {.least_gain = least_gain}, 1, progress);
}

std::optional<std::size_t> CandidateFitter::stiffness_of(const vjm::JointPlace& joint) const {
  for (const vjm::Spring& spring : robot_.without_effects().chains()[joint.chain].springs()) {
    if (spring.first != joint.coordinate || spring.stiffness.rows() > 1) continue;
    const std::vector<vjm::SpringParameter> own = {{joint.chain, spring.name}};
    for (std::size_t k = 0; k < base_.size(); ++k)
      if (base_[k].springs == own) return k;
  }
  return std::nullopt;
}

std::optional<CondensedFit> CandidateFitter::fit_condensed(const std::vector<Candidate>& added,
                                                           const FittedModel& beside,
                                                           common::Progress& progress) const {
  const auto joint = own_joint(added.back(), robot_.without_effects());
  if (!joint) return std::nullopt;
  const std::vector<vjm::Effect> effects = effects_with(robot_, added);
  const std::vector<Parameter> unknowns = unknowns_near(effects, added, beside.fit());
  const auto compute = [&]() -> std::optional<CondensedFit> {
    const CondensedModel& model = condensed(beside, progress);
    if (!model.knows(*joint)) return std::nullopt;
    return calibration::fit_condensed(predictor_.with_effects(effects, 1), campaign_, noise_,
                                      unknowns, stiffness_of(*joint), beside.fit(), model,
                                      progress);
  };
  if (journal_ == nullptr) return compute();
  const std::string key = condensed_key(scope_, effects, unknowns, beside.key());
  if (const auto record = recorded(key))
    if (const auto found = recorded_condensed_fit(*record, unknowns)) return *found;
  std::optional<CondensedFit> found = compute();
  keep(key, record_of(found));
  return found;
}

BaseFit CandidateFitter::finished(const std::vector<Candidate>& added, const BaseFit& fit,
                                  common::Progress& progress) const {
  const std::vector<vjm::Effect> effects = effects_with(robot_, added);
  std::vector<Parameter> unknowns = parameters(effects, added);
  begin_at(fit, unknowns.size(), unknowns);
  return fitted(effects, unknowns, &fit, {}, 1, progress);
}

BaseFit CandidateFitter::fit_roughly(const std::vector<Candidate>& added, const BaseFit& start,
                                     const FitEffort& effort, int threads,
                                     common::Progress& progress) const {
  const std::vector<vjm::Effect> effects = effects_with(robot_, added);
  return computed(effects, unknowns_near(effects, added, start), &start, effort, threads, progress);
}

std::vector<Parameter> CandidateFitter::unknowns_near(const std::vector<vjm::Effect>& effects,
                                                      const std::vector<Candidate>& added,
                                                      const BaseFit& start) const {
  std::vector<Parameter> unknowns = parameters(effects, added);
  begin_at(start, base_.size(), unknowns);
  return unknowns;
}

BaseFit CandidateFitter::fit_held(const std::vector<Candidate>& added, const BaseFit& start,
                                  std::size_t held, double value,
                                  common::Progress& progress) const {
  const std::vector<vjm::Effect> effects = effects_with(robot_, added);
  std::vector<Parameter> unknowns = parameters(effects, added);
  begin_at(start, unknowns.size(), unknowns);
  unknowns[held].start = unknowns[held].lower = unknowns[held].upper = value;
  unknowns[held].bounds_stated = true;  // held, not diverging
  return fitted(effects, unknowns, &start, {}, threads_, progress);
}

BaseFit CandidateFitter::as_fitted(const std::vector<Candidate>& added, const BaseFit& fit,
                                   common::Progress& progress) const {
  return fit_base(predictor_.with_effects(effects_with(robot_, added)), campaign_, noise_,
                  held_parameters(fit), progress);
}

BaseFit CandidateFitter::computed(const std::vector<vjm::Effect>& effects,
                                  const std::vector<Parameter>& unknowns, const BaseFit* near,
                                  const FitEffort& effort, int threads,
                                  common::Progress& progress) const {
  // Whether one candidate of many has settled may be left open, but not the model that they are
  // added to.
  const bool is_candidate = unknowns.size() > base_.size();
  return fit_base(predictor_.with_effects(effects, threads), campaign_, noise_, unknowns, progress,
                  {.max_iterations = is_candidate ? effort.max_iterations : 200,
                   .tolerance = 1e-9,
                   .least_gain = effort.least_gain,
                   .near = near == nullptr ? nullptr : &near->model,
                   .accept_unsettled = is_candidate});
}

BaseFit CandidateFitter::fitted(const std::vector<vjm::Effect>& effects,
                                const std::vector<Parameter>& unknowns, const BaseFit* near,
                                const FitEffort& effort, int threads,
                                common::Progress& progress) const {
  try {
    return fitted_as_given(effects, unknowns, near, effort, threads, progress);
  } catch (const common::NotIdentifiable&) {
    // A stiffness that the readings hardly see, or not beside this effect, is no reason against it.
    const std::optional<std::vector<Parameter>> believed = with_design(unknowns);
    if (!believed) throw;
    return fitted_as_given(effects, *believed, near, effort, threads, progress);
  }
}

std::optional<std::vector<Parameter>> CandidateFitter::with_design(
    std::vector<Parameter> unknowns) const {
  std::vector<Parameter> believed = base_;
  if (unknowns.size() == base_.size() || !believe_design(believed)) return std::nullopt;
  bool any = false;
  for (std::size_t k = 0; k < base_.size(); ++k) {
    if (unknowns[k].prior || !believed[k].prior) continue;
    believed[k].start = std::clamp(unknowns[k].start, believed[k].lower, believed[k].upper);
    unknowns[k] = believed[k];
    any = true;
  }
  return any ? std::optional(std::move(unknowns)) : std::nullopt;
}

BaseFit CandidateFitter::fitted_as_given(const std::vector<vjm::Effect>& effects,
                                         const std::vector<Parameter>& unknowns,
                                         const BaseFit* near, const FitEffort& effort, int threads,
                                         common::Progress& progress) const {
  const Predictions* model = near == nullptr ? nullptr : &near->model;
  const auto compute = [&] { return computed(effects, unknowns, near, effort, threads, progress); };
  if (journal_ == nullptr) return compute();
  const std::string key = fit_key(scope_, effects, unknowns, model, effort.least_gain);
  // Some fits are not shared out: the first worker to come makes them for all.
  Claim claim(journal_, key);
  claim.wait(progress);
  if (const auto record = recorded(key))
    if (auto fit = recorded_fit(*record, unknowns)) return *std::move(fit);
  try {
    BaseFit fit = compute();
    keep(key, record_of(fit));
    return fit;
  } catch (const common::NotIdentifiable& failure) {
    keep(key, record_of(failure));
    throw;
  }
}

std::optional<std::string> CandidateFitter::recorded(const std::string& key) const {
  const std::lock_guard lock(journal_in_use_);
  return journal_->find(key);
}

void CandidateFitter::keep(const std::string& key, const std::string& record) const {
  const std::lock_guard lock(journal_in_use_);
  journal_->keep(key, record);
}

MatrixXd CandidateFitter::by_force(const BaseFit& fit, common::Progress& progress) const {
  const Predictions predictions =
      predictor_.predict_with_compliance(base_, values_of(fit), progress, targets_of(fit));
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
  SharedNoise(noise_, values).whiten(columns);
  return columns;
}

// Of each drive with a spring.
std::vector<FreeFormWays::Drive> CandidateFitter::drives(const BaseFit& fit,
                                                         common::Progress& progress) const {
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

FreeFormWays CandidateFitter::free_form_ways(const BaseFit& fit, common::Progress& progress) const {
  return {by_force(fit, progress), fit.at.jacobian, drives(fit, progress)};
}

BaseFit CandidateFitter::predicted(const Campaign& others, const BaseFit& fit,
                                   const std::vector<Candidate>& added,
                                   common::Progress& progress) const {
  return predict_others(predictor_.with_effects(effects_with(robot_, added)), others, noise_, fit,
                        progress);
}

double CandidateFitter::error_on(const Campaign& others, const BaseFit& fit,
                                 const std::vector<Candidate>& added,
                                 common::Progress& progress) const {
  const auto there = if_possible([&] { return predicted(others, fit, added, progress); });
  return there ? std::sqrt(there->squared_error / static_cast<double>(there->values))
               : std::numeric_limits<double>::quiet_NaN();
}

std::optional<CandidateFitter::Look> CandidateFitter::look_at(const Predictor& predictor,
                                                              const std::vector<Candidate>& added,
                                                              double growth, bool for_direction,
                                                              const FittedModel& beside,
                                                              common::Progress& progress) const {
  const BaseFit& fit = beside.fit();
  const Candidate& candidate = added.back();
  const std::vector<Parameter> unknowns = parameters(effects_with(robot_, added), added);
  VectorXd values = starts_of(unknowns);
  for (std::size_t k = 0; k < fit.parameters.size(); ++k)
    values[static_cast<Index>(k)] = fit.parameters[k].value;
  const Index count = candidate.effect.values.size();
  const auto there =
      linearised_at(predictor, campaign_, noise_, unknowns, values, fit,
                    for_direction ? count : count - 1, progress, &condensed(beside, progress));
  if (!there) return std::nullopt;
  const auto by_values =
      there->jacobian.middleCols(static_cast<Index>(unknowns.size()) - count, count);
  // Whitened residuals are predicted minus measured; so a signature is their change.
  const VectorXd change = there->residual - fit.at.residual;
  Signature signature{
      .columns = change,
      .growth = growth_of_columns(candidate.effect, robot_.without_effects(), growth)};
  for (const Index k : values_of_columns(candidate.effect, robot_.without_effects())) {
    if (k == 0) continue;
    const Index at = signature.columns.cols();
    signature.columns.conservativeResize(Eigen::NoChange, at + 1);
    signature.columns.col(at) =
        candidate.deviations[static_cast<std::size_t>(k)] * by_values.col(k);
  }
  const double bend = for_direction ? share_of_bend(candidate.effect, change, by_values) : 1;
  return Look{std::move(signature), bend};
}

// At the usual size, or ten times as large to be seen: what only grows is known there without
// another look.
std::optional<CandidateFitter::Look> CandidateFitter::first_look(
    const Predictor& predictor, std::vector<Candidate>& added, const Candidate& candidate,
    bool for_direction, const FittedModel& beside, common::Progress& progress) const {
  added.back() = resolved(at_size(candidate, 1, 1));
  auto look = look_at(predictor, added, 1, for_direction, beside, progress);
  if (!look) return std::nullopt;
  const double growth = growth_to_be_seen(look->signature.columns.col(0).norm());
  if (growth == 1) return look;
  const vjm::Effect usual = added.back().effect;
  added.back() = resolved(at_size(candidate, growth, 1));
  if (look->bend * growth > straight || !is_times(growth, usual, added.back().effect))
    return look_at(predictor, added, growth, for_direction, beside, progress);
  Signature& signature = look->signature;
  signature.growth = growth_of_columns(usual, robot_.without_effects(), growth);
  signature.columns *= signature.growth.asDiagonal();
  return look;
}

void CandidateFitter::add_signatures(const Predictor& predictor, const Candidate& candidate,
                                     std::vector<Candidate> added, const FittedModel& beside,
                                     Signatures& signatures, std::vector<std::size_t>& firsts,
                                     common::Progress& progress) const {
  const std::vector<TriedSizes> all = sizes_of(*candidate.effect.kind);
  // A signature that only grows with its size is the same direction at every size.
  const bool may_only_grow = std::all_of(
      all.begin(), all.end(), [](const TriedSizes& sizes) { return sizes.front().others == 1; });
  std::optional<double> growth;  // not known yet
  for (const TriedSizes& sizes : all) {
    const std::size_t first = signatures.all.size();
    for (const auto& [leading, others] : sizes) {
      if (has_settled(std::span(signatures.all).subspan(first))) break;
      std::optional<Look> look;
      const bool is_first = !growth;
      if (is_first) {
        look = first_look(predictor, added, candidate, may_only_grow, beside, progress);
        growth = look ? look->signature.growth[0] : 1;
      } else {
        added.back() = resolved(at_size(candidate, *growth * leading, others));
        look = look_at(predictor, added, *growth, false, beside, progress);
      }
      if (!look) signatures.failure = "the model with it has no equilibrium for some reading";
      if (!look || !look->signature.columns.allFinite()) continue;
      if (is_first) {
        // A design that looks like another one at first, as weight does that is none, goes on so.
        if (std::any_of(firsts.begin(), firsts.end(), [&](std::size_t other) {
              return are_equal(signatures.all[other], look->signature);
            }))
          return;
        firsts.push_back(first);
      }
      signatures.all.push_back(std::move(look->signature));
      signatures.starts.push_back(added.back());
      if (look->bend < straight) return;
    }
  }
}

CandidateFitter::Signatures CandidateFitter::signatures_of(const Candidate& candidate,
                                                           const FittedModel& beside,
                                                           common::Progress& progress) const {
  if (journal_ == nullptr) return computed_signatures(candidate, beside, progress);
  const std::string key = signatures_key(scope_, candidate, beside.key());
  if (const auto record = recorded(key))
    if (auto signatures = recorded_signatures(*record, candidate)) return *std::move(signatures);
  Signatures signatures = computed_signatures(candidate, beside, progress);
  keep(key, record_of(signatures));
  return signatures;
}

CandidateFitter::Signatures CandidateFitter::computed_signatures(const Candidate& candidate,
                                                                 const FittedModel& beside,
                                                                 common::Progress& progress) const {
  Signatures signatures;
  if (candidate.effect.kind->offsets_readings) {
    for (Placement& placed :
         best_placements(candidate, campaign_, predictor_.platform_axes(), noise_, beside.fit())) {
      const Index count = placed.columns.cols();
      signatures.all.push_back(
          {.columns = std::move(placed.columns), .growth = Eigen::RowVectorXd::Ones(count)});
      signatures.starts.push_back(std::move(placed.candidate));
    }
    if (signatures.all.empty()) signatures.failure = "there are no readings that it could be of";
    return signatures;
  }
  const std::vector<Candidate> designs = designs_beside(candidate, beside.present());
  if (designs.empty()) signatures.failure = "each of its orders is in the model already";
  std::vector<std::size_t> firsts;
  for (const Candidate& design : designs) {
    std::vector<Candidate> added = beside.present();
    added.push_back(design);
    add_signatures(predictor_.with_effects(effects_with(robot_, added), 1), design, added, beside,
                   signatures, firsts, progress);
  }
  if (!signatures.all.empty()) signatures.failure.clear();
  signatures.drop_repetitions();
  return signatures;
}

const CondensedModel& CandidateFitter::condensed(const FittedModel& beside,
                                                 common::Progress& progress) const {
  std::call_once(beside.is_condensed_, [&] {
    const std::vector<vjm::Effect> effects = effects_with(robot_, beside.present());
    beside.condensed_ = predictor_.with_effects(effects).condensed(
        parameters(effects, beside.present()), values_of(beside.fit()), beside.joints_,
        beside.fit().model, progress);
  });
  return beside.condensed_;
}

}  // namespace kinetostat::calibration

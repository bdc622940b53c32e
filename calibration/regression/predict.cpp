#include "kinetostat/calibration/regression/predict.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/faults.h"
#include "kinetostat/common/parallel.h"
#include "kinetostat/spatial/rotation.h"

namespace kinetostat::calibration {

using spatial::Vector3;
using spatial::Vector6;

struct Predictor::CaseResult {
  std::string failure;  // empty when solved
  Vector6 displacement = Vector6::Constant(std::numeric_limits<double>::quiet_NaN());
  vjm::Matrix6X derivatives;  // rotations as increments
  vjm::Matrix6X by_wrench;    // the same; empty when not asked for
  Vector6 work = Vector6::Zero();
  vjm::SystemState state;
};

// One prediction: the model at its values, and what is asked of it.
struct Predictor::Run {
  const vjm::EffectModel& model;
  std::vector<vjm::ModelParameter> parameters;
  bool with_derivatives = false;
  const Predictions* near = nullptr;
  bool with_compliance = false;

  const vjm::SystemState* loaded_near(std::size_t reading) const {
    return near == nullptr || near->loaded.empty() ? nullptr : &near->loaded[reading];
  }
  const vjm::SystemState* unloaded_near(std::size_t reading) const {
    return near == nullptr || near->unloaded.empty() ? nullptr : &near->unloaded[reading];
  }
};

namespace {

vjm::PostureResult unloaded_posture(const vjm::Manipulator& manipulator,
                                    const Configuration& configuration) {
  if (configuration.target) return vjm::posture_at(manipulator, *configuration.target);
  return vjm::posture_from_joints(manipulator, configuration.joints);
}

}  // namespace

Predictor::Predictor(const vjm::Manipulator& bare, std::vector<vjm::Effect> effects,
                     const Campaign& campaign, int threads, common::Progress& progress)
    : bare_(bare), campaign_(campaign), threads_(threads) {
  find_postures(progress);
  set_effects(std::move(effects));
}

Predictor::Predictor(const vjm::Manipulator& manipulator, const Campaign& campaign, int threads,
                     common::Progress& progress)
    : Predictor(manipulator, {}, campaign, threads, progress) {}

Predictor::Predictor(const Predictor& like, std::vector<vjm::Effect> effects)
    : bare_(like.bare_),
      campaign_(like.campaign_),
      threads_(like.threads_),
      postures_(like.postures_) {
  set_effects(std::move(effects));
}

Predictor Predictor::with_effects(std::vector<vjm::Effect> effects) const {
  return {*this, std::move(effects)};
}

void Predictor::set_effects(std::vector<vjm::Effect> effects) {
  effects_ = std::move(effects);
  for (const vjm::Effect& effect : effects_) {
    varies_ |= effect.kind->varies;
    has_history_ |= effect.kind->history > 0;
  }
  find_cases();
  find_sequences();
}

void Predictor::find_postures(common::Progress& progress) {
  std::vector<vjm::PostureResult> postures(campaign_.configurations.size());
  common::parallel_for(
      postures.size(), threads_, "unloaded postures", progress,
      [&](std::size_t i) { postures[i] = unloaded_posture(bare_, campaign_.configurations[i]); });
  postures_ = std::make_shared<const std::vector<vjm::PostureResult>>(std::move(postures));
  common::Faults faults;
  for (const Reading& reading : campaign_.readings)
    if (const vjm::PostureResult& posture = (*postures_)[reading.configuration];
        !posture.reached && !reading.masked)
      faults.add(
          {.file = campaign_.readings_file,
           .line = reading.line,
           .what = fmt::format("the posture of reading '{}' is out of reach: {}", reading.id,
                               posture.reason),
           .cure = "Check the pose columns, their unit and the robot file, or mask the reading"});
  faults.throw_if_any();
}

namespace {

// Masked readings were taken, too. One without a cycle stands alone.
std::vector<Cycle> cycles_of(const Campaign& campaign) {
  std::vector<Cycle> result = cycles_as_run(campaign);
  for (std::size_t i = 0; i < campaign.readings.size(); ++i)
    if (campaign.readings[i].cycle.empty()) result.push_back({i});
  return result;
}

// The same without a change of configuration inside.
std::vector<Cycle> stretches_of(const Campaign& campaign) {
  std::vector<Cycle> result;
  for (const Cycle& cycle : cycles_of(campaign))
    for (std::size_t k = 0; k < cycle.size(); ++k) {
      const bool same = k > 0 && campaign.readings[cycle[k]].configuration ==
                                     campaign.readings[cycle[k - 1]].configuration;
      if (!same) result.emplace_back();
      result.back().push_back(cycle[k]);
    }
  return result;
}

std::vector<vjm::Conditions> conditions_of(const Campaign& campaign) {
  std::map<std::size_t, double> start;  // of sessions
  for (const Reading& r : campaign.readings)
    if (r.time) {
      const auto [found, fresh] = start.emplace(r.session, *r.time);
      if (!fresh) found->second = std::min(found->second, *r.time);
    }
  std::vector<vjm::Conditions> result;
  for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
    const Reading& r = campaign.readings[i];
    result.push_back({.time = r.time ? *r.time - start[r.session] : 0,
                      .temperature = r.temperature,
                      .session = campaign.sessions[r.session],
                      .setting = r.setting});
    for (const Covariate& c : campaign.covariates) {
      const std::string& text = c.values[i];
      double value = 0;
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
      if (error == std::errc() && end == text.data() + text.size() && std::isfinite(value))
        result.back().covariates.emplace(c.name, value);
    }
  }
  for (const Cycle& cycle : cycles_of(campaign)) {
    double begin = campaign.readings[cycle.front()].cycle.empty() ? 0 : result[cycle.front()].time;
    for (const std::size_t i : cycle) begin = std::min(begin, result[i].time);
    for (const std::size_t i : cycle) result[i].time_in_cycle = result[i].time - begin;
  }
  for (const Cycle& stretch : stretches_of(campaign))
    for (std::size_t k = 1; k < stretch.size(); ++k)
      result[stretch[k]].elapsed =
          std::max(0.0, result[stretch[k]].time - result[stretch[k - 1]].time);
  return result;
}

// In differences a reading counts from the state without load when its session started.
vjm::Conditions without_load(vjm::Conditions conditions) {
  conditions.time = conditions.time_in_cycle = conditions.elapsed = 0;
  conditions.unloaded = true;
  return conditions;
}

}  // namespace

std::size_t Predictor::conditions_index(const vjm::Conditions& conditions) {
  const auto [found, fresh] = known_conditions_.emplace(conditions, conditions_.size());
  if (fresh) conditions_.push_back(conditions);
  return found->second;
}

std::size_t Predictor::reference_index(std::size_t configuration, const vjm::Conditions& conditions,
                                       std::size_t reading) {
  const std::size_t c = conditions_index(without_load(conditions));
  const auto [found, fresh] =
      known_references_.emplace(std::pair(configuration, c), references_.size());
  if (fresh) references_.push_back({configuration, c, reading});
  return found->second;
}

void Predictor::find_cases() {
  conditions_index({});  // the neutral one, first
  std::vector<vjm::Conditions> conditions(campaign_.readings.size());
  if (varies_) conditions = conditions_of(campaign_);
  for (std::size_t r = 0; r < conditions.size(); ++r)
    conditions[r].known_load = campaign_.readings[r].known_load;
  std::map<std::array<double, 12>, std::size_t> known;
  cases_.reserve(campaign_.readings.size());
  for (std::size_t r = 0; r < campaign_.readings.size(); ++r) {
    const Reading& reading = campaign_.readings[r];
    const std::size_t c = conditions_index(conditions[r]);
    std::array<double, 12> key{static_cast<double>(reading.configuration), static_cast<double>(c),
                               has_history_ ? static_cast<double>(r) : 0};
    const vjm::Load& load = reading.load;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      key[3 + i] = load.force[k];
      key[6 + i] = load.moment[k];
      key[9 + i] = load.point_on_platform[k];
    }
    const auto [found, fresh] = known.emplace(key, cases_.size());
    if (fresh)
      cases_.push_back({reading.configuration, load, c,
                        reference_index(reading.configuration, vjm::Conditions(conditions_[c]), r),
                        true, r});
    cases_[found->second].may_fail &= reading.masked;
    case_of_reading_.push_back(found->second);
  }
}

void Predictor::find_sequences() {
  if (!has_history_) {
    for (std::size_t c = 0; c < cases_.size(); ++c) sequences_.push_back({c});
    return;
  }
  for (const Cycle& stretch : stretches_of(campaign_)) {
    sequences_.emplace_back();
    for (const std::size_t reading : stretch)
      sequences_.back().push_back(case_of_reading_[reading]);
  }
}

vjm::Response Predictor::solve(const Run& run, std::size_t configuration, const vjm::Load& load,
                               std::size_t conditions, const vjm::Response& before,
                               const vjm::SystemState* near) const {
  const vjm::PostureResult& start = (*postures_)[configuration];
  if (start.reached) {
    vjm::Response response =
        run.model.respond(start.posture, load, conditions_[conditions], before, run.parameters,
                          run.with_derivatives, near, run.with_compliance);
    observe(response);
    return response;
  }
  vjm::Response response = before;
  response.failure = start.reason;
  return response;
}

// From the platform in base axes to what the campaign measures of it.
void Predictor::observe(vjm::Response& response) const {
  if (campaign_.observation.is_default() || !response.failure.empty()) return;
  response.derivatives = campaign_.observation.motion(response.observed, response.derivatives);
  if (response.by_wrench.cols() > 0)
    response.by_wrench = campaign_.observation.motion(response.observed, response.by_wrench);
  response.observed = campaign_.observation.seen(response.observed);
}

// States without load, from which differences are measured and histories start.
std::vector<vjm::Response> Predictor::references(const Run& run, common::Progress& progress) const {
  const vjm::Response rest = run.model.at_rest(run.parameters.size());
  std::vector<vjm::Response> states(references_.size(), rest);
  if (campaign_.displacement == DisplacementKind::absolute && !has_history_) return states;
  if (run.model.is_relaxed_when_unloaded()) {
    for (std::size_t i = 0; i < states.size(); ++i) {
      states[i].observed = (*postures_)[references_[i].configuration].posture.platform;
      if (run.with_derivatives)
        states[i].derivatives.setZero(6, static_cast<Eigen::Index>(run.parameters.size()));
      observe(states[i]);
    }
    return states;
  }
  common::parallel_for(
      states.size(), threads_, "states without load", progress, [&](std::size_t i) {
        states[i] = solve(run, references_[i].configuration, {}, references_[i].conditions, rest,
                          run.unloaded_near(references_[i].reading));
      });
  return states;
}

void Predictor::follow(const Run& run, const std::vector<std::size_t>& sequence,
                       const std::vector<vjm::Response>& unloaded,
                       std::vector<CaseResult>& results) const {
  vjm::Response before = unloaded[cases_[sequence.front()].reference];
  for (const std::size_t c : sequence) {
    const LoadCase& at = cases_[c];
    vjm::Response response = before.failure.empty()
                                 ? solve(run, at.configuration, at.load, at.conditions, before,
                                         run.loaded_near(at.reading))
                                 : before;
    if (campaign_.displacement == DisplacementKind::absolute) {
      results[c] = {.failure = response.failure,
                    .displacement = spatial::pose_difference({}, response.observed),
                    .derivatives = response.derivatives,
                    .by_wrench = response.by_wrench,
                    .state = {}};
    } else {
      results[c] = displacement_from(unloaded[at.reference], response);
    }
    const spatial::Pose loaded = campaign_.observation.platform(response.observed);
    results[c].work = campaign_.observation.wrench((*postures_)[at.configuration].posture.platform,
                                                   loaded, at.load.at_reference_point(loaded));
    results[c].state = response.state;
    // A masked reading without an equilibrium leaves the history as it was.
    if (response.failure.empty() || !at.may_fail) before = std::move(response);
  }
}

void Predictor::enter(const CaseResult& result, std::size_t index, Predictions& predictions) const {
  const Reading& reading = campaign_.readings[index];
  if (!result.failure.empty()) {
    if (!reading.masked && !predictions.failure) predictions.failure = {index, result.failure};
    return;
  }
  Vector6& displacement = predictions.displacement[index];
  displacement = result.displacement;
  displacement.tail<3>() =
      nearest_rotation_vector(result.displacement.tail<3>(), reading.displacement.tail<3>());
  const spatial::Matrix3 of_vector = spatial::left_jacobian_inverse(displacement.tail<3>());
  predictions.work[index] = result.work;
  if (!predictions.by_wrench.empty()) {
    predictions.by_wrench[index] = result.by_wrench;
    predictions.by_wrench[index].bottomRows<3>() = of_vector * result.by_wrench.bottomRows<3>();
  }
  if (predictions.derivatives.empty()) return;
  auto& derivatives = predictions.derivatives[index];
  derivatives = result.derivatives;
  derivatives.bottomRows<3>() = of_vector * result.derivatives.bottomRows<3>();
}

// The displacement from one state to another, with its derivatives: a rotation increment of the
// first state counts turned by the displacement.
Predictor::CaseResult Predictor::displacement_from(const vjm::Response& from,
                                                   const vjm::Response& to) const {
  CaseResult result{.failure = to.failure.empty() ? from.failure : to.failure,
                    .derivatives = to.derivatives,
                    .by_wrench = to.by_wrench,
                    .state = {}};
  if (!result.failure.empty()) return result;
  result.displacement = spatial::pose_difference(from.observed, to.observed);
  if (result.derivatives.size() > 0) {
    const spatial::Matrix3 turn = to.observed.rotation() * from.observed.rotation().transpose();
    result.derivatives.topRows<3>() -= from.derivatives.topRows<3>();
    result.derivatives.bottomRows<3>() -= turn * from.derivatives.bottomRows<3>();
  }
  if (campaign_.observation.platform_axes) {
    const spatial::Matrix3 back = from.observed.rotation().transpose();
    for (const Eigen::Index first : {0, 3})
      if (result.by_wrench.cols() > 0)
        result.by_wrench.middleRows<3>(first) =
            (back * result.by_wrench.middleRows<3>(first)).eval();
    into_axes_of(from.observed, from.derivatives, result.displacement, result.derivatives);
  }
  return result;
}

Predictions Predictor::predict(const std::vector<Parameter>& parameters,
                               const Eigen::VectorXd& values, bool with_derivatives,
                               common::Progress& progress, const Predictions* near) const {
  return predict(parameters, values, with_derivatives ? parameters : std::vector<Parameter>(),
                 progress, near);
}

Predictions Predictor::predict(const std::vector<Parameter>& parameters,
                               const Eigen::VectorXd& values,
                               const std::vector<Parameter>& derivatives_by,
                               common::Progress& progress, const Predictions* near) const {
  const vjm::EffectModel model = with_values(bare_, effects_, parameters, values);
  return predict({model, model_parameters(derivatives_by), !derivatives_by.empty(), near},
                 progress);
}

Predictions Predictor::predict_with_compliance(const std::vector<Parameter>& parameters,
                                               const Eigen::VectorXd& values,
                                               common::Progress& progress) const {
  const vjm::EffectModel model = with_values(bare_, effects_, parameters, values);
  return predict({.model = model, .parameters = {}, .with_compliance = true}, progress);
}

Predictions Predictor::predict(const Run& run, common::Progress& progress) const {
  const std::vector<vjm::Response> unloaded = references(run, progress);
  std::vector<CaseResult> results(cases_.size());
  common::parallel_for(sequences_.size(), threads_, "loaded equilibria", progress,
                       [&](std::size_t i) { follow(run, sequences_[i], unloaded, results); });
  const std::size_t n = campaign_.readings.size();
  Predictions predictions;
  predictions.displacement.assign(n, CaseResult().displacement);
  if (run.with_compliance) predictions.by_wrench.assign(n, spatial::Matrix6::Zero());
  predictions.work.assign(n, Vector6::Zero());
  if (run.with_derivatives) predictions.derivatives.resize(n);
  // States are most of the memory that many readings need: the last reading of a case takes its
  // own, and relaxed ones are none.
  std::vector<std::size_t> last(cases_.size());
  for (std::size_t i = 0; i < n; ++i) last[case_of_reading_[i]] = i;
  const bool relaxed = std::all_of(unloaded.begin(), unloaded.end(), [](const vjm::Response& r) {
    return r.state.bodies.empty() && r.state.coordinates.empty();
  });
  predictions.loaded.reserve(n);
  if (!relaxed) predictions.unloaded.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t c = case_of_reading_[i];
    enter(results[c], i, predictions);
    vjm::SystemState& state = results[c].state;
    predictions.loaded.push_back(last[c] == i ? std::move(state) : state);
    if (!relaxed) predictions.unloaded.push_back(unloaded[cases_[c].reference].state);
  }
  return predictions;
}

Vector3 nearest_rotation_vector(const Vector3& vector, const Vector3& measured) {
  const double angle = vector.norm();
  if (angle < 1e-3) return vector;
  const Vector3 other = vector * (1 - 2 * std::numbers::pi / angle);
  const auto distance = [&measured](const Vector3& v) {
    double sum = 0;
    for (Eigen::Index i = 0; i < 3; ++i)
      if (!std::isnan(measured[i])) sum += (v[i] - measured[i]) * (v[i] - measured[i]);
    return sum;
  };
  return distance(other) < distance(vector) ? other : vector;
}

}  // namespace kinetostat::calibration

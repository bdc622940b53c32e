#include "kinetostat/calibration/regression/predict.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <tuple>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/faults.h"
#include "kinetostat/common/parallel.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/effects/watcher.h"

namespace kinetostat::calibration {

using spatial::Vector3;
using spatial::Vector6;

// An equilibrium, and what the sensors of the campaign see of it.
struct Predictor::State {
  vjm::Response response;
  std::vector<Seen> seen;
};

namespace {

// What one sensor reads [translation; rotation vector], derivatives as rotation increments.
struct SensorReading {
  Vector6 displacement;
  vjm::Matrix6X derivatives, by_wrench;
};

}  // namespace

struct Predictor::CaseResult {
  std::string failure;                 // empty when solved
  std::vector<SensorReading> sensors;  // empty otherwise
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
  TargetOffset target = {};

  spatial::Pose target_pose() const {
    return {spatial::exp_rotation(target.pose.tail<3>()), target.pose.head<3>()};
  }
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
    : bare_(campaign.watch.is_empty() ? bare : vjm::with_watched(bare, campaign.watch)),
      campaign_(campaign),
      threads_(threads) {
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
  refuse_blind_levels(faults);
  faults.throw_if_any();
}

// A level that stands so that an axis of it is vertical senses no turn about it.
void Predictor::refuse_blind_levels(common::Faults& faults) const {
  const auto is_level = [this](const Component& c) {
    return campaign_.sensors[c.sensor].kind == SensorKind::tilt;
  };
  const std::vector<Component>& components = campaign_.components;
  if (std::none_of(components.begin(), components.end(), is_level)) return;
  std::vector<std::vector<bool>> blind(campaign_.configurations.size());  // one a component
  for (std::size_t i = 0; i < blind.size(); ++i) {
    if (!(*postures_)[i].reached) continue;
    const vjm::Watched rest =
        vjm::watched_at_rest(campaign_.watch, bare_, (*postures_)[i].posture, 0);
    for (const Component& c : components)
      blind[i].push_back(is_level(c) &&
                         is_blind(campaign_.sensors[c.sensor], c.axis, rest, vjm::vertical(bare_)));
  }
  for (const Reading& reading : campaign_.readings)
    for (const Eigen::Index k : components_in_use(reading)) {
      const std::vector<bool>& here = blind[reading.configuration];
      if (here.empty() || !here[static_cast<std::size_t>(k)]) continue;
      const Component& component = campaign_.component(k);
      faults.add(
          {.file = campaign_.readings_file,
           .line = reading.line,
           .key = component.name,
           .what = fmt::format("the axis {} of the level '{}' is vertical in this posture: "
                               "a level senses no turn about it",
                               "xyz"[component.axis], campaign_.sensors[component.sensor].name),
           .cure = "Name the axes that lie flat ('axes: [x, y]'), turn the level by 'at: "
                   "{rpy: [..]}' as it is mounted, or leave the cell empty"});
    }
}

namespace {

// Masked readings were taken, too. One without a cycle stands alone.
std::vector<Cycle> cycles_of(const Campaign& campaign) {
  std::vector<Cycle> result = cycles_as_run(campaign);
  for (std::size_t i = 0; i < campaign.readings.size(); ++i)
    if (campaign.readings[i].cycle.empty()) result.push_back({i});
  return result;
}

// The same, those of a session as one where the history continues: in the order of time where all
// have one, else of rows.
std::vector<Cycle> runs_of(const Campaign& campaign) {
  std::vector<Cycle> cycles = cycles_of(campaign);
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

// The same without a change of configuration inside.
std::vector<Cycle> stretches_of(const Campaign& campaign) {
  std::vector<Cycle> result;
  for (const Cycle& cycle : runs_of(campaign))
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
  std::map<std::vector<double>, std::size_t> known;
  cases_.reserve(campaign_.readings.size());
  for (std::size_t r = 0; r < campaign_.readings.size(); ++r) {
    const Reading& reading = campaign_.readings[r];
    const std::size_t c = conditions_index(conditions[r]);
    std::vector<double> key{static_cast<double>(reading.configuration), static_cast<double>(c),
                            has_history_ ? static_cast<double>(r) : 0};
    key.resize(12);
    const vjm::Load& load = reading.load;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      key[3 + i] = load.force[k];
      key[6 + i] = load.moment[k];
      key[9 + i] = load.point_on_platform[k];
    }
    for (const vjm::NodeLoad& node : load.nodes)
      key.insert(key.end(), {static_cast<double>(node.chain), static_cast<double>(node.node),
                             node.force.x(), node.force.y(), node.force.z()});
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

Predictor::State Predictor::solve(const Run& run, std::size_t configuration, const vjm::Load& load,
                                  std::size_t conditions, const vjm::Response& before,
                                  const vjm::SystemState* near) const {
  const vjm::PostureResult& start = (*postures_)[configuration];
  State state;
  if (start.reached) {
    state.response =
        run.model.respond(start.posture, load, conditions_[conditions], before, run.parameters,
                          run.with_derivatives, near, run.with_compliance);
    observe(run, state);
  } else {
    state.response = before;
    state.response.failure = start.reason;
  }
  return state;
}

namespace {

// What is seen of a target that sits at `offset` on what is seen, with columns for its coordinates:
// of its position [m] in axes of what is seen, then of its rotation vector.
void move_target(const TargetOffset& target, Seen& seen) {
  if (target.differentiated == 0 && target.pose.isZero(0)) return;
  const spatial::Matrix3 axes = seen.pose.rotation();
  const spatial::Matrix3 arm = spatial::skew(axes * target.pose.head<3>());
  for (vjm::Matrix6X* motion : {&seen.motion, &seen.by_wrench})
    if (motion->cols() > 0) motion->topRows<3>() -= (arm * motion->bottomRows<3>()).eval();
  seen.pose = seen.pose *
              spatial::Pose(spatial::exp_rotation(target.pose.tail<3>()), target.pose.head<3>());
  spatial::Matrix6 own = spatial::Matrix6::Zero();
  own.topLeftCorner<3, 3>() = axes;
  own.bottomRightCorner<3, 3>() = axes * spatial::left_jacobian(target.pose.tail<3>());
  const Eigen::Index n = seen.motion.cols();
  seen.motion.conservativeResize(6, n + target.differentiated);
  seen.motion.rightCols(target.differentiated) = own.leftCols(target.differentiated);
}

// The same number of columns for a sensor that sees nothing of the target.
void leave_target(const TargetOffset& target, Eigen::Index parameters, Seen& seen) {
  if (target.differentiated == 0) return;
  seen.motion.conservativeResize(6, parameters + target.differentiated);
  seen.motion.rightCols(target.differentiated).setZero();
}

}  // namespace

// From the platform and all that is watched, in base axes, to what the sensors see.
void Predictor::observe(const Run& run, State& state) const {
  vjm::Response& response = state.response;
  if (!response.failure.empty()) return;
  const Observation& observation = campaign_.observation;
  const Vector3 up = vjm::vertical(bare_);
  for (const Sensor& sensor : campaign_.sensors) {
    if (!sensor.is_platform()) {
      state.seen.push_back(seen_by(sensor, response.watched, campaign_.watch, up));
      leave_target(run.target, std::ssize(run.parameters), state.seen.back());
      continue;
    }
    state.seen.push_back({response.observed, std::move(response.derivatives), {}});
    Seen& seen = state.seen.back();
    seen.by_wrench = std::move(response.by_wrench);
    if (!observation.is_default()) {
      seen.motion = observation.motion(seen.pose, seen.motion);
      if (seen.by_wrench.cols() > 0) seen.by_wrench = observation.motion(seen.pose, seen.by_wrench);
      seen.pose = observation.seen(seen.pose);
    }
    move_target(run.target, seen);
  }
}

// States without load, from which differences are measured and histories start.
std::vector<Predictor::State> Predictor::references(const Run& run,
                                                    common::Progress& progress) const {
  const vjm::Response rest = run.model.at_rest(run.parameters.size());
  std::vector<State> states(references_.size(), {rest, {}});
  if (campaign_.displacement == DisplacementKind::absolute && !has_history_) return states;
  if (run.model.is_relaxed_when_unloaded()) {
    for (std::size_t i = 0; i < states.size(); ++i) {
      states[i].response = run.model.relaxed((*postures_)[references_[i].configuration].posture,
                                             run.parameters.size());
      observe(run, states[i]);
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
                       const std::vector<State>& unloaded, std::vector<CaseResult>& results) const {
  State before = unloaded[cases_[sequence.front()].reference];
  for (const std::size_t c : sequence) {
    const LoadCase& at = cases_[c];
    State loaded = before.response.failure.empty()
                       ? solve(run, at.configuration, at.load, at.conditions, before.response,
                               run.loaded_near(at.reading))
                       : before;
    results[c] = displacements_of(unloaded[at.reference], loaded);
    results[c].work = work_of(run, at, loaded);
    results[c].state = loaded.response.state;
    // A masked reading without an equilibrium leaves the history as it was.
    if (loaded.response.failure.empty() || !at.may_fail) before = std::move(loaded);
  }
}

Vector6 Predictor::work_of(const Run& run, const LoadCase& at, const State& loaded) const {
  if (!campaign_.reads_platform() || loaded.seen.empty()) return Vector6::Zero();
  Observation observation = campaign_.observation;
  const spatial::Pose pose =
      observation.platform(loaded.seen.front().pose * run.target_pose().inverse());
  observation.target += run.target.pose.head<3>();
  return observation.wrench((*postures_)[at.configuration].posture.platform, pose,
                            at.load.at_reference_point(pose));
}

namespace {

// The displacement from one state to another, with its derivatives: a rotation increment of the
// first state counts turned by the displacement.
SensorReading displacement_from(const Seen& from, const Seen& to, bool own_axes) {
  SensorReading result{spatial::pose_difference(from.pose, to.pose), to.motion, to.by_wrench};
  if (result.derivatives.size() > 0) {
    const spatial::Matrix3 turn = to.pose.rotation() * from.pose.rotation().transpose();
    result.derivatives.topRows<3>() -= from.motion.topRows<3>();
    result.derivatives.bottomRows<3>() -= turn * from.motion.bottomRows<3>();
  }
  if (own_axes) {
    const spatial::Matrix3 back = from.pose.rotation().transpose();
    for (const Eigen::Index first : {0, 3})
      if (result.by_wrench.cols() > 0)
        result.by_wrench.middleRows<3>(first) =
            (back * result.by_wrench.middleRows<3>(first)).eval();
    into_axes_of(from.pose, from.motion, result.displacement, result.derivatives);
  }
  return result;
}

// The rotation vector, or the angles, nearest to what was measured; derivatives by it.
void bring_near(SensorReading& reading, SensorKind kind, const Vector6& measured) {
  constexpr double turn = 2 * std::numbers::pi;
  Vector6& displacement = reading.displacement;
  for (Eigen::Index k = 0; kind == SensorKind::tilt && k < 3; ++k) {
    const double about = std::isnan(measured[k]) ? 0 : measured[k];
    displacement[k] -= turn * std::round((displacement[k] - about) / turn);
  }
  if (kind != SensorKind::pose) return;
  displacement.tail<3>() = nearest_rotation_vector(displacement.tail<3>(), measured.tail<3>());
  const spatial::Matrix3 of_vector = spatial::left_jacobian_inverse(displacement.tail<3>());
  for (vjm::Matrix6X* columns : {&reading.by_wrench, &reading.derivatives})
    if (columns->cols() > 0)
      columns->bottomRows<3>() = (of_vector * columns->bottomRows<3>()).eval();
}

void take_off(const SensorReading& other, SensorReading& reading) {
  reading.displacement -= other.displacement;
  if (reading.derivatives.cols() > 0) reading.derivatives -= other.derivatives;
  if (reading.by_wrench.cols() > 0) reading.by_wrench -= other.by_wrench;
}

}  // namespace

void Predictor::enter(const CaseResult& result, std::size_t index, Predictions& predictions) const {
  const Reading& reading = campaign_.readings[index];
  if (!result.failure.empty()) {
    if (!reading.masked && !predictions.failure) predictions.failure = {index, result.failure};
    return;
  }
  std::vector<SensorReading> sensors = result.sensors;
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    const Sensor& sensor = campaign_.sensors[s];
    if (!sensor.minus) {
      bring_near(sensors[s], sensor.kind, measured_by(s, reading));
      continue;
    }
    SensorReading other = result.sensors[*sensor.minus];
    for (SensorReading* one : {&other, &sensors[s]})
      bring_near(*one, sensor.kind, Vector6::Constant(std::numeric_limits<double>::quiet_NaN()));
    take_off(other, sensors[s]);
  }
  predictions.work[index] = result.work;
  const auto take = [&](const auto& of_sensor, auto& rows) {
    for (Eigen::Index k = 0; k < campaign_.size(); ++k) {
      const Component& component = campaign_.component(k);
      rows.row(k) = of_sensor(sensors[component.sensor]).row(component.axis);
    }
  };
  take([](const SensorReading& r) -> const Vector6& { return r.displacement; },
       predictions.displacement[index]);
  if (!predictions.by_wrench.empty()) {
    predictions.by_wrench[index].resize(campaign_.size(), 6);
    take([](const SensorReading& r) -> const vjm::Matrix6X& { return r.by_wrench; },
         predictions.by_wrench[index]);
  }
  if (predictions.derivatives.empty() || sensors.empty()) return;
  predictions.derivatives[index].resize(campaign_.size(), sensors.front().derivatives.cols());
  take([](const SensorReading& r) -> const vjm::Matrix6X& { return r.derivatives; },
       predictions.derivatives[index]);
}

// What was measured by one sensor, NaN elsewhere.
Vector6 Predictor::measured_by(std::size_t sensor, const Reading& reading) const {
  Vector6 result = Vector6::Constant(std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index k = 0; k < campaign_.size(); ++k)
    if (campaign_.component(k).sensor == sensor)
      result[campaign_.component(k).axis] = reading.displacement[k];
  return result;
}

Predictor::CaseResult Predictor::displacements_of(const State& unloaded, State& loaded) const {
  const bool absolute = campaign_.displacement == DisplacementKind::absolute;
  CaseResult result{.failure = loaded.response.failure, .sensors = {}, .state = {}};
  if (result.failure.empty() && !absolute) result.failure = unloaded.response.failure;
  if (!result.failure.empty()) return result;
  for (std::size_t s = 0; s < campaign_.sensors.size(); ++s) {
    const Sensor& sensor = campaign_.sensors[s];
    const bool own = sensor.is_platform() ? campaign_.observation.platform_axes : sensor.own_axes;
    const Seen& seen = loaded.seen[s];
    result.sensors.push_back(absolute ? SensorReading{spatial::pose_difference({}, seen.pose),
                                                      seen.motion, seen.by_wrench}
                                      : displacement_from(unloaded.seen[s], seen, own));
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
                               common::Progress& progress, const Predictions* near,
                               const TargetOffset& target) const {
  const vjm::EffectModel model = this->model(parameters, values);
  return predict({.model = model,
                  .parameters = model_parameters(derivatives_by),
                  .with_derivatives = !derivatives_by.empty(),
                  .near = near,
                  .target = target},
                 progress);
}

Predictions Predictor::predict_with_compliance(const std::vector<Parameter>& parameters,
                                               const Eigen::VectorXd& values,
                                               common::Progress& progress) const {
  const vjm::EffectModel model = this->model(parameters, values);
  return predict({.model = model, .parameters = {}, .with_compliance = true}, progress);
}

vjm::EffectModel Predictor::model(const std::vector<Parameter>& parameters,
                                  const Eigen::VectorXd& values) const {
  vjm::EffectModel model = with_values(bare_, effects_, parameters, values);
  if (!campaign_.watch.is_empty()) model.watch(campaign_.watch);
  return model;
}

Predictions Predictor::predict(const Run& run, common::Progress& progress) const {
  const std::vector<State> unloaded = references(run, progress);
  std::vector<CaseResult> results(cases_.size());
  common::parallel_for(sequences_.size(), threads_, "loaded equilibria", progress,
                       [&](std::size_t i) { follow(run, sequences_[i], unloaded, results); });
  const std::size_t n = campaign_.readings.size();
  Predictions predictions;
  predictions.displacement.assign(
      n, Eigen::VectorXd::Constant(campaign_.size(), std::numeric_limits<double>::quiet_NaN()));
  if (run.with_compliance)
    predictions.by_wrench.assign(n, Eigen::MatrixXd::Zero(campaign_.size(), 6));
  predictions.work.assign(n, Vector6::Zero());
  if (run.with_derivatives || run.target.differentiated > 0) predictions.derivatives.resize(n);
  // States are most of the memory that many readings need: the last reading of a case takes its
  // own, and relaxed ones are none.
  std::vector<std::size_t> last(cases_.size());
  for (std::size_t i = 0; i < n; ++i) last[case_of_reading_[i]] = i;
  const bool relaxed = std::all_of(unloaded.begin(), unloaded.end(), [](const State& s) {
    return s.response.state.bodies.empty() && s.response.state.coordinates.empty();
  });
  predictions.loaded.reserve(n);
  if (!relaxed) predictions.unloaded.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t c = case_of_reading_[i];
    enter(results[c], i, predictions);
    vjm::SystemState& state = results[c].state;
    predictions.loaded.push_back(last[c] == i ? std::move(state) : state);
    if (!relaxed) predictions.unloaded.push_back(unloaded[cases_[c].reference].response.state);
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

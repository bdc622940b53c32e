#include "kinetostat/calibration/regression/predict.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <numbers>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/calibration/regression/instrument_lag.h"
#include "kinetostat/calibration/regression/reading_offsets.h"
#include "kinetostat/calibration/statistics/median.h"
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
  double force = 0;  // that was found, where a displacement is set
};

// What one sensor reads [translation; rotation vector], derivatives as rotation increments.
struct SensorReading {
  Vector6 displacement;
  vjm::Matrix6X derivatives, by_wrench;
};

struct Predictor::CaseResult {
  std::string failure;                 // empty when solved
  std::vector<SensorReading> sensors;  // of use then
  Vector6 work = Vector6::Zero();
};

// Memory that one thread uses for case after case.
struct Predictor::Scratch {
  std::array<State, 2> loaded;
  CaseResult result;
  std::vector<SensorReading> sensors, each;
  Eigen::MatrixXd derivatives;
};

// Why cases have no equilibrium, from any thread.
class Predictor::Failures {
 public:
  void add(std::size_t of_case, const std::string& reason) {
    const std::lock_guard lock(mutex_);
    reasons_.emplace(of_case, reason);
  }
  const std::map<std::size_t, std::string>& reasons() const { return reasons_; }

 private:
  std::mutex mutex_;
  std::map<std::size_t, std::string> reasons_;
};

// One prediction: the model at its values, and what is asked of it.
struct Predictor::Run {
  const vjm::EffectModel& model;
  std::vector<vjm::ModelParameter> parameters;
  bool with_derivatives = false;
  const Predictions* near = nullptr;
  bool with_compliance = false;
  std::vector<TargetOffset> targets = {};
  const CondensedModel* without = nullptr;  // its last effect
  const ReadingTaker* take = nullptr;
  bool few_states = false;

  // Of the platform, where its sensor is the first.
  Vector6 target_of_platform() const {
    const bool is_moved = !targets.empty() && targets.front().sensor == 0;
    return is_moved ? targets.front().pose : Vector6(Vector6::Zero());
  }
  Eigen::Index target_columns() const {
    Eigen::Index count = 0;
    for (const TargetOffset& target : targets) count += target.differentiated;
    return count;
  }
  const vjm::SystemState* loaded_near(std::size_t reading, std::size_t configuration) const {
    if (near == nullptr || near->loaded.empty()) return nullptr;
    return &near->loaded[near->few_states ? configuration : reading];
  }
  const vjm::SystemState* unloaded_near(std::size_t reading, std::size_t configuration) const {
    if (near == nullptr || near->unloaded.empty()) return nullptr;
    return &near->unloaded[near->few_states ? configuration : reading];
  }
  const vjm::CondensedState* loaded_without(std::size_t reading) const {
    return without == nullptr ? nullptr : state_without(without->loaded[reading]);
  }
  const vjm::CondensedState* unloaded_without(std::size_t reading) const {
    return without == nullptr ? nullptr : state_without(without->unloaded[reading]);
  }

 private:
  const vjm::CondensedState* state_without(std::size_t number) const {
    const auto& state = without->states[number];
    return state ? &*state : nullptr;
  }
};

namespace {

vjm::PostureResult unloaded_posture(const vjm::Manipulator& manipulator,
                                    const Configuration& configuration) {
  if (configuration.target) return vjm::posture_at(manipulator, *configuration.target);
  return vjm::posture_from_joints(manipulator, configuration.joints);
}

}  // namespace

bool CondensedModel::knows(const vjm::JointPlace& joint) const {
  constexpr double nearly_all = 0.9;
  const auto known = std::count_if(states.begin(), states.end(),
                                   [&](const auto& state) { return state && state->find(joint); });
  return static_cast<double>(known) >= nearly_all * static_cast<double>(states.size());
}

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

Predictor::Predictor(const Predictor& like, std::vector<vjm::Effect> effects, int threads)
    : bare_(like.bare_), campaign_(like.campaign_), threads_(threads), postures_(like.postures_) {
  set_effects(std::move(effects));
}

Predictor Predictor::with_effects(std::vector<vjm::Effect> effects) const {
  return {*this, std::move(effects), threads_};
}

Predictor Predictor::with_effects(std::vector<vjm::Effect> effects, int threads) const {
  return {*this, std::move(effects), threads};
}

void Predictor::set_effects(std::vector<vjm::Effect> effects) {
  effects_ = std::move(effects);
  for (const vjm::Effect& effect : effects_) {
    varies_ |= effect.kind->varies;
    has_history_ |= effect.kind->history > 0;
    on_numbers_ |= effect.kind->acts_on_numbers();
  }
  find_cases();
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

// Of each session in which all readings have a time and a temperature: those, in the order of time.
std::map<std::size_t, vjm::TemperaturePast> temperatures_of(const Campaign& campaign) {
  std::map<std::size_t, std::vector<vjm::TemperatureAt>> records;
  std::set<std::size_t> unknown;
  for (const Reading& r : campaign.readings) {
    if (!r.time || !r.temperature) unknown.insert(r.session);
    records[r.session].push_back({r.time.value_or(0), r.temperature.value_or(0)});
  }
  std::map<std::size_t, vjm::TemperaturePast> result;
  for (auto& [session, record] : records) {
    if (unknown.contains(session)) continue;
    std::stable_sort(record.begin(), record.end(),
                     [](const auto& a, const auto& b) { return a.time < b.time; });
    result[session].of_session =
        std::make_shared<const std::vector<vjm::TemperatureAt>>(std::move(record));
  }
  return result;
}

// Up to a time.
vjm::TemperaturePast past_of(const std::map<std::size_t, vjm::TemperaturePast>& temperatures,
                             const Reading& reading) {
  const auto found = temperatures.find(reading.session);
  if (found == temperatures.end()) return {};
  vjm::TemperaturePast past = found->second;
  const auto end = std::upper_bound(past.of_session->begin(), past.of_session->end(), *reading.time,
                                    [](double time, const auto& at) { return time < at.time; });
  past.count = static_cast<std::size_t>(end - past.of_session->begin());
  return past;
}

// When the state without load of a load cycle was read, in the times of `of` [s]: where that is no
// reading of its own, about as long before the first one as it is from one to the next.
double zeroed_at(const Campaign& campaign, const Cycle& cycle,
                 const std::vector<vjm::Conditions>& of) {
  const auto earlier = [&](std::size_t a, std::size_t b) { return of[a].time < of[b].time; };
  Cycle by_time = cycle;
  std::stable_sort(by_time.begin(), by_time.end(), earlier);
  const double first = of[by_time.front()].time;
  const bool is_there = level_of(campaign.readings[by_time.front()].load) == 0;
  if (campaign.displacement == DisplacementKind::absolute || is_there || by_time.size() < 2)
    return first;
  std::vector<double> intervals;
  for (std::size_t k = 1; k < by_time.size(); ++k)
    intervals.push_back(of[by_time[k]].time - of[by_time[k - 1]].time);
  return first - upper_median(std::move(intervals));
}

std::vector<vjm::Conditions> conditions_of(const Campaign& campaign) {
  const std::map<std::size_t, vjm::TemperaturePast> temperatures = temperatures_of(campaign);
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
                      .past = past_of(temperatures, r),
                      .session = campaign.sessions[r.session],
                      .setting = r.setting});
    for (const Covariate& c : campaign.covariates)
      if (const std::optional<double> value = c.number(i))
        result.back().covariates.emplace(c.name, *value);
  }
  for (const Cycle& cycle : all_cycles(campaign)) {
    const bool is_cycle = !campaign.readings[cycle.front()].cycle.empty();
    const double begin = is_cycle ? zeroed_at(campaign, cycle, result) : 0;
    for (const std::size_t i : cycle) result[i].time_in_cycle = result[i].time - begin;
  }
  for (const Cycle& stretch : histories_of(campaign))
    for (std::size_t k = 1; k < stretch.size(); ++k)
      result[stretch[k]].elapsed =
          std::max(0.0, result[stretch[k]].time - result[stretch[k - 1]].time);
  return result;
}

// The readings whose temperature those are counted from have that are given: the first of each
// posture in their load cycles, which the unloaded state was read before. Without cycles each
// itself.
std::vector<std::size_t> datums_of(const Campaign& campaign) {
  std::vector<std::size_t> datums(campaign.readings.size());
  std::iota(datums.begin(), datums.end(), std::size_t{0});
  for (const Cycle& cycle : all_cycles(campaign)) {
    if (campaign.readings[cycle.front()].cycle.empty()) continue;
    std::map<std::size_t, std::size_t> first;  // of a posture
    for (const std::size_t r : cycle)
      datums[r] = first.emplace(campaign.readings[r].configuration, r).first->second;
  }
  return datums;
}

// In differences a reading counts from the state without load when its session started, at the
// temperature of its load cycle's start.
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
  first_readings_.resize(campaign_.configurations.size());
  for (std::size_t r = campaign_.readings.size(); r-- > 0;)
    first_readings_[campaign_.readings[r].configuration] = r;
  std::vector<vjm::Conditions> conditions(campaign_.readings.size());
  std::vector<std::size_t> datums;  // empty: each itself
  if (varies_) {
    conditions = conditions_of(campaign_);
    datums = datums_of(campaign_);
  }
  for (std::size_t r = 0; r < conditions.size(); ++r)
    conditions[r].known_load = campaign_.readings[r].known_load;
  // By configuration, conditions and load; with a history by the reading itself.
  const auto before = [&](const LoadCase& a, const LoadCase& b) {
    const Reading &first = campaign_.readings[a.reading], &second = campaign_.readings[b.reading];
    const auto key = [&](const LoadCase& at, const Reading& reading) {
      return std::tuple(reading.configuration, at.conditions, at.reference,
                        has_history_ ? at.reading : 0,
                        campaign_.control ? campaign_.control->to[at.reading] : 0.0);
    };
    const auto order = key(a, first) <=> key(b, second);
    return (order != 0 ? order : vjm::order_of(first.load, second.load)) < 0;
  };
  const auto by_index = [&](std::size_t a, std::size_t b) { return before(cases_[a], cases_[b]); };
  std::set<std::size_t, decltype(by_index)> known(by_index);
  std::vector<std::size_t> case_of_reading;
  cases_.reserve(campaign_.readings.size());
  for (std::size_t r = 0; r < campaign_.readings.size(); ++r) {
    const Reading& reading = campaign_.readings[r];
    cases_.push_back({.conditions = conditions_index(conditions[r]), .reading = r});
    cases_.back().reference =
        reference_index(reading.configuration, conditions[datums.empty() ? r : datums[r]], r);
    const auto [found, fresh] = known.insert(cases_.size() - 1);
    if (!fresh) cases_.pop_back();
    cases_[*found].may_fail &= reading.masked;
    case_of_reading.push_back(*found);
  }
  group_readings(case_of_reading);
  if (has_history_) find_sequences(case_of_reading);
}

// Case after case, in their order within each.
void Predictor::group_readings(const std::vector<std::size_t>& case_of_reading) {
  for (const std::size_t c : case_of_reading) ++cases_[c].end;
  for (std::size_t c = 1; c < cases_.size(); ++c) cases_[c].end += cases_[c - 1].end;
  readings_of_cases_.resize(case_of_reading.size());
  for (std::size_t r = case_of_reading.size(); r-- > 0;)
    readings_of_cases_[--cases_[case_of_reading[r]].end] = r;
  // By now each stands where its readings start.
  for (std::size_t c = 0; c < cases_.size(); ++c)
    cases_[c].end = c + 1 < cases_.size() ? cases_[c + 1].end : case_of_reading.size();
}

std::span<const std::size_t> Predictor::readings_of(std::size_t c) const {
  const std::size_t first = c == 0 ? 0 : cases_[c - 1].end;
  return std::span(readings_of_cases_).subspan(first, cases_[c].end - first);
}

void Predictor::find_sequences(const std::vector<std::size_t>& case_of_reading) {
  for (const Cycle& stretch : histories_of(campaign_)) {
    sequences_.emplace_back();
    for (const std::size_t reading : stretch) sequences_.back().push_back(case_of_reading[reading]);
  }
}

void Predictor::solve(const Run& run, std::size_t configuration, const vjm::Load& load,
                      std::size_t conditions, const vjm::Response& before,
                      const vjm::SystemState* near, const vjm::CondensedState* without,
                      State& state) const {
  const vjm::PostureResult& start = (*postures_)[configuration];
  if (!start.reached) {
    state.response = before;
    state.response.failure = start.reason;
    return;
  }
  const vjm::Conditions& under = conditions_[conditions];
  if (without == nullptr ||
      !run.model.respond(*without, load, under, before, run.parameters, state.response))
    state.response =
        run.model.respond(start.posture, load, under, before, run.parameters, run.with_derivatives,
                          near, run.with_compliance || campaign_.control.has_value());
  observe(run, state);
}

namespace {

spatial::Pose pose_of(const Vector6& offset) {
  return {spatial::exp_rotation(offset.tail<3>()), offset.head<3>()};
}

// What a sensor sees of its target, with columns for the coordinates of all targets: of the
// position [m] in axes of what is seen, then of the rotation vector.
void move_target(const std::vector<TargetOffset>& targets, std::size_t sensor,
                 Eigen::Index parameters, Seen& seen) {
  Eigen::Index columns = 0, first = 0;
  const TargetOffset* own = nullptr;
  for (const TargetOffset& target : targets) {
    if (target.sensor == sensor) own = &target, first = columns;
    columns += target.differentiated;
  }
  const spatial::Matrix3 axes = seen.pose.rotation();
  const bool is_moved = own != nullptr && (own->differentiated > 0 || !own->pose.isZero(0));
  if (is_moved) {
    const spatial::Matrix3 arm = spatial::skew(axes * own->pose.head<3>());
    for (vjm::Matrix6X* motion : {&seen.motion, &seen.by_wrench})
      if (motion->cols() > 0) motion->topRows<3>() -= (arm * motion->bottomRows<3>()).eval();
    seen.pose = seen.pose * pose_of(own->pose);
  }
  if (columns == 0) return;
  seen.motion.conservativeResize(6, parameters + columns);
  seen.motion.rightCols(columns).setZero();
  if (!is_moved) return;
  spatial::Matrix6 by_target = spatial::Matrix6::Zero();
  by_target.topLeftCorner<3, 3>() = axes;
  by_target.bottomRightCorner<3, 3>() = axes * spatial::left_jacobian(own->pose.tail<3>());
  seen.motion.middleCols(parameters + first, own->differentiated) =
      by_target.leftCols(own->differentiated);
}

}  // namespace

// From the platform and all that is watched, in base axes, to what the sensors see.
void Predictor::observe(const Run& run, State& state) const {
  vjm::Response& response = state.response;
  if (!response.failure.empty()) return;
  const Observation& observation = campaign_.observation;
  const Vector3 up = vjm::vertical(bare_);
  state.seen.resize(campaign_.sensors.size());
  for (std::size_t number = 0; number < state.seen.size(); ++number) {
    const Sensor& sensor = campaign_.sensors[number];
    Seen& seen = state.seen[number];
    if (sensor.kind == SensorKind::load) {
      seen.pose = {};
      seen.motion.setZero(6, std::ssize(run.parameters) + run.target_columns());
      seen.by_wrench.setZero(6, 6);
      continue;
    }
    if (!sensor.is_platform()) {
      seen = seen_by(sensor, response.watched, campaign_.watch, up);
      move_target(run.targets, number, std::ssize(run.parameters), seen);
      continue;
    }
    seen.pose = response.observed;
    seen.motion.swap(response.derivatives);
    seen.by_wrench.swap(response.by_wrench);
    if (!observation.is_default()) {
      seen.motion = observation.motion(seen.pose, seen.motion);
      if (seen.by_wrench.cols() > 0) seen.by_wrench = observation.motion(seen.pose, seen.by_wrench);
      seen.pose = observation.seen(seen.pose);
    }
    move_target(run.targets, number, std::ssize(run.parameters), seen);
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
        solve(run, references_[i].configuration, {}, references_[i].conditions, rest,
              run.unloaded_near(references_[i].reading, references_[i].configuration),
              run.unloaded_without(references_[i].reading), states[i]);
      });
  return states;
}

void Predictor::follow(const Run& run, std::span<const std::size_t> sequence,
                       const std::vector<State>& unloaded, Predictions& predictions,
                       Failures& failures) const {
  thread_local Scratch scratch;
  const State* before = &unloaded[cases_[sequence.front()].reference];
  std::size_t next = 0;
  for (const std::size_t c : sequence) {
    const LoadCase& at = cases_[c];
    State& loaded = scratch.loaded[next];
    if (before->response.failure.empty())
      under_load(run, at, unloaded[at.reference], before->response, loaded);
    else
      loaded = *before;
    CaseResult& result = scratch.result;
    find_displacements(unloaded[at.reference], loaded, result);
    if (!result.failure.empty()) {
      failures.add(c, result.failure);
    } else {
      if (run.without == nullptr)
        result.work = work_of(run, campaign_.readings[at.reading], loaded);
      if (campaign_.control) hold_displacement(run, at, before->response, loaded, result);
    }
    for (const std::size_t r : readings_of(c)) {
      enter(run, r, scratch, predictions);
      if (const auto place = place_of_state(run, r))
        predictions.loaded[*place] = loaded.response.state;
    }
    // A masked reading without an equilibrium leaves the history as it was.
    if (!loaded.response.failure.empty() && at.may_fail) continue;
    before = &loaded;
    next = 1 - next;
  }
}

Vector6 Predictor::work_of(const Run& run, const Reading& reading, const State& loaded) const {
  if (!campaign_.reads_platform() || loaded.seen.empty()) return Vector6::Zero();
  Observation observation = campaign_.observation;
  const spatial::Pose pose =
      observation.platform(loaded.seen.front().pose * pose_of(run.target_of_platform()).inverse());
  observation.target += run.target_of_platform().head<3>();
  return observation.wrench((*postures_)[reading.configuration].posture.platform, pose,
                            reading.load.at_reference_point(pose));
}

namespace {

// The displacement from one state to another, with its derivatives: a rotation increment of the
// first state counts turned by the displacement.
void find_displacement(const Seen& from, const Seen& to, bool own_axes, SensorReading& result) {
  result.displacement = spatial::pose_difference(from.pose, to.pose);
  result.derivatives = to.motion;
  result.by_wrench = to.by_wrench;
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

void Predictor::enter(const Run& run, std::size_t index, Scratch& scratch,
                      Predictions& predictions) const {
  const Reading& reading = campaign_.readings[index];
  const CaseResult& result = scratch.result;
  if (!result.failure.empty()) return;
  std::vector<SensorReading>& sensors = scratch.sensors;
  std::vector<SensorReading>& each = scratch.each;
  Eigen::MatrixXd& derivatives = scratch.derivatives;
  sensors = result.sensors;
  // Each by itself, where one is taken off another.
  if (std::any_of(campaign_.sensors.begin(), campaign_.sensors.end(),
                  [](const Sensor& sensor) { return sensor.minus.has_value(); }))
    each = sensors;
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    const Sensor& sensor = campaign_.sensors[s];
    if (!sensor.minus) {
      bring_near(sensors[s], sensor.kind, measured_by(s, reading));
      continue;
    }
    SensorReading other = each[*sensor.minus];
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
  if (sensors.empty()) return;
  derivatives.resize(campaign_.size(), sensors.front().derivatives.cols());
  take([](const SensorReading& r) -> const vjm::Matrix6X& { return r.derivatives; }, derivatives);
  if (run.take != nullptr)
    (*run.take)(index, predictions.displacement[index], predictions.work[index], derivatives);
  else if (!predictions.derivatives.empty())
    predictions.derivatives[index] = derivatives;
}

// Of a rotation vector v its increment w about axes of the platform is read as J(-v)^-1 w.
PlatformAxes Predictor::platform_axes() const {
  PlatformAxes axes;
  const bool is_absolute = campaign_.displacement == DisplacementKind::absolute;
  if (!is_absolute || !campaign_.reads_platform()) return axes;
  axes.reserve(campaign_.readings.size());
  for (std::size_t r = 0; r < campaign_.readings.size(); ++r) {
    const spatial::Pose seen = campaign_.observation.seen(posture_of(r).platform);
    const Vector3 turned = nearest_rotation_vector(spatial::log_rotation(seen.rotation()),
                                                   measured_by(0, campaign_.readings[r]).tail<3>());
    spatial::Matrix6& of = axes.emplace_back(spatial::Matrix6::Zero());
    of.topLeftCorner<3, 3>() = seen.rotation();
    of.bottomRightCorner<3, 3>() = spatial::left_jacobian_inverse(-turned);
  }
  return axes;
}

// What was measured by one sensor, NaN elsewhere.
Vector6 Predictor::measured_by(std::size_t sensor, const Reading& reading) const {
  Vector6 result = Vector6::Constant(std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index k = 0; k < campaign_.size(); ++k)
    if (campaign_.component(k).sensor == sensor)
      result[campaign_.component(k).axis] = reading.displacement[k];
  return result;
}

void Predictor::find_displacements(const State& unloaded, const State& loaded,
                                   CaseResult& result) const {
  const bool absolute = campaign_.displacement == DisplacementKind::absolute;
  result.failure = loaded.response.failure;
  result.work.setZero();
  if (result.failure.empty() && !absolute) result.failure = unloaded.response.failure;
  if (!result.failure.empty()) return;
  result.sensors.resize(campaign_.sensors.size());
  for (std::size_t s = 0; s < campaign_.sensors.size(); ++s) {
    const Sensor& sensor = campaign_.sensors[s];
    const bool own = sensor.is_platform() ? campaign_.observation.platform_axes : sensor.own_axes;
    const Seen& seen = loaded.seen[s];
    SensorReading& reading = result.sensors[s];
    if (!absolute) {
      find_displacement(unloaded.seen[s], seen, own, reading);
      continue;
    }
    reading.displacement = spatial::pose_difference({}, seen.pose);
    reading.derivatives = seen.motion;
    reading.by_wrench = seen.by_wrench;
  }
}

void Predictor::under_load(const Run& run, const LoadCase& at, const State& unloaded,
                           const vjm::Response& before, State& state) const {
  if (campaign_.control) {
    at_displacement(run, at, unloaded, before, state);
    return;
  }
  const Reading& reading = campaign_.readings[at.reading];
  solve(run, reading.configuration, reading.load, at.conditions, before,
        run.loaded_near(at.reading, reading.configuration), run.loaded_without(at.reading), state);
}

namespace {

// The root of a function that only grows or only falls: Newton's steps where they stay between
// values on both sides of it, else halves of what lies between these.
class RootSearch {
 public:
  explicit RootSearch(double start) : at_(start) {}
  double at() const { return at_; }

  // False when the root is found to rounding.
  bool step(double value, double slope) {
    constexpr double rounding = 1e-15;
    ((value > 0) == (slope > 0) ? upper_ : lower_) = at_;
    double next = at_ - value / slope;
    if (!(next > lower_ && next < upper_)) {
      if (!std::isfinite(lower_ + upper_)) return false;
      next = (lower_ + upper_) / 2;
    }
    const bool goes_on =
        value != 0 && std::abs(next - at_) > rounding * std::max(std::abs(next), std::abs(at_));
    last_ = std::exchange(at_, next);
    return goes_on;
  }
  // Where there is no value.
  void step_back() { at_ = (at_ + last_) / 2; }

 private:
  double at_, last_ = 0;
  double lower_ = -std::numeric_limits<double>::infinity();
  double upper_ = std::numeric_limits<double>::infinity();
};

}  // namespace

// What the sensor reads whose displacement is set.
SensorReading Predictor::reading_of_set(const CaseResult& result, const LoadCase& at) const {
  const DisplacementControl& control = *campaign_.control;
  const Component& set = campaign_.component(control.set);
  SensorReading reading = result.sensors[set.sensor];
  Vector6 near = Vector6::Constant(std::numeric_limits<double>::quiet_NaN());
  near[set.axis] = control.to[at.reading];
  bring_near(reading, campaign_.sensors[set.sensor].kind, near);
  return reading;
}

// Seeks the force under which what is set is where it was set.
void Predictor::at_displacement(const Run& run, const LoadCase& at, const State& unloaded,
                                const vjm::Response& before, State& state) const {
  constexpr int most = 100;
  constexpr double close = 1e-14;  // [m or rad]
  const DisplacementControl& control = *campaign_.control;
  const Reading& reading = campaign_.readings[at.reading];
  const Eigen::Index axis = campaign_.component(control.set).axis;
  const double read = reading.displacement[control.force];
  RootSearch search(std::isnan(read) ? 0 : read);
  vjm::SystemState last;
  CaseResult result;
  for (int i = 0; i < most; ++i) {
    solve(run, reading.configuration,
          control.with_force(at.reading, reading.configuration, search.at()), at.conditions, before,
          last.bodies.empty() ? run.loaded_near(at.reading, reading.configuration) : &last, nullptr,
          state);
    state.force = search.at();
    find_displacements(unloaded, state, result);
    if (result.failure.empty()) {
      last = state.response.state;
      const SensorReading seen = reading_of_set(result, at);
      const double miss = seen.displacement[axis] - control.to[at.reading];
      const double slope = seen.by_wrench.row(axis).dot(control.along[reading.configuration]);
      if (!(std::abs(miss) > close) || !search.step(miss, slope)) break;
    } else {
      search.step_back();
    }
  }
  if (state.response.failure.empty())
    state.seen[campaign_.component(control.force).sensor].pose =
        spatial::Pose::translation({state.force, 0, 0});
}

// From derivatives under the force that was found to those at the displacement that is set.
void Predictor::hold_displacement(const Run& run, const LoadCase& at, const vjm::Response& before,
                                  State& loaded, CaseResult& result) const {
  const DisplacementControl& control = *campaign_.control;
  const Vector6& along = control.along[campaign_.readings[at.reading].configuration];
  const SensorReading set = reading_of_set(result, at);
  const Eigen::Index axis = campaign_.component(control.set).axis;
  const double slope = set.by_wrench.row(axis).dot(along);
  const Eigen::RowVectorXd force = -set.derivatives.row(axis) / slope;
  const Eigen::RowVectorXd force_by_wrench = -set.by_wrench.row(axis) / slope;
  for (SensorReading& sensor : result.sensors) {
    const Vector6 motion = sensor.by_wrench * along;
    sensor.derivatives += motion * force;
    sensor.by_wrench += motion * force_by_wrench;
  }
  SensorReading& cell = result.sensors[campaign_.component(control.force).sensor];
  cell.derivatives.row(0) += force;
  cell.by_wrench.row(0) += force_by_wrench;
  if (has_history_ && run.with_derivatives)
    carry_into_history(run, at, before, force.head(std::ssize(run.parameters)), loaded);
}

// Histories after it change with the force as well: by central differences.
void Predictor::carry_into_history(const Run& run, const LoadCase& at, const vjm::Response& before,
                                   const Eigen::RowVectorXd& force, State& loaded) const {
  const std::size_t configuration = campaign_.readings[at.reading].configuration;
  const double h = 1e-5 * std::max(1.0, std::abs(loaded.force));
  const auto histories = [&](double changed) {
    return run.model
        .respond((*postures_)[configuration].posture,
                 campaign_.control->with_force(at.reading, configuration, changed),
                 conditions_[at.conditions], before, {}, false, &loaded.response.state)
        .histories;
  };
  const vjm::Histories more = histories(loaded.force + h), less = histories(loaded.force - h);
  for (std::size_t e = 0; e < more.size(); ++e)
    if (more[e].size() > 0)
      loaded.response.history_derivatives[e] += (more[e] - less[e]) / (2 * h) * force;
}

Predictions Predictor::predict(const std::vector<Parameter>& parameters,
                               const Eigen::VectorXd& values, bool with_derivatives,
                               common::Progress& progress) const {
  return predict(parameters, values, with_derivatives ? parameters : std::vector<Parameter>(),
                 progress);
}

Predictions Predictor::predict(const std::vector<Parameter>& parameters,
                               const Eigen::VectorXd& values,
                               const std::vector<Parameter>& derivatives_by,
                               common::Progress& progress, const PredictOptions& options) const {
  const vjm::EffectModel model = this->model(parameters, values);
  return predict({.model = model,
                  .parameters = model_parameters(derivatives_by),
                  .with_derivatives = !derivatives_by.empty(),
                  .near = options.near,
                  .targets = options.targets,
                  .without = options.without,
                  .take = options.take ? &options.take : nullptr,
                  .few_states = options.few_states},
                 progress);
}

// Case after case, each from the histories that the one before leaves.
void Predictor::condense_sequence(
    std::span<const std::size_t> sequence,
    const std::function<void(std::size_t, const vjm::Histories&)>& loaded,
    CondensedModel& model) const {
  const auto& start = model.states[cases_.size() + cases_[sequence.front()].reference];
  if (!start) return;
  const vjm::Histories* before = &start->after;
  for (const std::size_t c : sequence) {
    loaded(c, *before);
    if (model.states[c]) before = &model.states[c]->after;
  }
}

CondensedModel Predictor::condensed(const std::vector<Parameter>& parameters,
                                    const Eigen::VectorXd& values,
                                    const std::vector<vjm::JointPlace>& joints,
                                    const Predictions& near, common::Progress& progress) const {
  const vjm::EffectModel model = this->model(parameters, values);
  const Run run{.model = model, .parameters = {}, .near = &near};
  CondensedModel result;
  result.states.resize(cases_.size() + references_.size());
  result.loaded.resize(campaign_.readings.size());
  result.unloaded.resize(campaign_.readings.size());
  const auto condense = [&](std::size_t configuration, const vjm::Load& load,
                            std::size_t conditions, const vjm::SystemState* at,
                            const vjm::Histories& histories) {
    const vjm::PostureResult& posture = (*postures_)[configuration];
    return posture.reached ? model.condensed(posture.posture, load, conditions_[conditions], joints,
                                             at, histories)
                           : std::nullopt;
  };
  const auto loaded = [&](std::size_t c, const vjm::Histories& histories) {
    const LoadCase& at = cases_[c];
    const Reading& reading = campaign_.readings[at.reading];
    result.states[c] = condense(reading.configuration, reading.load, at.conditions,
                                run.loaded_near(at.reading, reading.configuration), histories);
  };
  // Each model seeks loads of its own where displacements are held.
  if (!campaign_.control) {
    common::parallel_for(references_.size(), threads_, "condensed equilibria", progress,
                         [&](std::size_t i) {
                           const Reference& at = references_[i];
                           result.states[cases_.size() + i] =
                               condense(at.configuration, {}, at.conditions,
                                        run.unloaded_near(at.reading, at.configuration), {});
                         });
    if (has_history_)
      common::parallel_for(
          sequences_.size(), threads_, "condensed equilibria", progress,
          [&](std::size_t i) { condense_sequence(sequences_[i], loaded, result); });
    else
      common::parallel_for(cases_.size(), threads_, "condensed equilibria", progress,
                           [&](std::size_t c) { loaded(c, {}); });
  }
  for (std::size_t c = 0; c < cases_.size(); ++c)
    for (const std::size_t r : readings_of(c)) {
      result.loaded[r] = c;
      result.unloaded[r] = cases_.size() + cases_[c].reference;
    }
  return result;
}

Predictions Predictor::predict_with_compliance(const std::vector<Parameter>& parameters,
                                               const Eigen::VectorXd& values,
                                               common::Progress& progress,
                                               const std::vector<TargetOffset>& targets) const {
  const vjm::EffectModel model = this->model(parameters, values);
  return predict({.model = model, .parameters = {}, .with_compliance = true, .targets = targets},
                 progress);
}

vjm::EffectModel Predictor::model(const std::vector<Parameter>& parameters,
                                  const Eigen::VectorXd& values) const {
  vjm::EffectModel model = with_values(bare_, effects_, parameters, values);
  if (!campaign_.watch.is_empty()) model.watch(campaign_.watch);
  return model;
}

// Where something works on all readings once they are predicted.
Predictions Predictor::predict_then_take(Run run, common::Progress& progress) const {
  const ReadingTaker& take = *std::exchange(run.take, nullptr);
  Predictions predictions = predict(run, progress);
  const bool differentiated = !predictions.derivatives.empty();
  for (std::size_t i = 0; i < predictions.displacement.size(); ++i)
    if (!predictions.displacement[i].array().isNaN().all())
      take(i, predictions.displacement[i], predictions.work[i],
           differentiated ? predictions.derivatives[i] : Eigen::MatrixXd());
  predictions.derivatives.clear();
  return predictions;
}

Predictions Predictor::predict(const Run& run, common::Progress& progress) const {
  if (on_numbers_ && run.take != nullptr) return predict_then_take(run, progress);
  const std::vector<State> unloaded = references(run, progress);
  const std::size_t n = campaign_.readings.size();
  Predictions predictions;
  predictions.displacement.assign(
      n, Eigen::VectorXd::Constant(campaign_.size(), std::numeric_limits<double>::quiet_NaN()));
  if (run.with_compliance)
    predictions.by_wrench.assign(n, Eigen::MatrixXd::Zero(campaign_.size(), 6));
  predictions.work.assign(n, Vector6::Zero());
  if (run.take == nullptr && (run.with_derivatives || run.target_columns() > 0))
    predictions.derivatives.resize(n);
  predictions.few_states = run.few_states;
  predictions.loaded.resize(states_kept(run));
  Failures failures;
  // What is found of a case goes into its readings at once: kept for all it would be most of the
  // memory that many readings need.
  common::parallel_for(has_history_ ? sequences_.size() : cases_.size(), threads_,
                       "loaded equilibria", progress, [&](std::size_t i) {
                         const std::span<const std::size_t> sequence =
                             has_history_ ? std::span<const std::size_t>(sequences_[i])
                                          : std::span<const std::size_t>(&i, 1);
                         follow(run, sequence, unloaded, predictions, failures);
                       });
  for (const auto& [c, reason] : failures.reasons())
    for (const std::size_t r : readings_of(c))
      if (!campaign_.readings[r].masked &&
          (!predictions.failure || r < predictions.failure->reading))
        predictions.failure = {r, reason};
  add_unloaded(run, unloaded, predictions);
  if (on_numbers_) {
    add_lag(campaign_, run.model.effects(), run.parameters, predictions);
    const std::vector<vjm::Effect>& effects = run.model.effects();
    const bool turns = std::any_of(effects.begin(), effects.end(), [](const vjm::Effect& effect) {
      return effect.kind->turns_along(effect.values);
    });
    add_offsets(campaign_, turns ? platform_axes() : PlatformAxes(), effects, run.parameters,
                predictions);
  }
  return predictions;
}

// None of condensed ones, whose states are not found.
std::size_t Predictor::states_kept(const Run& run) const {
  if (run.without != nullptr) return 0;
  return run.few_states ? campaign_.configurations.size() : campaign_.readings.size();
}

std::optional<std::size_t> Predictor::place_of_state(const Run& run, std::size_t reading) const {
  if (run.without != nullptr) return std::nullopt;
  if (!run.few_states) return reading;
  const std::size_t configuration = campaign_.readings[reading].configuration;
  if (first_readings_[configuration] != reading) return std::nullopt;
  return configuration;
}

// Relaxed ones are none.
void Predictor::add_unloaded(const Run& run, const std::vector<State>& unloaded,
                             Predictions& predictions) const {
  const bool relaxed = std::all_of(unloaded.begin(), unloaded.end(), [](const State& s) {
    return s.response.state.bodies.empty() && s.response.state.coordinates.empty();
  });
  if (relaxed || run.without != nullptr) return;
  predictions.unloaded.resize(states_kept(run));
  for (std::size_t c = 0; c < cases_.size(); ++c)
    for (const std::size_t r : readings_of(c))
      if (const auto place = place_of_state(run, r))
        predictions.unloaded[*place] = unloaded[cases_[c].reference].response.state;
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

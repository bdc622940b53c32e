#include "kinetostat/calibration/predict.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "kinetostat/files/error.h"
#include "kinetostat/files/parallel.h"
#include "kinetostat/spatial/rotation.h"

namespace kinetostat::calibration {

using spatial::Vector3;
using spatial::Vector6;

struct Predictor::CaseResult {
  std::string failure;  // empty when solved
  spatial::Pose pose;
  Eigen::Matrix<double, 6, Eigen::Dynamic> derivatives;  // rotations as increments
  Vector6 displacement = Vector6::Constant(std::numeric_limits<double>::quiet_NaN());
};

namespace {

vjm::PostureResult unloaded_posture(const vjm::Manipulator& manipulator,
                                    const Configuration& configuration) {
  if (configuration.target) return vjm::posture_at(manipulator, *configuration.target);
  return vjm::posture_from_joints(manipulator, configuration.joints);
}

}  // namespace

Predictor::Predictor(const vjm::Manipulator& manipulator, const Campaign& campaign, int threads,
                     files::Progress& progress)
    : manipulator_(manipulator), campaign_(campaign), threads_(threads) {
  find_postures(progress);
  find_cases();
}

void Predictor::find_postures(files::Progress& progress) {
  postures_.resize(campaign_.configurations.size());
  files::parallel_for(postures_.size(), threads_, "unloaded postures", progress,
                      [this](std::size_t i) {
                        postures_[i] = unloaded_posture(manipulator_, campaign_.configurations[i]);
                      });
  for (const Reading& reading : campaign_.readings)
    if (const vjm::PostureResult& posture = postures_[reading.configuration];
        !posture.reached && !reading.masked)
      throw files::InputError(
          {.file = campaign_.readings_file,
           .line = reading.line,
           .what = fmt::format("the posture of reading '{}' is out of reach: {}", reading.id,
                               posture.reason),
           .cure = "Check the pose columns, their unit and the robot file, or mask the reading"});
}

void Predictor::find_cases() {
  std::map<std::array<double, 10>, std::size_t> known;
  for (const Reading& reading : campaign_.readings) {
    std::array<double, 10> key{static_cast<double>(reading.configuration)};
    const vjm::Load& load = reading.load;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      key[1 + i] = load.force[k];
      key[4 + i] = load.moment[k];
      key[7 + i] = load.point_on_platform[k];
    }
    const auto [found, fresh] = known.emplace(key, cases_.size());
    if (fresh) cases_.push_back({reading.configuration, load});
    case_of_reading_.push_back(found->second);
  }
}

Predictor::CaseResult Predictor::solve(const vjm::Manipulator& manipulator,
                                       const LoadCase& load_case,
                                       const std::vector<Parameter>& parameters,
                                       bool with_derivatives) const {
  CaseResult result;
  const vjm::PostureResult& start = postures_[load_case.configuration];
  if (!start.reached) {
    result.failure = start.reason;
    return result;
  }
  const vjm::Equilibrium equilibrium =
      vjm::equilibrium_under_load(manipulator, start.posture, load_case.load);
  if (equilibrium.status != vjm::EquilibriumStatus::converged) {
    result.failure = equilibrium.reason;
    return result;
  }
  result.pose = equilibrium.platform;
  if (with_derivatives)
    result.derivatives =
        pose_derivatives(manipulator, start.posture, load_case.load, equilibrium, parameters);
  observe(result.pose, result.derivatives);
  return result;
}

// From the platform in base axes to what the campaign measures of it.
void Predictor::observe(spatial::Pose& pose,
                        Eigen::Matrix<double, 6, Eigen::Dynamic>& derivatives) const {
  if (campaign_.observation.is_default()) return;
  derivatives = campaign_.observation.motion(pose, derivatives);
  pose = campaign_.observation.seen(pose);
}

// The state of every configuration without load, from which differences are measured.
std::vector<Predictor::CaseResult> Predictor::references(const vjm::Manipulator& manipulator,
                                                         const std::vector<Parameter>& parameters,
                                                         bool with_derivatives,
                                                         files::Progress& progress) const {
  std::vector<CaseResult> states(postures_.size());
  if (manipulator.is_relaxed_when_unloaded()) {
    for (std::size_t i = 0; i < states.size(); ++i) {
      states[i].pose = postures_[i].posture.platform;
      if (with_derivatives)
        states[i].derivatives.setZero(6, static_cast<Eigen::Index>(parameters.size()));
      observe(states[i].pose, states[i].derivatives);
    }
    return states;
  }
  files::parallel_for(states.size(), threads_, "states without load", progress, [&](std::size_t i) {
    states[i] = solve(manipulator, {i, {}}, parameters, with_derivatives);
  });
  return states;
}

void Predictor::enter(const CaseResult& result, const Reading& reading, std::size_t index,
                      Predictions& predictions) const {
  if (!result.failure.empty()) {
    if (!reading.masked && !predictions.failure) predictions.failure = {index, result.failure};
    return;
  }
  Vector6& displacement = predictions.displacement[index];
  displacement = result.displacement;
  displacement.tail<3>() =
      nearest_rotation_vector(result.displacement.tail<3>(), reading.displacement.tail<3>());
  if (predictions.derivatives.empty()) return;
  auto& derivatives = predictions.derivatives[index];
  derivatives = result.derivatives;
  derivatives.bottomRows<3>() =
      spatial::left_jacobian_inverse(displacement.tail<3>()) * result.derivatives.bottomRows<3>();
}

// The displacement from one state to another, with its derivatives: a rotation increment of the
// first state counts turned by the displacement.
void Predictor::subtract(const CaseResult& from, CaseResult& to) const {
  if (to.failure.empty()) to.failure = from.failure;
  if (!to.failure.empty()) return;
  to.displacement = spatial::pose_difference(from.pose, to.pose);
  if (to.derivatives.size() > 0) {
    const spatial::Matrix3 turn = to.pose.rotation() * from.pose.rotation().transpose();
    to.derivatives.topRows<3>() -= from.derivatives.topRows<3>();
    to.derivatives.bottomRows<3>() -= turn * from.derivatives.bottomRows<3>();
  }
  if (campaign_.observation.platform_axes)
    into_axes_of(from.pose, from.derivatives, to.displacement, to.derivatives);
}

Predictions Predictor::predict(const std::vector<Parameter>& parameters,
                               const Eigen::VectorXd& values, bool with_derivatives,
                               files::Progress& progress) const {
  const vjm::Manipulator manipulator = with_values(manipulator_, parameters, values);
  std::vector<CaseResult> results(cases_.size());
  files::parallel_for(cases_.size(), threads_, "loaded equilibria", progress, [&](std::size_t i) {
    results[i] = solve(manipulator, cases_[i], parameters, with_derivatives);
  });
  if (campaign_.displacement == DisplacementKind::absolute) {
    for (CaseResult& result : results)
      result.displacement = spatial::pose_difference(spatial::Pose(), result.pose);
  } else {
    const std::vector<CaseResult> unloaded =
        references(manipulator, parameters, with_derivatives, progress);
    for (std::size_t i = 0; i < cases_.size(); ++i)
      subtract(unloaded[cases_[i].configuration], results[i]);
  }
  const std::size_t n = campaign_.readings.size();
  Predictions predictions;
  predictions.displacement.assign(n, CaseResult().displacement);
  if (with_derivatives) predictions.derivatives.resize(n);
  for (std::size_t i = 0; i < n; ++i)
    enter(results[case_of_reading_[i]], campaign_.readings[i], i, predictions);
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

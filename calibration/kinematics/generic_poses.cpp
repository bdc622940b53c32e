#include "kinetostat/calibration/kinematics/generic_poses.h"

#include <array>
#include <random>

#include "kinetostat/calibration/regression/predict.h"
#include "kinetostat/calibration/regression/session_frame.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr std::size_t most_postures = 48;

double uniform(std::mt19937_64& engine, double from, double to) {
  return from + (to - from) * static_cast<double>(engine() >> 11) * 0x1p-53;
}

std::vector<Configuration> random_postures(const vjm::Chain& chain, double reach) {
  constexpr double turn = 2, way = 0.3;  // [rad], of the reach
  std::mt19937_64 engine(1);
  std::vector<Configuration> postures(most_postures);
  for (Configuration& posture : postures)
    for (const vjm::Coordinate& joint : chain.coordinates()) {
      if (joint.role != vjm::Role::actuated) continue;
      const double span = vjm::is_rotation(joint.motion) ? turn : way * reach;
      const auto range = joint.range.value_or(std::array{joint.home - span, joint.home + span});
      posture.joints[chain.name() + "." + joint.name] = uniform(engine, range[0], range[1]);
    }
  return postures;
}

std::vector<Configuration> postures_for(const vjm::Manipulator& bare, const Campaign& campaign,
                                        double reach) {
  if (bare.size() == 1) return random_postures(bare.chains()[0], reach);
  std::vector<Configuration> some;
  const std::size_t stride = 1 + campaign.configurations.size() / most_postures;
  for (std::size_t i = 0; i < campaign.configurations.size(); i += stride)
    some.push_back(campaign.configurations[i]);
  return some;
}

// Whole poses of the platform, without load.
Campaign unloaded_poses(const Campaign& like, std::vector<Configuration> postures) {
  Campaign poses;
  poses.file = like.file;
  poses.readings_file = like.readings_file;
  poses.units = like.units;
  poses.observation = like.observation;
  poses.displacement = DisplacementKind::absolute;
  poses.noise_stated = true;
  poses.sessions = {""};
  poses.configurations = std::move(postures);
  for (std::size_t i = 0; i < poses.configurations.size(); ++i) {
    Reading& reading = poses.readings.emplace_back();
    reading.id = std::to_string(i + 1);
    reading.configuration = i;
    reading.displacement.setZero();
    reading.sigma.setOnes();
  }
  return poses;
}

// Changes of all poses by one tolerance each, translations over the reach; by an unknown frame.
struct Columns {
  MatrixXd frame, parameters;
};

Columns columns_of(const Predictions& predictions, const GeometricModel& model, bool has_frame,
                   double reach) {
  const auto poses = static_cast<Index>(predictions.displacement.size());
  const auto count = static_cast<Index>(model.parameters.size());
  Columns columns{MatrixXd(6 * poses, has_frame ? 6 : 0), MatrixXd(6 * poses, count)};
  for (Index i = 0; i < poses; ++i) {
    const auto at = static_cast<std::size_t>(i);
    columns.parameters.middleRows<6>(6 * i) = predictions.derivatives[at];
    if (has_frame) {
      const spatial::Vector6 pose = predictions.displacement[at];
      columns.frame.middleRows<6>(6 * i) =
          seen_from(spatial::Vector6::Zero(), pose, DisplacementKind::absolute, pose).by_frame;
    }
    columns.parameters.middleRows<3>(6 * i) /= reach;
    columns.frame.middleRows<3>(6 * i) /= reach;
  }
  for (Index k = 0; k < count; ++k)
    columns.parameters.col(k) *= model.parameters[static_cast<std::size_t>(k)].tolerance;
  return columns;
}

IndependentColumns all_of(const GeometricModel& model) {
  IndependentColumns all;
  for (std::size_t k = 0; k < model.parameters.size(); ++k)
    all.kept.push_back(static_cast<Index>(k));
  return all;
}

}  // namespace

IndependentColumns generically_independent(const vjm::Robot& robot, const GeometricModel& model,
                                           const Campaign& campaign, double reach, int threads,
                                           common::Progress& progress) {
  constexpr double alike = 1e-6;  // beside rounding of the equilibria
  if (!campaign.reads_platform()) return all_of(model);
  const vjm::Manipulator bare = robot.without_effects().with_gravity(spatial::Vector3::Zero());
  const Campaign poses = unloaded_poses(campaign, postures_for(bare, campaign, reach));
  std::vector<Parameter> parameters = fit_parameters(model, bare);
  const auto zeros = Eigen::VectorXd::Zero(static_cast<Index>(parameters.size()));
  const Predictor predictor(bare, model.effects, poses, threads, progress);
  const Predictions predictions = predictor.predict(parameters, zeros, true, progress);
  if (predictions.failure) return all_of(model);
  const Columns columns =
      columns_of(predictions, model, campaign.session_frame == SessionFrame::estimated, reach);
  return independent_columns(columns.frame, columns.parameters, 0, alike);
}

}  // namespace kinetostat::calibration

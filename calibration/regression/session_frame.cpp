#include "kinetostat/calibration/regression/session_frame.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "kinetostat/calibration/regression/predict.h"
#include "kinetostat/spatial/rotation.h"

namespace kinetostat::calibration {

using spatial::Matrix3;
using spatial::Matrix6;
using spatial::Vector3;
using spatial::Vector6;

SeenFromFrame seen_from(const Vector6& frame, const Vector6& displacement, DisplacementKind kind,
                        const Vector6& measured) {
  return MeasuringFrame(frame).seen(displacement, kind, measured);
}

MeasuringFrame::MeasuringFrame(const Vector6& frame)
    : position_(frame.head<3>()),
      turn_(spatial::exp_rotation(frame.tail<3>())),
      increment_(spatial::left_jacobian(frame.tail<3>())) {}

SeenFromFrame MeasuringFrame::seen(const Vector6& displacement, DisplacementKind kind,
                                   const Vector6& measured) const {
  const Matrix3 &turn = turn_, &increment = increment_;
  const Vector3 moved = turn * displacement.head<3>();
  SeenFromFrame seen{Vector6::Zero(), Matrix6::Zero(), Matrix6::Zero()};
  seen.by_displacement.topLeftCorner<3, 3>() = turn;
  seen.by_frame.topRightCorner<3, 3>() = -spatial::skew(moved) * increment;
  if (kind == DisplacementKind::difference) {
    const Vector3 turned = turn * displacement.tail<3>();
    seen.displacement << moved, turned;
    seen.by_displacement.bottomRightCorner<3, 3>() = turn;
    seen.by_frame.bottomRightCorner<3, 3>() = -spatial::skew(turned) * increment;
    return seen;
  }
  const Matrix3 rotation = turn * spatial::exp_rotation(displacement.tail<3>());
  const Vector3 turned =
      nearest_rotation_vector(spatial::log_rotation(rotation), measured.tail<3>());
  const Matrix3 inverse = spatial::left_jacobian_inverse(turned);
  seen.displacement << moved + position_, turned;
  seen.by_displacement.bottomRightCorner<3, 3>() =
      inverse * turn * spatial::left_jacobian(displacement.tail<3>());
  seen.by_frame.topLeftCorner<3, 3>().setIdentity();
  seen.by_frame.bottomRightCorner<3, 3>() = inverse * increment;
  return seen;
}

Vector6 frame_between(const std::vector<Vector3>& predicted, const std::vector<Vector3>& measured) {
  if (predicted.size() < 3) return Vector6::Zero();
  const auto matrix = [](const std::vector<Vector3>& points) {
    Eigen::Matrix3Xd m(3, points.size());
    for (std::size_t i = 0; i < points.size(); ++i) m.col(static_cast<Eigen::Index>(i)) = points[i];
    return m;
  };
  const Eigen::Matrix4d motion = Eigen::umeyama(matrix(predicted), matrix(measured), false);
  Vector6 frame;
  frame << motion.topRightCorner<3, 1>(), spatial::log_rotation(motion.topLeftCorner<3, 3>());
  return frame;
}

namespace {

// The target that fits best while frames turn as they do and stand where they must.
Vector3 best_target(const std::vector<PlacedPosition>& positions,
                    const std::vector<Vector6>& frames) {
  struct Means {
    Matrix3 axes = Matrix3::Zero();
    Vector3 error = Vector3::Zero();
    double count = 0;
  };
  std::vector<Means> means(frames.size());
  const auto error_of = [&frames](const PlacedPosition& p) -> Vector3 {
    return spatial::exp_rotation(frames[p.frame].tail<3>()).transpose() * p.measured - p.predicted;
  };
  for (const PlacedPosition& p : positions) {
    means[p.frame].axes += p.axes;
    means[p.frame].error += error_of(p);
    ++means[p.frame].count;
  }
  Matrix3 normal = Matrix3::Zero();
  Vector3 side = Vector3::Zero();
  for (const PlacedPosition& p : positions) {
    const Means& mean = means[p.frame];
    const Matrix3 axes = p.axes - mean.axes / mean.count;
    normal += axes.transpose() * axes;
    side += axes.transpose() * (error_of(p) - mean.error / mean.count);
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(normal);
  constexpr double hardly = 1e-6;  // a milliradian of turn
  Vector3 target = Vector3::Zero();
  for (Eigen::Index k = 0; k < 3; ++k)
    if (solver.eigenvalues()[k] > hardly * static_cast<double>(positions.size())) {
      const Vector3 way = solver.eigenvectors().col(k);
      target += way * way.dot(side) / solver.eigenvalues()[k];
    }
  return target;
}

}  // namespace

FramesAndTarget frames_and_target(const std::vector<PlacedPosition>& positions,
                                  std::size_t frames) {
  constexpr int most_turns = 200;
  constexpr double settled = 1e-9;  // [m]
  FramesAndTarget result;
  for (int turn = 0; turn < most_turns; ++turn) {
    std::vector<std::vector<Vector3>> predicted(frames), measured(frames);
    for (const PlacedPosition& p : positions) {
      predicted[p.frame].push_back(p.predicted + p.axes * result.target);
      measured[p.frame].push_back(p.measured);
    }
    result.frames.clear();
    for (std::size_t f = 0; f < frames; ++f)
      result.frames.push_back(frame_between(predicted[f], measured[f]));
    const Vector3 before = result.target;
    if (!positions.empty()) result.target = best_target(positions, result.frames);
    if ((result.target - before).norm() < settled) break;
  }
  return result;
}

std::vector<FramedComponents> framed_components(const Campaign& campaign) {
  std::vector<FramedComponents> result;
  for (std::size_t s = 0; s < campaign.sensors.size(); ++s) {
    if (!campaign.sensors[s].by_instrument) continue;
    FramedComponents& of_sensor = result.emplace_back();
    for (Eigen::Index k = 0; k < campaign.size(); ++k)
      if (campaign.component(k).sensor == s) {
        of_sensor.axes.push_back(campaign.component(k).axis);
        of_sensor.rows.push_back(k);
      }
  }
  return result;
}

}  // namespace kinetostat::calibration

#include "kinetostat/calibration/regression/session_frame.h"

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
  const Vector3 vector = frame.tail<3>();
  const Matrix3 turn = spatial::exp_rotation(vector);
  const Matrix3 increment = spatial::left_jacobian(vector);  // of `turn`, by `vector`
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
  seen.displacement << moved + frame.head<3>(), turned;
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

}  // namespace kinetostat::calibration

#include "kinetostat/calibration/sensors/observation.h"

#include "kinetostat/spatial/rotation.h"

namespace kinetostat::calibration {

using Columns = Eigen::Matrix<double, 6, Eigen::Dynamic>;
using spatial::Matrix3;
using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;

bool Observation::is_default() const {
  return !platform_axes && target.isZero(0) && frame.position().isZero(0) &&
         frame.rotation() == Matrix3::Identity();
}

Pose Observation::seen(const Pose& platform) const {
  return frame.inverse() * platform * Pose::translation(target);
}

Columns Observation::motion(const Pose& platform, const Columns& motion) const {
  Columns result = motion;
  result.topRows<3>() -= spatial::skew(platform.rotation() * target) * motion.bottomRows<3>();
  result.topRows<3>() = (frame.rotation().transpose() * result.topRows<3>()).eval();
  result.bottomRows<3>() = (frame.rotation().transpose() * result.bottomRows<3>()).eval();
  return result;
}

Pose Observation::platform(const Pose& seen) const {
  return frame * seen * Pose::translation(-target);
}

Vector6 Observation::wrench(const Pose& unloaded, const Pose& loaded, const Vector6& wrench) const {
  const Vector3 force = wrench.head<3>();
  const Vector3 moment = wrench.tail<3>() - (loaded.rotation() * target).cross(force);
  const Matrix3 back = (platform_axes ? unloaded : frame).rotation().transpose();
  Vector6 result;
  result << back * force, back * moment;
  return result;
}

void into_axes_of(const Pose& from, const Columns& from_derivatives, Vector6& displacement,
                  Columns& derivatives) {
  const Matrix3 back = from.rotation().transpose();
  const Vector3 translation = displacement.head<3>();
  // With the increment w of the axes R: d(R'p) = R'(dp - w x p), and the increment of R'TR is that
  // of T less w plus T w, seen from R.
  if (derivatives.cols() > 0) {
    const Matrix3 turn = spatial::exp_rotation(displacement.tail<3>());
    const auto w = from_derivatives.bottomRows<3>();
    derivatives.topRows<3>() =
        (back * (derivatives.topRows<3>() + spatial::skew(translation) * w)).eval();
    derivatives.bottomRows<3>() =
        (back * (derivatives.bottomRows<3>() + (turn - Matrix3::Identity()) * w)).eval();
  }
  displacement.head<3>() = back * translation;
  displacement.tail<3>() = (back * displacement.tail<3>()).eval();
}

}  // namespace kinetostat::calibration

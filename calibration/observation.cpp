#include "kinetostat/calibration/observation.h"

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

Matrix3 Observation::axes(const Pose& platform) const {
  return platform_axes ? platform.rotation() : frame.rotation();
}

Vector6 Observation::wrench(const Pose& platform, const Vector6& wrench) const {
  const Vector3 force = wrench.head<3>();
  const Vector3 moment = wrench.tail<3>() - (platform.rotation() * target).cross(force);
  Vector6 result;
  result << axes(platform).transpose() * force, axes(platform).transpose() * moment;
  return result;
}

void into_axes_of(const Pose& from, const Columns& from_derivatives, Vector6& displacement,
                  Columns& derivatives) {
  const Matrix3 back = from.rotation().transpose();
  // d(R'v) = R'(dv - w x v) with the increment w of R; a rotation vector turns like any other.
  for (const Eigen::Index first : {0, 3}) {
    const Vector3 v = displacement.segment<3>(first);
    if (derivatives.cols() > 0)
      derivatives.middleRows<3>(first) =
          (back *
           (derivatives.middleRows<3>(first) + spatial::skew(v) * from_derivatives.bottomRows<3>()))
              .eval();
    displacement.segment<3>(first) = back * v;
  }
}

}  // namespace kinetostat::calibration

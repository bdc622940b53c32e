#include "kinetostat/vjm/effects/reading_errors.h"

#include "kinetostat/spatial/rotation.h"

namespace kinetostat::vjm {

using spatial::Matrix3;
using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;

ReadingErrors ReadingErrors::tangent() {
  ReadingErrors zero;
  zero.wrench_gain = 0;
  return zero;
}

ReadingErrors& ReadingErrors::operator+=(const ReadingErrors& tangent) {
  wrench_gain += tangent.wrench_gain;
  wrench_rotation += tangent.wrench_rotation;
  wrench_zero += tangent.wrench_zero;
  wrench_curvature += tangent.wrench_curvature;
  wrench_beside += tangent.wrench_beside;
  wrench_channels += tangent.wrench_channels;
  wrench_point += tangent.wrench_point;
  sensor += tangent.sensor;
  sensor_scale += tangent.sensor_scale;
  sensor_axes += tangent.sensor_axes;
  target += tangent.target;
  return *this;
}

bool ReadingErrors::is_none() const { return reads_load() && reads_pose(); }

bool ReadingErrors::reads_pose() const {
  return sensor.isZero(0) && sensor_scale == 0 && sensor_axes.isZero(0) && target.isZero(0);
}

bool ReadingErrors::reads_load() const {
  return wrench_gain == 1 && wrench_rotation.isZero(0) && wrench_point.isZero(0) &&
         wrench_zero.isZero(0) && wrench_curvature.isZero(0) && wrench_beside.isZero(0) &&
         wrench_channels.isZero(0);
}

namespace {

// [force; moment] in the axes of the load cell.
Vector6 in_cell(const Load& stated, const Vector3& force, const Vector3& moment) {
  Vector6 read;
  read << stated.cell.transpose() * force, stated.cell.transpose() * moment;
  return read;
}
Vector6 as_read(const Load& stated) { return in_cell(stated, stated.force, stated.moment); }

// Derivative of |v|^2 v.
Vector3 cube_change(const Vector3& v, const Vector3& change) {
  return 2 * v.dot(change) * v + v.squaredNorm() * change;
}

}  // namespace

Vector6 ReadingErrors::from_cell(const Load& stated, const ReadingErrors& of) {
  const Vector6 read = as_read(stated);
  const Vector3 force = read.head<3>(), moment = read.tail<3>();
  Vector6 result = of.wrench_channels.cwiseProduct(read) + of.wrench_beside;
  result.head<3>() += of.wrench_curvature[0] * force.squaredNorm() * force;
  result.tail<3>() += of.wrench_curvature[1] * moment.squaredNorm() * moment;
  return read.isZero(0) ? result : Vector6(result + of.wrench_zero);
}

Load ReadingErrors::actual(const Load& stated) const {
  if (reads_load()) return stated;
  const Matrix3 turn = stated.cell * (wrench_gain * spatial::exp_rotation(wrench_rotation));
  const Vector6 acting = as_read(stated) + from_cell(stated, *this);
  Load load = stated;
  load.force = turn * acting.head<3>();
  load.moment = turn * acting.tail<3>();
  load.point_on_platform += wrench_point;
  return load;
}

Load ReadingErrors::actual_change(const Load& stated, const Vector6& change) const {
  const Matrix3 turn = stated.cell * (wrench_gain * spatial::exp_rotation(wrench_rotation));
  const Vector6 read = as_read(stated), by = in_cell(stated, change.head<3>(), change.tail<3>());
  Vector6 acting = by + wrench_channels.cwiseProduct(by);
  acting.head<3>() += wrench_curvature[0] * cube_change(read.head<3>(), by.head<3>());
  acting.tail<3>() += wrench_curvature[1] * cube_change(read.tail<3>(), by.tail<3>());
  return {.force = turn * acting.head<3>(),
          .moment = turn * acting.tail<3>(),
          .point_on_platform = stated.point_on_platform + wrench_point};
}

Vector6 ReadingErrors::wrench_derivative(const Load& stated, const Pose& platform,
                                         const ReadingErrors& tangent) const {
  const Matrix3 turn = spatial::exp_rotation(wrench_rotation);
  const Vector3 rate = spatial::left_jacobian(wrench_rotation) * tangent.wrench_rotation;
  const auto change = [&](const Vector3& v, const Vector3& by) -> Vector3 {
    return stated.cell * (tangent.wrench_gain * (turn * v) + wrench_gain * rate.cross(turn * v) +
                          wrench_gain * (turn * by));
  };
  const Load load = actual(stated);
  const Vector6 acting = as_read(stated) + from_cell(stated, *this);
  const Vector6 by = from_cell(stated, tangent);
  const Vector3 force = change(acting.head<3>(), by.head<3>());
  Vector6 wrench;
  wrench << force, change(acting.tail<3>(), by.tail<3>()) +
                       (platform.rotation() * tangent.wrench_point).cross(load.force) +
                       (platform.rotation() * load.point_on_platform).cross(force);
  return wrench;
}

Pose ReadingErrors::observed(const Pose& platform) const {
  if (reads_pose()) return platform;
  const Pose seen(platform.rotation(), scale().cwiseProduct(platform * target));
  return spatial::displaced(Pose(), sensor) * seen;
}

Vector6 ReadingErrors::observed_motion(const Pose& platform, const Vector6& motion) const {
  if (reads_pose()) return motion;
  const Matrix3 turn = spatial::exp_rotation(sensor.tail<3>());
  const Vector3 arm = platform.rotation() * target, spin = motion.tail<3>();
  Vector6 result;
  result << turn * scale().cwiseProduct(motion.head<3>() + spin.cross(arm)), turn * spin;
  return result;
}

Vector6 ReadingErrors::observed_derivative(const Pose& platform,
                                           const ReadingErrors& tangent) const {
  const Pose frame = spatial::displaced(Pose(), sensor);
  const Vector3 spin = spatial::left_jacobian(sensor.tail<3>()) * tangent.sensor.tail<3>();
  const Vector3 seen = platform * target;
  const Vector3 moved = tangent.sensor_scale * seen + tangent.sensor_axes.cwiseProduct(seen) +
                        scale().cwiseProduct(platform.rotation() * tangent.target);
  Vector6 result;
  result << tangent.sensor.head<3>() + spin.cross(frame.rotation() * scale().cwiseProduct(seen)) +
                frame.rotation() * moved,
      spin;
  return result;
}

}  // namespace kinetostat::vjm

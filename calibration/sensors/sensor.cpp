#include "kinetostat/calibration/sensors/sensor.h"

#include <array>
#include <cmath>
#include <limits>

#include "kinetostat/spatial/rotation.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using spatial::Matrix3;
using spatial::Pose;
using spatial::Vector3;
using Columns = Eigen::Matrix<double, 6, Eigen::Dynamic>;

// Rows of a frame in derivatives of a watch.
auto of_frame(const MatrixXd& derivatives, std::size_t frame) {
  return derivatives.middleRows<6>(6 * static_cast<Index>(frame));
}

// Pose seen from a frame that moves as well: with p the way between both, in axes R of the frame,
// d(R'p) = R'(dp - w x p).
Pose relative(const Sensor& sensor, const vjm::Watched& watched) {
  return watched.frames[sensor.from].inverse() * watched.frames[sensor.frame];
}
Columns relative_motion(const Sensor& sensor, const vjm::Watched& watched,
                        const MatrixXd& derivatives) {
  const Pose &from = watched.frames[sensor.from], &frame = watched.frames[sensor.frame];
  const Columns moved = of_frame(derivatives, sensor.frame);
  const Columns base = of_frame(derivatives, sensor.from);
  const Matrix3 back = from.rotation().transpose();
  const Matrix3 arm = spatial::skew(frame.position() - from.position());
  Columns motion(6, derivatives.cols());
  motion.topRows<3>() =
      back * (moved.topRows<3>() - base.topRows<3>() + arm * base.bottomRows<3>());
  motion.bottomRows<3>() = back * (moved.bottomRows<3>() - base.bottomRows<3>());
  return motion;
}

// With the vertical u in the axes of the frame, turns about x and y are atan2(u_y, u_z) and
// atan2(-u_x, u_z), 0 where z points up; that about z is atan2(u_x, u_y), 0 where y does.
struct Tilt {
  Index sine, cosine;  // components of u
  double sign;
};
constexpr std::array tilts = {Tilt{1, 2, 1}, Tilt{0, 2, -1}, Tilt{0, 1, 1}};

Vector3 tilt(const Vector3& up) {
  Vector3 angles;
  for (Index k = 0; k < 3; ++k) {
    const auto& [sine, cosine, sign] = tilts[static_cast<std::size_t>(k)];
    constexpr double vertical = 1e-6;
    angles[k] = std::hypot(up[sine], up[cosine]) > vertical
                    ? std::atan2(sign * up[sine], up[cosine])
                    : std::numeric_limits<double>::quiet_NaN();
  }
  return angles;
}

// Of these angles by rotation increments of the frame, base axes: du = R'(u x w).
Columns tilt_motion(const Vector3& up, const Matrix3& rotation, const Vector3& vertical,
                    const Columns& moved) {
  const Eigen::Matrix3Xd change =
      rotation.transpose() * spatial::skew(vertical) * moved.bottomRows<3>();
  Columns motion = Columns::Zero(6, moved.cols());
  for (Index k = 0; k < 3; ++k) {
    const auto& [sine, cosine, sign] = tilts[static_cast<std::size_t>(k)];
    motion.row(k) = sign * (up[cosine] * change.row(sine) - up[sine] * change.row(cosine)) /
                    (up[sine] * up[sine] + up[cosine] * up[cosine]);
  }
  return motion;
}

}  // namespace

bool is_blind(const Sensor& tilt, Index axis, const vjm::Watched& watched, const Vector3& up) {
  constexpr double least = 1e-3;  // [rad]
  const Vector3 own = watched.frames[tilt.frame].rotation().transpose() * up;
  const auto& [sine, cosine, sign] = tilts[static_cast<std::size_t>(axis)];
  return std::hypot(own[sine], own[cosine]) < least;
}

Seen seen_by(const Sensor& sensor, const vjm::Watched& watched, const vjm::Watch& watch,
             const Vector3& up) {
  Seen seen;
  const auto add = [&](const auto& motion_of) {
    if (watched.derivatives.size() > 0) seen.motion = motion_of(watched.derivatives);
    if (watched.by_wrench.size() > 0) seen.by_wrench = motion_of(watched.by_wrench);
  };
  switch (sensor.kind) {
    case SensorKind::pose:
      seen.pose = relative(sensor, watched);
      add([&](const MatrixXd& d) { return relative_motion(sensor, watched, d); });
      break;
    case SensorKind::tilt: {
      const Matrix3& rotation = watched.frames[sensor.frame].rotation();
      const Vector3 own = rotation.transpose() * up;
      seen.pose = Pose::translation(tilt(own));
      add([&](const MatrixXd& d) {
        return tilt_motion(own, rotation, up, of_frame(d, sensor.frame));
      });
      break;
    }
    case SensorKind::distance: {
      const Vector3 way =
          watched.frames[sensor.frame].position() - watched.frames[sensor.from].position();
      seen.pose = Pose::translation(Vector3(way.norm(), 0, 0));
      add([&](const MatrixXd& d) {
        Columns motion = Columns::Zero(6, d.cols());
        motion.row(0) = way.normalized().transpose() * (of_frame(d, sensor.frame).topRows<3>() -
                                                        of_frame(d, sensor.from).topRows<3>());
        return motion;
      });
      break;
    }
    case SensorKind::load:
      break;  // of no part of the robot
    case SensorKind::joint:
    case SensorKind::torque: {
      const Index row =
          2 * static_cast<Index>(sensor.joint) + (sensor.kind == SensorKind::torque ? 1 : 0);
      seen.pose = Pose::translation(Vector3(watched.joints[row], 0, 0));
      add([&](const MatrixXd& d) {
        Columns motion = Columns::Zero(6, d.cols());
        motion.row(0) = d.row(6 * std::ssize(watch.frames) + row);
        return motion;
      });
      break;
    }
  }
  return seen;
}

}  // namespace kinetostat::calibration

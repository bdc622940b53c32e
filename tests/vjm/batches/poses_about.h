// Shipped robots, and poses spread about their home.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::vjm::samples {

inline Robot shipped(const std::string& name) {
  return read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/" + name);
}

/// Poses about the home of a robot, some far beyond what it reaches.
inline std::vector<spatial::Pose> poses_about(const Manipulator& manipulator, double spread,
                                              double turn, int count) {
  using spatial::Vector3;
  const spatial::Pose home = posture_from_joints(manipulator, {}).posture.platform;
  std::vector<spatial::Pose> poses;
  for (int i = 0; i < count; ++i) {
    const auto wave = [i](double k) { return std::sin(k * (i + 1)); };
    const double far = i % 11 == 10 ? 40 : 1;
    poses.emplace_back(
        spatial::exp_rotation(turn * Vector3(wave(1.3), wave(2.1), wave(0.7))) * home.rotation(),
        home.position() + far * spread * Vector3(wave(1.1), wave(1.9), wave(2.7)));
  }
  return poses;
}

}  // namespace kinetostat::vjm::samples

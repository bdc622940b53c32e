// What readers of the exported formats make of a robot, by formulas and parsers of their own.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Geometry>

namespace kinetostat::test {

/// That a joint moves with that of a body before, by so much for one of it; -1: with none.
struct ReadCoupling {
  int leader = -1;
  double factor = 1;
};

/// A body in a posture, in the world.
struct ReadBody {
  Eigen::Isometry3d frame;
  Eigen::Vector3d axis;  // of its joint
  bool turns = true;
  double stiffness = 0, rest = 0, damping = 0, mass = 0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  ReadCoupling coupling = {};
};

struct ReadTree {
  std::vector<ReadBody> bodies;
  Eigen::Isometry3d tool;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();

  /// Velocities of the joints by those of the joints that follow no other one.
  Eigen::MatrixXd couplings() const;
  /// Velocity of a point on body `b`, and its angular velocity, by the joints that follow none.
  Eigen::Matrix<double, 6, Eigen::Dynamic> jacobian(std::size_t b,
                                                    const Eigen::Vector3d& point) const;
  // Of the joints that follow none.
  Eigen::MatrixXd mass() const;
  Eigen::MatrixXd stiffness() const;
  Eigen::Matrix<double, 6, 6> compliance() const;  // of the tool
};

/// Of a body, before its joint has moved.
struct RawBody {
  Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();  // in the body before
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();           // in its own frame
  bool turns = true;
  double value = 0, stiffness = 0, rest = 0, damping = 0, mass = 0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  ReadCoupling coupling = {};
};

/// The tree with its joints at their values.
ReadTree assembled(const std::vector<RawBody>& bodies, const Eigen::Isometry3d& tool);

/// Joints stand at the keyframe.
ReadTree read_mjcf_text(const std::string& text);
/// Joints stand where their springs are relaxed: the formats have no posture.
ReadTree read_urdf_text(const std::string& text);
ReadTree read_sdf_text(const std::string& text);
/// Joints stand at their start values.
ReadTree read_modelica_text(const std::string& text);

/// The matrices of a script: "K = [", rows, "];".
Eigen::MatrixXd read_matrix(const std::string& script, const std::string& name);

}  // namespace kinetostat::test

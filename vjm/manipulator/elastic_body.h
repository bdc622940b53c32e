// Elastic bodies with any number of interfaces: frames, ternary links, elastic platforms.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "kinetostat/spatial/pose.h"

namespace kinetostat::vjm {

/// A body that yields between its interfaces, as its stiffness between them has it. Its axes are
/// fixed to one interface, the origin, and turn with the body of the manipulator that this is
/// fastened to. A chain of six coordinates d_k without springs of its own, the virtual joint Tx Ty
/// Tz Rx Ry Rz of JAMRIS09 eq. 1, leads from the origin to every other interface k. With d all of
/// them, R the rotation of the axes and x the place of the centre of mass, the energy is
///
///     U = 1/2 d'K d - m g'x,   m x = m (p + R c) + R G d,
///
/// p where the axes start, c the centre of mass in them: wrenches derive from one potential, rigid
/// motions deform nothing, and for two interfaces this is the spring of a link.
struct ElasticBody {
  struct Interface {
    std::string name;
    spatial::Vector3 point = spatial::Vector3::Zero();  // [m] in the axes of the body
    int body = 0;  // of the manipulator that it moves with, the base included
  };

  std::string name;
  std::vector<Interface> interfaces;  // the origin among them
  int origin = 0;                     // the body that the origin moves with
  spatial::Pose frame = {};           // axes of the elastic body in the frame of that
  std::vector<std::size_t> chains;    // of the manipulator, six coordinates each
  Eigen::MatrixXd stiffness;          // K, 6 chains square, positive definite [N, m, rad]
  /// Of all interfaces at their points, in the axes of the body, in their order: wrenches by
  /// accelerations [kg, m]. Empty: no mass.
  Eigen::MatrixXd inertia = {};

  double mass = 0;                                     // m [kg]
  spatial::Vector3 center = spatial::Vector3::Zero();  // c [m]
  Eigen::Matrix3Xd moment = {};                        // G [kg], [kg m]: 3 x 6 chains, by d

  bool has_weight(const spatial::Vector3& gravity) const;
};

/// Generalised forces -dU/dd on d and the wrench of the weight on the origin's body, about that
/// body's own reference point, base axes.
struct ElasticForces {
  Eigen::VectorXd on_deflections;
  spatial::Vector6 on_origin = spatial::Vector6::Zero();
  double energy = 0;  // 1/2 d'K d [J]
};

/// `origin`: the pose of the origin's body; `gravity` [m/s^2] in base axes.
ElasticForces elastic_forces(const ElasticBody& body, const spatial::Pose& origin,
                             const Eigen::VectorXd& deflections, const spatial::Vector3& gravity);

/// How they change: with d by -K, and the moment on the origin by T'; with a small turn of the
/// origin's body by T, and that moment by W.
struct ElasticTangent {
  Eigen::Matrix<double, Eigen::Dynamic, 3> by_turn;    // T
  spatial::Matrix3 moment = spatial::Matrix3::Zero();  // W
};

ElasticTangent elastic_tangent(const ElasticBody& body, const spatial::Pose& origin,
                               const Eigen::VectorXd& deflections, const spatial::Vector3& gravity);

/// Work of the weight from where the axes of the base are, with all d zero: m g'x [J].
double work_of_weight(const ElasticBody& body, const spatial::Pose& origin,
                      const Eigen::VectorXd& deflections, const spatial::Vector3& gravity);

}  // namespace kinetostat::vjm

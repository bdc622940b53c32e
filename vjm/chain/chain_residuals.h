// The balance of one chain at a state. Internal to this module.
#pragma once

#include <utility>
#include <vector>

#include "kinetostat/vjm/chain/chain_equations.h"

namespace kinetostat::vjm {

/// Wrenches [force; moment], base axes, at nodes of a chain.
using NodeWrenches = std::vector<std::pair<std::size_t, spatial::Vector6>>;
/// Generalised forces on coordinates of a chain [N m or N].
using CoordinateForces = std::vector<std::pair<Eigen::Index, double>>;

/// What is left of the balance of a chain (ChainEquations) at a state: the pose of the body that it
/// starts from, its coordinates x [m or rad] and the wrench [N; N m] at its end, base axes.
class ChainResiduals {
 public:
  ChainResiduals(const ChainEquations& equations, NodeWrenches node_loads,
                 const spatial::Pose& origin, const Eigen::VectorXd& x,
                 const spatial::Vector6& wrench, CoordinateForces joint_loads = {});
  /// The same under the same loads at nodes and in joints, elsewhere. Allocates nothing.
  void move_to(const spatial::Pose& origin, const Eigen::VectorXd& x,
               const spatial::Vector6& wrench);

  const ChainEquations& equations() const { return *equations_; }
  const spatial::Pose& origin() const { return origin_; }
  const Eigen::VectorXd& coordinates() const { return x_; }
  const Eigen::VectorXd& deflection() const { return deflection_; }  // x - rest
  const Eigen::VectorXd& travel() const { return travel_; }          // x - commands
  const ChainKinematics& kinematics() const { return kinematics_; }
  const spatial::Pose& end() const { return kinematics_.end; }
  /// The wrench at the end, then those at nodes.
  const std::vector<PointWrench>& loads() const { return loads_; }
  /// Coordinates that the tangent does not move: the redundant ones; none while nodes or joints are
  /// loaded, which may turn them.
  const std::vector<Eigen::Index>& held() const;

  /// Left side of the balance, scaled; equations().size() rows.
  const Eigen::VectorXd& unbalanced() const { return unbalanced_; }
  /// Wrench of the chain on the body it starts from, about that body's origin; unscaled.
  spatial::Vector6 wrench_on_origin() const;
  /// The value of a law on a coordinate here.
  CoordinateLaw::Value value_of(Eigen::Index coordinate, const CoordinateLaw& law) const;
  /// Adds the derivative of the generalised forces on all coordinates with respect to the logarithm
  /// of one spring's stiffness; gather_force() brings it to the balance. `of_drive`: without the
  /// laws that are beside the drive.
  void add_force_by_log_stiffness(const Spring& spring, bool of_drive,
                                  Eigen::VectorXd& force) const;
  /// Elastic energy of springs and laws [J].
  double energy() const;

 private:
  void gather_loads(const spatial::Vector6& wrench);
  void balance(const spatial::Vector6& wrench);

  const ChainEquations* equations_;
  NodeWrenches node_loads_;
  CoordinateForces joint_loads_;
  spatial::Pose origin_;
  Eigen::VectorXd x_, deflection_, travel_, force_, unbalanced_;
  ChainKinematics kinematics_;
  std::vector<PointWrench> loads_;
};

}  // namespace kinetostat::vjm

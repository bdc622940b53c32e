// The Newton matrix of the equations of equilibrium, factorised. Internal to this module.
#pragma once

#include <variant>

#include "kinetostat/vjm/statics/chainwise_factor.h"
#include "kinetostat/vjm/statics/serial_factor.h"

namespace kinetostat::vjm {

/// All unknowns at once: for chains with rigid directions and for elastic bodies too. Allocates and
/// uses scratch memory as ChainwiseFactor does.
class WholeFactor {
 public:
  WholeFactor(const EquilibriumResiduals& at, bool platform_held);
  /// The same at another state.
  void renew(const EquilibriumResiduals& at);
  const EquilibriumTangent& tangent() const { return tangent_; }

  /// False when the matrix is singular and cannot balance the right-hand side.
  bool solve(const SystemVector& right, SystemVector& solution) const;

  /// Displacement of the platform by a wrench on it, unscaled; not `consistent` when some motion is
  /// free. The platform must not be held.
  struct PlatformCompliance {
    spatial::Matrix6 matrix;
    bool consistent = true;
  };
  PlatformCompliance platform_compliance() const;
  /// As ChainwiseFactor::platform_stiffness(). No chain may have rigid directions.
  spatial::Matrix6 platform_stiffness() const;

 private:
  void factorise();

  EquilibriumTangent tangent_;
  bool held_;
  Eigen::MatrixXd matrix_;
  RobustFactor factor_;
  mutable Eigen::VectorXd right_, solution_;
};

/// One of the three, whichever costs least of those that do.
class NewtonMatrix {
 public:
  NewtonMatrix(const EquilibriumResiduals& at, bool platform_held);
  /// The same at another state.
  void renew(const EquilibriumResiduals& at);

  /// False when the matrix is singular and cannot balance the right-hand side.
  bool solve(const SystemVector& right, SystemVector& solution) const;
  /// The same in two parts: the motion of the bodies, then what it means for the chains of which
  /// that is asked.
  bool solve_bodies(const SystemVector& right, SystemVector& solution) const;
  bool complete(std::size_t chain, const SystemVector& right, SystemVector& solution) const;
  /// Before solve_bodies() of many right-hand sides that are not completed.
  void prepare_bodies() const;

  /// Vectors to solve with, kept between calls.
  struct Scratch {
    SystemVector right, solution;
  };
  Scratch& scratch() const { return scratch_; }

 private:
  mutable Scratch scratch_;
  std::variant<ChainwiseFactor, SerialFactor, WholeFactor> factor_;
};

}  // namespace kinetostat::vjm

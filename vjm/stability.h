// Is an equilibrium stable?
#pragma once

#include <Eigen/Core>

namespace kinetostat::vjm {

/// Signs of the second derivative of the energy on the motions that are allowed (MMT11 eq. 18-23).
struct Stability {
  int unstable = 0;  // directions in which the energy falls
  int neutral = 0;   // directions that cost nothing, such as a leg turning about its own axis
  /// Smallest eigenvalue that is not neutral, made dimensionless; it passes through zero at a
  /// critical point. Infinite when no motion is allowed.
  double margin = 0;

  bool stable() const { return unstable == 0; }
};

/// Counts the signs of the eigenvalues of a symmetric matrix that has been made dimensionless so
/// that the stiffest spring is 1; those below `tolerance` in magnitude are neutral.
Stability stability_of(const Eigen::MatrixXd& energy_hessian, double tolerance = 1e-13);

/// The worst of two, counts added.
Stability combined(const Stability& a, const Stability& b);

}  // namespace kinetostat::vjm

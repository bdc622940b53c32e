// Is an equilibrium stable?
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

namespace kinetostat::vjm {

/// Second derivative H of the energy in some coordinates, dimensionless, and an orthonormal basis B
/// of the motions that are allowed: dx = B y.
struct EnergyHessian {
  Eigen::MatrixXd hessian;  // n x n, symmetric
  Eigen::MatrixXd basis;    // n x m
  /// n, or none: loads that turn with a coordinate leave errors of v'Hv below (|v|'rounding)^2.
  Eigen::VectorXd rounding = {};

  /// B' H B, m x m.
  Eigen::MatrixXd reduced() const;
};

/// Eigenvalues of B' H B, ascending. Springs may differ by 20 orders of magnitude: each eigenvalue
/// is as exact as its own terms allow, not only to the rounding of the stiffest spring.
struct EnergySpectrum {
  Eigen::VectorXd values;
  /// Magnitude below which a value is rounding: 1e-10 of the terms |v|'|H||v| that add up to it,
  /// and what the loads leave.
  Eigen::VectorXd resolution;
  Eigen::MatrixXd motions;  // n x m, orthonormal

  bool is_neutral(Eigen::Index i) const { return std::abs(values[i]) <= resolution[i]; }
  int neutral() const;
  /// Indices, the smallest value against its resolution first.
  std::vector<Eigen::Index> by_size() const;
  /// Values but for the first `neutral` ones of by_size(), ascending.
  Eigen::VectorXd without_neutral(int neutral) const;
};

EnergySpectrum energy_spectrum(const EnergyHessian& energy);

/// Signs of the second derivative of the energy on the motions that are allowed (MMT11 eq. 18-23).
struct Stability {
  int unstable = 0;  // directions in which the energy falls
  int neutral = 0;   // directions that cost nothing, such as a leg turning about its own axis
  /// Smallest eigenvalue that is not neutral, made dimensionless; it passes through zero at a
  /// critical point. Infinite when no motion is allowed.
  double margin = 0;

  bool stable() const { return unstable == 0; }
};

Stability stability_of(const EnergySpectrum& spectrum);

/// The worst of two, counts added.
Stability combined(const Stability& a, const Stability& b);

}  // namespace kinetostat::vjm

// Frequencies of K y = omega^2 M y, both symmetric and none of them alone positive definite.
#pragma once

#include <Eigen/Cholesky>

#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::vjm {

/// Solved as (K + s M) y = (omega^2 + s) M y for a small s, with K + s M positive definite: what
/// has no mass (omega infinite) and what no spring holds (omega zero) are there, too. For every y
/// of it y' (K + s M) y = 1, y' M y = theta, and y' (K or M) z = 0 for two of them.
class MassSpectrum {
 public:
  /// K + s M is positive definite: what has neither mass nor stiffness is left out. M is not zero.
  MassSpectrum(const Eigen::MatrixXd& stiffness, const Eigen::MatrixXd& mass);

  Eigen::Index size() const { return eigen_.values.size(); }
  /// 1 / (omega^2 + s) [s^2], ascending; 0 where there is no mass.
  double theta(Eigen::Index i) const { return eigen_.values[i]; }
  bool has_mass(Eigen::Index i) const;
  double omega_squared(Eigen::Index i) const { return 1 / theta(i) - shift_; }  // has_mass(i)
  /// No spring resists it.
  bool is_free(Eigen::Index i) const { return has_mass(i) && omega_squared(i) < 10 * shift_; }
  /// y' K y, without what rounding leaves of a free motion.
  double stiffness(Eigen::Index i) const { return is_free(i) ? 0 : 1 - shift_ * theta(i); }
  Eigen::VectorXd vector(Eigen::Index i) const {
    return factor_.matrixU().solve(eigen_.vectors.col(i));
  }

 private:
  double shift_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
  spatial::SymmetricEigen eigen_;
};

}  // namespace kinetostat::vjm

// Direct solution of K u = f: Cholesky factors by CHOLMOD's supernodal method.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>

#include <Eigen/Core>

#include "kinetostat/fea/symmetric_matrix.h"

namespace kinetostat::fea {

/// The matrix is not positive definite: something can move without resistance.
class SingularStiffness : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct FactorisationStats {
  double entries = 0;  // of the factor
  double operations = 0;
  double reciprocal_condition = 0;  // estimate from the factor's diagonal
  double ordering_seconds = 0, factor_seconds = 0;
};

/// K = L L'. Keeps the factor; any number of right-hand sides can follow.
class Factorisation {
 public:
  /// Orders the blocks by nested dissection (METIS), the last `bodies` pairs of them last, because
  /// they are linked to a whole interface. Throws SingularStiffness, and std::bad_alloc when the
  /// factor does not fit in memory.
  Factorisation(const SymmetricMatrix& stiffness, const BlockPattern& pattern, int bodies);
  ~Factorisation();
  Factorisation(const Factorisation&) = delete;
  Factorisation& operator=(const Factorisation&) = delete;

  Eigen::MatrixXd solve(const Eigen::MatrixXd& right_hand_sides) const;
  const FactorisationStats& stats() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetostat::fea

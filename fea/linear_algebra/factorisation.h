// Direct solution of K u = f: Cholesky factors by CHOLMOD's supernodal method.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>

#include <Eigen/Core>

#include "kinetostat/fea/linear_algebra/block_matrix.h"
#include "kinetostat/fea/linear_algebra/multi_vector.h"

namespace kinetostat::fea {

/// The matrix is not positive definite: something can move without resistance.
class SingularStiffness : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct FactorisationStats {
  double entries = 0;  // of the factor
  double operations = 0;
  double bytes = 0;                 // of all that the factorisation holds while it works
  double factor_bytes = 0;          // of the factor, which stays
  double reciprocal_condition = 0;  // estimate from the factor's diagonal
  double ordering_seconds = 0, factor_seconds = 0;
};

/// K = L L'. Keeps the factor; any number of right-hand sides can follow.
class Factorisation {
 public:
  /// Orders the blocks by nested dissection (METIS), the last `bodies` pairs of them last, because
  /// they are linked to a whole interface, and predicts what stats() says of the factor. Throws
  /// std::bad_alloc.
  Factorisation(const BlockPattern& pattern, int bodies);
  /// The same and factorise().
  Factorisation(const BlockMatrix& stiffness, int bodies);
  ~Factorisation();
  Factorisation(const Factorisation&) = delete;
  Factorisation& operator=(const Factorisation&) = delete;

  /// Requires the pattern that was analysed. Throws SingularStiffness, and std::bad_alloc when the
  /// factor does not fit in memory.
  void factorise(const BlockMatrix& stiffness);
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right_hand_sides) const;
  /// For the first `columns` lanes; the others are zero.
  MultiVector solve(const MultiVector& right_hand_sides, int columns) const;
  const FactorisationStats& stats() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetostat::fea

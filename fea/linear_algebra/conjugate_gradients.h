// Preconditioned conjugate gradients for eight right-hand sides at once.
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "kinetostat/common/progress.h"
#include "kinetostat/fea/linear_algebra/multi_vector.h"

namespace kinetostat::fea {

/// z = M r with M symmetric and positive definite.
using Preconditioner = std::function<void(const MultiVector& r, MultiVector& z)>;

struct ConjugateGradientOptions {
  /// Stop when sqrt(r'Mr) has fallen by this factor: with a good preconditioner, the error beside
  /// the solution in the norm of the energy.
  double tolerance = 1e-9;
  int most_iterations = 100;
  /// Give up where more iterations than these would be left at the pace of the last ten.
  double most_left = std::numeric_limits<double>::infinity();
};

struct ConjugateGradientResult {
  MultiVector x;
  int iterations = 0;
  /// sqrt(r'Mr) at the end beside the start, the largest of all lanes.
  double residual = 0;
  bool converged = false;
  /// Coefficients of each iteration: the step along the direction, and how much of it the next one
  /// keeps.
  std::vector<Lanes> alpha = {}, beta = {};
};

/// Solves A x = b, starting at x = 0. `b` is used up and holds the residual afterwards. Each lane
/// has its own steps; one that has converged, or is zero, rests. Throws Cancelled.
ConjugateGradientResult conjugate_gradients(MultiVectorProduct& product, MultiVector& b,
                                            const Preconditioner& precondition,
                                            const ConjugateGradientOptions& options,
                                            common::Progress& progress);

/// The largest eigenvalue of M A as the iterations have seen it, from below (Lanczos): the largest
/// of all lanes.
double largest_ritz_value(const ConjugateGradientResult& result);

}  // namespace kinetostat::fea

// Preconditioner for a matrix that is too large to factorise: multigrid over levels of rigid
// aggregates, the last of which is factorised.
#pragma once

#include <memory>
#include <vector>

#include "kinetostat/fea/linear_algebra/aggregate_level.h"
#include "kinetostat/fea/linear_algebra/factorisation.h"
#include "kinetostat/fea/linear_algebra/v_cycle.h"

namespace kinetostat::fea {

class AggregationMultigrid {
 public:
  /// Adds levels below the matrix until the factors of the last take no more than `most_operations`
  /// or a level is hardly smaller than the one before. Throws std::bad_alloc, Cancelled.
  AggregationMultigrid(BlockMatrix matrix, RigidPoints points, double most_operations,
                       common::ThreadPool& pool, common::Progress& progress);

  /// The last level; may run beside other work. Throws SingularStiffness, std::bad_alloc.
  void factorise();

  /// x = S b with S a fixed symmetric positive definite matrix near A^-1, for the first `columns`
  /// lanes. Requires factorise().
  void solve(const MultiVector& b, int columns, MultiVector& x) { solve(0, columns, b, x); }

  /// Unknowns of the levels below the matrix, the factorised one last.
  std::vector<std::size_t> unknowns() const;
  /// Statistics of the last level.
  const FactorisationStats& stats() const { return factorisation_->stats(); }
  /// Memory beside that of stats() [bytes].
  double bytes_beside_factor() const;

 private:
  struct Level {
    Level(BlockMatrix from, const RigidPoints& points, common::ThreadPool& pool,
          common::Progress& progress);
    std::size_t bytes() const;

    BlockMatrix matrix;
    MultiVectorProduct product;
    VCycle cycle;
    AggregateLevel below;
    MultiVector load, motion;  // of the level below
    MultiVector residual, step, work;
  };

  void solve(std::size_t level, int columns, const MultiVector& b, MultiVector& x);
  void cycle(std::size_t level, int columns, const MultiVector& r, MultiVector& z);

  std::vector<std::unique_ptr<Level>> levels_;
  BlockMatrix last_;
  std::unique_ptr<Factorisation> factorisation_;
};

}  // namespace kinetostat::fea

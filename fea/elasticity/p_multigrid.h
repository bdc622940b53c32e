// The preconditioner of the iterative solver: a smoother on the quadratic elements, and the linear
// ones solved exactly or nearly so.
#pragma once

#include <future>
#include <memory>

#include "kinetostat/fea/elasticity/p1_coarse_space.h"
#include "kinetostat/fea/linear_algebra/aggregation_multigrid.h"
#include "kinetostat/fea/linear_algebra/factorisation.h"
#include "kinetostat/fea/linear_algebra/v_cycle.h"

namespace kinetostat::fea {

/// The linear elements on the corners, solved for by their factors or, when those would take too
/// long, by multigrid over aggregates. Analysis and factorisation, which one thread does, go on in
/// the background, so that the others have work meanwhile.
class CoarseLevel {
 public:
  /// Assembles, and starts to analyse.
  CoarseLevel(const TetMesh& mesh, const std::vector<Material>& materials, const DofMap& unknowns,
              common::ThreadPool& pool, common::Progress& progress);
  CoarseLevel(const CoarseLevel&) = delete;
  CoarseLevel& operator=(const CoarseLevel&) = delete;

  /// Waits for the analysis of the corners' factors, which says what they will need. Throws
  /// std::bad_alloc.
  FactorisationStats analyse();
  /// Takes aggregates instead of the factors. Requires analyse(). Throws std::bad_alloc, Cancelled.
  void aggregate(double most_operations, common::Progress& progress);
  /// Starts, after analyse().
  void begin_factorisation();
  /// Waits for its end. Throws SingularStiffness and std::bad_alloc.
  void finish_factorisation();
  /// correction = P S P' residual, for the first `columns` lanes; S is (P'AP)^-1, or near it.
  void correct(const MultiVector& residual, int columns, MultiVector& correction);

  /// Memory while it is factorised, and afterwards [bytes]. Require analyse().
  double working_bytes() const { return own_bytes() + stats().bytes; }
  double bytes() const { return own_bytes() + stats().factor_bytes; }
  /// Unknowns of each level, the corners first.
  std::vector<std::size_t> unknowns() const;
  /// Statistics of the factorised level.
  const FactorisationStats& stats() const;

 private:
  CoarseLevel(const TetMesh& mesh, const std::vector<Material>& materials, const DofMap& unknowns,
              const P1CoarseSpace& corners, common::ThreadPool& pool, common::Progress& progress);
  double own_bytes() const;

  common::ThreadPool& pool_;
  Prolongation prolongation_;
  RigidPoints points_;
  BlockMatrix matrix_;
  MultiVector lanes_, solution_;
  std::unique_ptr<Factorisation> factorisation_;  // this, or what follows
  std::unique_ptr<AggregationMultigrid> multigrid_;
  std::future<std::unique_ptr<Factorisation>> analysis_;
  std::future<void> factorising_;  // the last member: its end is waited for before the others go
};

/// One V-cycle: smooth, correct by the corners' solution, smooth.
class PMultigrid {
 public:
  /// `columns` of the lanes are in use. Keeps references; the coarse level is factorised.
  PMultigrid(MultiVectorProduct& product, CoarseLevel& coarse, int columns,
             common::Progress& progress)
      : coarse_(coarse), cycle_(product, progress), columns_(columns) {}

  /// z = M r.
  void operator()(const MultiVector& r, MultiVector& z) {
    cycle_(r, z, [this](const MultiVector& residual, MultiVector& correction) {
      coarse_.correct(residual, columns_, correction);
    });
  }

 private:
  CoarseLevel& coarse_;
  VCycle cycle_;
  int columns_;
};

}  // namespace kinetostat::fea

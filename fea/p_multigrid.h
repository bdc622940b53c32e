// The preconditioner of the iterative solver: a smoother on the quadratic elements, and the linear
// ones solved exactly or nearly so.
#pragma once

#include <future>
#include <memory>

#include "kinetostat/fea/aggregation_multigrid.h"
#include "kinetostat/fea/corner_model.h"
#include "kinetostat/fea/factorisation.h"
#include "kinetostat/fea/v_cycle.h"

namespace kinetostat::fea {

/// The linear elements on the corners, solved for by their factors or, when those would take too
/// long, by multigrid over aggregates. Analysis and factorisation, which one thread does, go on in
/// the background, so that the others have work meanwhile.
class CoarseLevel {
 public:
  /// Assembles, and starts to analyse.
  CoarseLevel(const TetMesh& mesh, const std::vector<Material>& materials, const Unknowns& unknowns,
              Team& team, files::Progress& progress);
  CoarseLevel(const CoarseLevel&) = delete;
  CoarseLevel& operator=(const CoarseLevel&) = delete;

  /// Waits for the analysis of the corners' factors, which says what they will need. Throws
  /// std::bad_alloc.
  FactorisationStats analyse();
  /// Takes aggregates instead of the factors. Requires analyse(). Throws std::bad_alloc, Cancelled.
  void aggregate(double most_operations, files::Progress& progress);
  /// Starts, after analyse().
  void begin_factorisation();
  /// Waits for its end. Throws SingularStiffness and std::bad_alloc.
  void finish_factorisation();
  /// correction = P S P' residual, for the first `columns` lanes; S is (P'AP)^-1, or near it.
  void correct(const LaneVector& residual, int columns, LaneVector& correction);

  /// Memory while it is factorised, and afterwards [bytes]. Require analyse().
  double working_bytes() const { return own_bytes() + stats().bytes; }
  double bytes() const { return own_bytes() + stats().factor_bytes; }
  /// Unknowns of each level, the corners first.
  std::vector<std::size_t> unknowns() const;
  /// Statistics of the factorised level.
  const FactorisationStats& stats() const;

 private:
  CoarseLevel(const TetMesh& mesh, const std::vector<Material>& materials, const Unknowns& unknowns,
              const CornerModel& corners, Team& team, files::Progress& progress);
  double own_bytes() const;

  Team& team_;
  Prolongation prolongation_;
  RigidPoints points_;
  BlockMatrix matrix_;
  LaneVector lanes_, solution_;
  std::unique_ptr<Factorisation> factorisation_;  // this, or what follows
  std::unique_ptr<AggregationMultigrid> multigrid_;
  std::future<std::unique_ptr<Factorisation>> analysis_;
  std::future<void> factorising_;  // the last member: its end is waited for before the others go
};

/// One V-cycle: smooth, correct by the corners' solution, smooth.
class PMultigrid {
 public:
  /// `columns` of the lanes are in use. Keeps references; the coarse level is factorised.
  PMultigrid(LaneProduct& product, CoarseLevel& coarse, int columns, files::Progress& progress)
      : coarse_(coarse), cycle_(product, progress), columns_(columns) {}

  /// z = M r.
  void operator()(const LaneVector& r, LaneVector& z) {
    cycle_(r, z, [this](const LaneVector& residual, LaneVector& correction) {
      coarse_.correct(residual, columns_, correction);
    });
  }

 private:
  CoarseLevel& coarse_;
  VCycle cycle_;
  int columns_;
};

}  // namespace kinetostat::fea

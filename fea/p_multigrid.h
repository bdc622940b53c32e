// The preconditioner of the iterative solver: a smoother on the quadratic elements, and the linear
// ones solved exactly.
#pragma once

#include <future>
#include <memory>

#include "kinetostat/fea/conjugate_gradients.h"
#include "kinetostat/fea/corner_model.h"
#include "kinetostat/fea/factorisation.h"

namespace kinetostat::fea {

/// Chebyshev polynomial of the fourth kind in D^-1 A with D the diagonal blocks, weighted to be the
/// best for a V-cycle (Lottes, Optimal polynomial smoothers for multigrid V-cycles, 2022; Phillips
/// and Fischer, the same year, table of beta).
class ChebyshevSmoother {
 public:
  static constexpr int degree = 3;

  /// Finds the largest eigenvalue of D^-1 A by a few iterations. Keeps a reference to the product.
  ChebyshevSmoother(LaneProduct& product, files::Progress& progress);

  /// One pass: x += p(D^-1 A) D^-1 r, and r becomes the residual of the new x unless it is the
  /// last use of r. `d` and `w` are workspace.
  void smooth(LaneVector& x, LaneVector& r, LaneVector& d, LaneVector& w,
              bool needs_residual) const;

  double largest_eigenvalue() const { return largest_eigenvalue_; }

 private:
  // d = scale * D^-1 r on some blocks.
  void begin(int first, int blocks, double scale, const LaneVector& r, LaneVector& d) const;

  LaneProduct& product_;
  std::vector<double> inverse_;  // of the diagonal blocks, nine each
  double largest_eigenvalue_ = 0;
};

/// The linear elements on the corners, factorised. Analysis and factorisation, which one thread
/// does, go on in the background, so that the others have work meanwhile.
class CoarseLevel {
 public:
  /// Assembles, and begins to analyse.
  CoarseLevel(const TetMesh& mesh, const std::vector<Material>& materials, const Unknowns& unknowns,
              Team& team, files::Progress& progress);
  CoarseLevel(const CoarseLevel&) = delete;
  CoarseLevel& operator=(const CoarseLevel&) = delete;

  /// Waits for the analysis: stats() of the factorisation predict what it needs. Throws
  /// std::bad_alloc.
  void analyse();
  /// Begins, after analyse().
  void begin_factorisation();
  /// Waits for its end. Throws SingularStiffness and std::bad_alloc.
  void finish_factorisation();
  /// correction = P (P'AP)^-1 P' residual, for the first `columns` lanes.
  void correct(const LaneVector& residual, int columns, LaneVector& correction);

  /// What it takes in memory when it is factorised. Requires analyse().
  double bytes() const;
  std::size_t unknowns() const { return lanes_.size(); }
  const FactorisationStats& stats() const { return factorisation_->stats(); }

 private:
  CoarseLevel(const TetMesh& mesh, const std::vector<Material>& materials, const Unknowns& unknowns,
              const CornerModel& corners, Team& team, files::Progress& progress);

  Team& team_;
  Prolongation prolongation_;
  BlockMatrix matrix_;
  std::unique_ptr<Factorisation> factorisation_;
  LaneVector lanes_;
  std::future<std::unique_ptr<Factorisation>> analysis_;
  std::future<void> factorising_;  // the last member: its end is waited for before the others go
};

/// One V-cycle of two levels: smooth, correct by the corners' solution, smooth.
class PMultigrid {
 public:
  /// `columns` of the lanes are in use. Keeps references; the coarse level is factorised.
  PMultigrid(LaneProduct& product, CoarseLevel& coarse, int columns, files::Progress& progress);

  /// z = M r.
  void operator()(const LaneVector& r, LaneVector& z);

 private:
  LaneProduct& product_;
  CoarseLevel& coarse_;
  ChebyshevSmoother smoother_;
  int columns_;
  LaneVector residual_, direction_, work_;
};

}  // namespace kinetostat::fea

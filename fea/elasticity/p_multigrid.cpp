#include "kinetostat/fea/elasticity/p_multigrid.h"

#include "kinetostat/common/index.h"

namespace kinetostat::fea {

using common::at;

CoarseLevel::CoarseLevel(const TetMesh& mesh, const std::vector<Material>& materials,
                         const DofMap& unknowns, common::ThreadPool& pool,
                         common::Progress& progress)
    : CoarseLevel(mesh, materials, unknowns, p1_coarse_space(mesh, unknowns), pool, progress) {}

CoarseLevel::CoarseLevel(const TetMesh& mesh, const std::vector<Material>& materials,
                         const DofMap& unknowns, const P1CoarseSpace& corners,
                         common::ThreadPool& pool, common::Progress& progress)
    : pool_(pool),
      prolongation_(mesh, unknowns, corners.unknowns),
      points_(rigid_points(corners.mesh, corners.unknowns)),
      matrix_(assemble(corners.mesh, materials, corners.unknowns, pool, progress)),
      lanes_(at(matrix_.size())),
      solution_(lanes_.size()),
      analysis_(std::async(std::launch::async, [this] {
        return std::make_unique<Factorisation>(matrix_.pattern, points_.bodies);
      })) {}

FactorisationStats CoarseLevel::analyse() {
  factorisation_ = analysis_.get();
  return factorisation_->stats();
}

void CoarseLevel::aggregate(double most_operations, common::Progress& progress) {
  factorisation_.reset();
  multigrid_ = std::make_unique<AggregationMultigrid>(std::move(matrix_), std::move(points_),
                                                      most_operations, pool_, progress);
}

void CoarseLevel::begin_factorisation() {
  factorising_ = std::async(std::launch::async, [this] {
    if (multigrid_)
      multigrid_->factorise();
    else
      factorisation_->factorise(matrix_);
  });
}

void CoarseLevel::finish_factorisation() {
  factorising_.get();
  matrix_ = {};
}

const FactorisationStats& CoarseLevel::stats() const {
  return multigrid_ ? multigrid_->stats() : factorisation_->stats();
}

std::vector<std::size_t> CoarseLevel::unknowns() const {
  std::vector<std::size_t> unknowns{lanes_.size()};
  if (multigrid_)
    for (const std::size_t below : multigrid_->unknowns()) unknowns.push_back(below);
  return unknowns;
}

double CoarseLevel::own_bytes() const {
  return static_cast<double>(prolongation_.bytes() + matrix_.bytes() +
                             sizeof(Lanes) * (lanes_.size() + solution_.size())) +
         (multigrid_ ? multigrid_->bytes_beside_factor() : 0);
}

void CoarseLevel::correct(const MultiVector& residual, int columns, MultiVector& correction) {
  prolongation_.restrict(residual, lanes_, pool_);
  if (multigrid_)
    multigrid_->solve(lanes_, columns, solution_);
  else
    solution_ = factorisation_->solve(lanes_, columns);
  prolongation_.prolong(solution_, correction, pool_);
}

}  // namespace kinetostat::fea

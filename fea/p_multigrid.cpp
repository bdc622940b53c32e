#include "kinetostat/fea/p_multigrid.h"

namespace kinetostat::fea {

CoarseLevel::CoarseLevel(const TetMesh& mesh, const std::vector<Material>& materials,
                         const Unknowns& unknowns, Team& team, files::Progress& progress)
    : CoarseLevel(mesh, materials, unknowns, corner_model(mesh, unknowns), team, progress) {}

CoarseLevel::CoarseLevel(const TetMesh& mesh, const std::vector<Material>& materials,
                         const Unknowns& unknowns, const CornerModel& corners, Team& team,
                         files::Progress& progress)
    : team_(team),
      prolongation_(mesh, unknowns, corners.unknowns),
      points_(rigid_points(corners.mesh, corners.unknowns)),
      matrix_(assemble(corners.mesh, materials, corners.unknowns, team, progress)),
      lanes_(static_cast<std::size_t>(matrix_.size())),
      solution_(lanes_.size()),
      analysis_(std::async(std::launch::async, [this] {
        return std::make_unique<Factorisation>(matrix_.pattern, points_.bodies);
      })) {}

FactorisationStats CoarseLevel::analyse() {
  factorisation_ = analysis_.get();
  return factorisation_->stats();
}

void CoarseLevel::aggregate(double most_operations, files::Progress& progress) {
  factorisation_.reset();
  multigrid_ = std::make_unique<AggregationMultigrid>(std::move(matrix_), std::move(points_),
                                                      most_operations, team_, progress);
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

void CoarseLevel::correct(const LaneVector& residual, int columns, LaneVector& correction) {
  prolongation_.restrict(residual, lanes_, team_);
  if (multigrid_)
    multigrid_->solve(lanes_, columns, solution_);
  else
    solution_ = factorisation_->solve(lanes_, columns);
  prolongation_.prolong(solution_, correction, team_);
}

}  // namespace kinetostat::fea

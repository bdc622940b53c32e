#include "kinetostat/fea/p_multigrid.h"

#include <cstdint>

#include <Eigen/LU>

namespace kinetostat::fea {
namespace {

// Row k - 1: the weights of a polynomial of degree k.
constexpr double best_weights[4][4] = {
    {1.12500000000000, 0, 0, 0},
    {1.02387287570313, 1.26408905371085, 0, 0},
    {1.00842544782028, 1.08867839208730, 1.33753125909618, 0},
    {1.00391310427285, 1.04035811188593, 1.14863498546254, 1.38268869241000}};

// out = factor * out + scale * D^-1 r on one block.
void add_scaled(const double* inverse, const Lanes* r, double scale, double factor, Lanes* out) {
  for (int i = 0; i < 3; ++i)
    for (int lane = 0; lane < lane_count; ++lane)
      out[i].v[lane] = factor * out[i].v[lane] +
                       scale * (inverse[3 * i] * r[0].v[lane] + inverse[3 * i + 1] * r[1].v[lane] +
                                inverse[3 * i + 2] * r[2].v[lane]);
}

std::vector<double> inverse_diagonal(const BlockMatrix& matrix) {
  std::vector<double> inverse(9 * static_cast<std::size_t>(matrix.pattern.blocks()));
  for (int b = 0; b < matrix.pattern.blocks(); ++b)
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(inverse.data() + 9 * b) =
        matrix.block(matrix.pattern.begin(b)).inverse();
  return inverse;
}

// The same numbers in every run, between -1 and 1, without pattern (splitmix64).
LaneVector noise(std::size_t size) {
  LaneVector noise(size);
  std::uint64_t state = 0;
  for (Lanes& lanes : noise)
    for (double& value : lanes.v) {
      std::uint64_t x = state += 0x9e3779b97f4a7c15u;
      x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
      x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
      value = static_cast<double>((x ^ (x >> 31)) >> 11) * 0x1p-52 - 1;
    }
  return noise;
}

}  // namespace

ChebyshevSmoother::ChebyshevSmoother(LaneProduct& product, files::Progress& progress)
    : product_(product), inverse_(inverse_diagonal(product.matrix())) {
  constexpr int iterations = 10;
  constexpr double margin = 1.05;  // the iterations see the eigenvalue from below
  LaneVector b = noise(static_cast<std::size_t>(product.matrix().size()));
  const auto jacobi = [this](const LaneVector& r, LaneVector& z) {
    product_.for_each_row([&](int row) {
      add_scaled(inverse_.data() + 9 * row, r.data() + 3 * row, 1, 0, z.data() + 3 * row);
    });
  };
  largest_eigenvalue_ =
      margin * largest_ritz_value(conjugate_gradients(
                   product, b, jacobi, {.tolerance = 0, .most_iterations = iterations}, progress));
}

void ChebyshevSmoother::smooth(LaneVector& x, LaneVector& r, LaneVector& d, LaneVector& w,
                               bool needs_residual) const {
  product_.for_each_row([&](int row) {
    add_scaled(inverse_.data() + 9 * row, r.data() + 3 * row, 4 / (3 * largest_eigenvalue_), 0,
               d.data() + 3 * row);
  });
  for (int k = 1; k <= degree; ++k) {
    const double weight = best_weights[degree - 1][k - 1];
    const bool last = k == degree;
    if (last && !needs_residual) {
      product_.for_each_row([&](int row) {
        for (auto i = static_cast<std::size_t>(3 * row); i < static_cast<std::size_t>(3 * row + 3);
             ++i)
          for (int lane = 0; lane < lane_count; ++lane) x[i].v[lane] += weight * d[i].v[lane];
      });
      return;
    }
    product_(d, w, [&](int piece) {
      for (int row = product_.first(piece); row < product_.end(piece); ++row) {
        for (auto i = static_cast<std::size_t>(3 * row); i < static_cast<std::size_t>(3 * row + 3);
             ++i)
          for (int lane = 0; lane < lane_count; ++lane) {
            x[i].v[lane] += weight * d[i].v[lane];
            r[i].v[lane] -= weight * w[i].v[lane];
          }
        if (!last)
          add_scaled(inverse_.data() + 9 * row, r.data() + 3 * row,
                     (8.0 * k + 4) / ((2 * k + 3) * largest_eigenvalue_),
                     (2.0 * k - 1) / (2 * k + 3), d.data() + 3 * row);
      }
    });
  }
}

CoarseLevel::CoarseLevel(const TetMesh& mesh, const std::vector<Material>& materials,
                         const Unknowns& unknowns, Team& team, files::Progress& progress)
    : CoarseLevel(mesh, materials, unknowns, corner_model(mesh, unknowns), team, progress) {}

CoarseLevel::CoarseLevel(const TetMesh& mesh, const std::vector<Material>& materials,
                         const Unknowns& unknowns, const CornerModel& corners, Team& team,
                         files::Progress& progress)
    : team_(team),
      prolongation_(mesh, unknowns, corners.unknowns),
      matrix_(assemble(corners.mesh, materials, corners.unknowns, team, progress)),
      factorisation_(std::make_unique<Factorisation>(matrix_.pattern,
                                                     static_cast<int>(unknowns.bodies().size()))),
      lanes_(static_cast<std::size_t>(matrix_.size())),
      bytes_(static_cast<double>(prolongation_.bytes() + matrix_.bytes() +
                                 sizeof(Lanes) * lanes_.size()) +
             factorisation_->stats().bytes) {}

void CoarseLevel::factorise() {
  factorisation_->factorise(matrix_);
  matrix_ = {};
}

void CoarseLevel::correct(const LaneVector& residual, int columns, LaneVector& correction) {
  prolongation_.restrict(residual, lanes_, team_);
  Eigen::MatrixXd values(static_cast<Eigen::Index>(lanes_.size()), columns);
  from_lanes(lanes_, values);
  lanes_ = to_lanes(factorisation_->solve(values));
  prolongation_.prolong(lanes_, correction, team_);
}

PMultigrid::PMultigrid(LaneProduct& product, CoarseLevel& coarse, int columns,
                       files::Progress& progress)
    : product_(product), coarse_(coarse), smoother_(product, progress), columns_(columns) {
  const auto size = static_cast<std::size_t>(product.matrix().size());
  residual_.resize(size);
  direction_.resize(size);
  work_.resize(size);
}

void PMultigrid::operator()(const LaneVector& r, LaneVector& z) {
  residual_ = r;
  std::fill(z.begin(), z.end(), Lanes{});
  smoother_.smooth(z, residual_, direction_, work_, true);
  coarse_.correct(residual_, columns_, direction_);
  product_(direction_, work_, [&](int piece) {
    for (auto i = static_cast<std::size_t>(3 * product_.first(piece));
         i < static_cast<std::size_t>(3 * product_.end(piece)); ++i)
      for (int lane = 0; lane < lane_count; ++lane) {
        z[i].v[lane] += direction_[i].v[lane];
        residual_[i].v[lane] -= work_[i].v[lane];
      }
  });
  smoother_.smooth(z, residual_, direction_, work_, false);
}

}  // namespace kinetostat::fea

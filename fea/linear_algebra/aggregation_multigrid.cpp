#include "kinetostat/fea/linear_algebra/aggregation_multigrid.h"

#include <algorithm>
#include <utility>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {
namespace {

using common::at;

// With two cycles, conjugate gradients need about as many iterations as with the factors (L-shaped
// foot of 3 million unknowns: 11; with one cycle 12). The eigenvalues of one cycle times A are
// taken to lie between `least` and 1; what belongs to smaller ones is left to conjugate gradients.
constexpr int cycles = 2;
constexpr double least = 0.5;

// a = keep * a + weight * b.
void combine(double keep, double weight, const Lanes* b, int count, Lanes* a) {
  for (int i = 0; i < count; ++i)
    for (int lane = 0; lane < lane_count; ++lane)
      a[i].v[lane] = keep * a[i].v[lane] + weight * b[i].v[lane];
}

}  // namespace

AggregationMultigrid::Level::Level(BlockMatrix from, const RigidPoints& points,
                                   common::ThreadPool& pool, common::Progress& progress)
    : matrix(std::move(from)),
      product(matrix, pool),
      cycle(product, progress),
      below(matrix, points, cycle.smoother().largest_eigenvalue(), pool),
      load(at(below.matrix().size())),
      motion(load.size()),
      residual(at(matrix.size())),
      step(residual.size()),
      work(residual.size()) {}

std::size_t AggregationMultigrid::Level::bytes() const {
  return matrix.bytes() + product.bytes() + cycle.bytes() + below.bytes() +
         sizeof(Lanes) * (2 * load.size() + 3 * residual.size());
}

AggregationMultigrid::AggregationMultigrid(BlockMatrix matrix, RigidPoints points,
                                           double most_operations, common::ThreadPool& pool,
                                           common::Progress& progress)
    : last_(std::move(matrix)) {
  Eigen::Index before = 0;
  do {
    before = last_.size();
    levels_.push_back(std::make_unique<Level>(std::move(last_), points, pool, progress));
    points = levels_.back()->below.points();
    last_ = levels_.back()->below.take_matrix();
    factorisation_ = std::make_unique<Factorisation>(last_.pattern, points.bodies);
  } while (stats().operations > most_operations && 2 * last_.size() < before);
}

void AggregationMultigrid::factorise() {
  factorisation_->factorise(last_);
  last_ = {};
}

void AggregationMultigrid::cycle(std::size_t level, int columns, const MultiVector& r,
                                 MultiVector& z) {
  Level& here = *levels_[level];
  here.cycle(r, z, [&](const MultiVector& residual, MultiVector& correction) {
    here.below.restrict(residual, here.load);
    if (level + 1 < levels_.size())
      solve(level + 1, columns, here.load, here.motion);
    else
      here.motion = factorisation_->solve(here.load, columns);
    here.below.prolong(here.motion, correction);
  });
}

// Chebyshev's iteration (Saad, Iterative methods for sparse linear systems, 2003, algorithm 12.1)
// with a cycle as the preconditioner.
void AggregationMultigrid::solve(std::size_t level, int columns, const MultiVector& b,
                                 MultiVector& x) {
  constexpr double middle = (1 + least) / 2, half = (1 - least) / 2;
  Level& here = *levels_[level];
  MultiVectorProduct& product = here.product;
  const auto for_rows = [&product](const auto& work) {
    product.for_each_piece([&](int first, int blocks) { work(3 * first, 3 * blocks); });
  };
  cycle(level, columns, b, here.step);
  for_rows([&](int first, int count) {
    std::copy_n(b.data() + first, count, here.residual.data() + first);
    combine(0, 1 / middle, here.step.data() + first, count, here.step.data() + first);
    std::copy_n(here.step.data() + first, count, x.data() + first);
  });
  double rho = half / middle;
  for (int c = 1; c < cycles; ++c) {
    product(here.step, here.work, [&](int piece) {
      const int first = 3 * product.first(piece), count = 3 * product.end(piece) - first;
      add(-1, here.work.data() + first, count, here.residual.data() + first);
    });
    cycle(level, columns, here.residual, here.work);
    const double before = std::exchange(rho, 1 / (2 * middle / half - rho));
    for_rows([&](int first, int count) {
      combine(rho * before, 2 * rho / half, here.work.data() + first, count,
              here.step.data() + first);
      add(1, here.step.data() + first, count, x.data() + first);
    });
  }
}

std::vector<std::size_t> AggregationMultigrid::unknowns() const {
  std::vector<std::size_t> unknowns;
  for (const auto& level : levels_) unknowns.push_back(level->load.size());
  return unknowns;
}

double AggregationMultigrid::bytes_beside_factor() const {
  std::size_t bytes = last_.bytes();
  for (const auto& level : levels_) bytes += level->bytes();
  return static_cast<double>(bytes);
}

}  // namespace kinetostat::fea

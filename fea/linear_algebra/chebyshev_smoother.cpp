#include "kinetostat/fea/linear_algebra/chebyshev_smoother.h"

#include <cstddef>
#include <cstdint>

#include <Eigen/LU>

#include "kinetostat/common/index.h"
#include "kinetostat/common/several_processors.h"
#include "kinetostat/fea/linear_algebra/conjugate_gradients.h"

namespace kinetostat::fea {
namespace {

using common::at;

// Row k - 1: the weights of a polynomial of degree k.
constexpr double best_weights[4][4] = {
    {1.12500000000000, 0, 0, 0},
    {1.02387287570313, 1.26408905371085, 0, 0},
    {1.00842544782028, 1.08867839208730, 1.33753125909618, 0},
    {1.00391310427285, 1.04035811188593, 1.14863498546254, 1.38268869241000}};

using Register = double __attribute__((vector_size(sizeof(Lanes)), may_alias));

// d = keep * d + scale * D^-1 r on some blocks.
KINETOSTAT_FOR_SEVERAL_PROCESSORS
void add_scaled(const double* inverse, const Lanes* r_lanes, double scale, double keep,
                std::ptrdiff_t blocks, Lanes* d_lanes) {
  const auto* r = reinterpret_cast<const Register*>(r_lanes);
  auto* d = reinterpret_cast<Register*>(d_lanes);
  for (std::ptrdiff_t b = 0; b < blocks; ++b, inverse += 9, r += 3, d += 3)
    for (std::ptrdiff_t i = 0; i < 3; ++i) {
      const Register z =
          inverse[3 * i] * r[0] + inverse[3 * i + 1] * r[1] + inverse[3 * i + 2] * r[2];
      d[i] = keep == 0 ? scale * z : keep * d[i] + scale * z;
    }
}

std::vector<double> inverse_diagonal(const BlockMatrix& matrix) {
  std::vector<double> inverse(9 * at(matrix.pattern.blocks()));
  for (int b = 0; b < matrix.pattern.blocks(); ++b)
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(inverse.data() + 9 * at(b)) =
        matrix.block(matrix.pattern.begin(b)).inverse();
  return inverse;
}

// The same numbers in every run, between -1 and 1, without pattern (splitmix64).
MultiVector noise(std::size_t size) {
  MultiVector noise(size);
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

ChebyshevSmoother::ChebyshevSmoother(MultiVectorProduct& product, common::Progress& progress)
    : product_(product), inverse_(inverse_diagonal(product.matrix())) {
  constexpr int iterations = 10;
  constexpr double margin = 1.05;  // the iterations see the eigenvalue from below
  MultiVector b = noise(at(product.matrix().size()));
  const auto jacobi = [this](const MultiVector& r, MultiVector& z) {
    product_.for_each_piece(
        [&](std::ptrdiff_t first, std::ptrdiff_t blocks) { begin(first, blocks, 1, r, z); });
  };
  largest_eigenvalue_ =
      margin * largest_ritz_value(conjugate_gradients(
                   product, b, jacobi, {.tolerance = 0, .most_iterations = iterations}, progress));
}

void ChebyshevSmoother::begin(std::ptrdiff_t first, std::ptrdiff_t blocks, double scale,
                              const MultiVector& r, MultiVector& d) const {
  add_scaled(inverse_.data() + 9 * first, r.data() + 3 * first, scale, 0, blocks,
             d.data() + 3 * first);
}

void ChebyshevSmoother::smooth(MultiVector& x, MultiVector& r, MultiVector& d, MultiVector& w,
                               bool needs_residual) const {
  product_.for_each_piece([&](std::ptrdiff_t first, std::ptrdiff_t blocks) {
    begin(first, blocks, 4 / (3 * largest_eigenvalue_), r, d);
  });
  for (int k = 1; k <= degree; ++k) {
    const double weight = best_weights[degree - 1][k - 1];
    const bool last = k == degree;
    if (last && !needs_residual) {
      product_.for_each_piece([&](std::ptrdiff_t first, std::ptrdiff_t blocks) {
        add(weight, d.data() + 3 * first, 3 * blocks, x.data() + 3 * first);
      });
      return;
    }
    product_(d, w, [&](int piece) {
      const std::ptrdiff_t first = product_.first(piece), blocks = product_.end(piece) - first;
      add(weight, d.data() + 3 * first, 3 * blocks, x.data() + 3 * first);
      add(-weight, w.data() + 3 * first, 3 * blocks, r.data() + 3 * first);
      if (!last)
        add_scaled(inverse_.data() + 9 * first, r.data() + 3 * first,
                   (8.0 * k + 4) / ((2 * k + 3) * largest_eigenvalue_), (2.0 * k - 1) / (2 * k + 3),
                   blocks, d.data() + 3 * first);
    });
  }
}

}  // namespace kinetostat::fea

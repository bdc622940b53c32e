#include "kinetostat/fea/linear_algebra/conjugate_gradients.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kinetostat/common/index.h"
#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::fea {
namespace {

using common::at;

// Inner products, lane by lane: one partial sum for each piece of the rows, added in their order.
class InnerProduct {
 public:
  explicit InnerProduct(const MultiVectorProduct& product)
      : product_(product), partial_(at(product.pieces())) {}

  void add_piece(int piece, const MultiVector& a, const MultiVector& b) {
    Lanes sum{};
    for (int i = 3 * product_.first(piece); i < 3 * product_.end(piece); ++i)
      for (int lane = 0; lane < lane_count; ++lane)
        sum.v[lane] += a[at(i)].v[lane] * b[at(i)].v[lane];
    partial_[at(piece)] = sum;
  }
  Lanes total() const {
    Lanes sum{};
    for (const Lanes& partial : partial_)
      for (int lane = 0; lane < lane_count; ++lane) sum.v[lane] += partial.v[lane];
    return sum;
  }

 private:
  const MultiVectorProduct& product_;
  std::vector<Lanes> partial_;
};

// a / b where b is above zero, 0 in lanes that rest.
Lanes ratio(const Lanes& a, const Lanes& b) {
  Lanes result{};
  for (int lane = 0; lane < lane_count; ++lane)
    if (b.v[lane] > 0) result.v[lane] = a.v[lane] / b.v[lane];
  return result;
}

// Iterations that are left to `tolerance` at the pace of the last ten; 0 before there are so many.
double iterations_left(const std::vector<double>& residuals, double tolerance) {
  constexpr std::size_t window = 10;
  if (residuals.size() <= window) return 0;
  const double last = residuals.back(), before = residuals[residuals.size() - 1 - window];
  const double pace = std::log(before / last) / window;
  return pace > 0 ? std::log(last / tolerance) / pace : std::numeric_limits<double>::infinity();
}

double largest_root(const Lanes& a) {
  return std::sqrt(*std::max_element(std::begin(a.v), std::end(a.v)));
}

}  // namespace

ConjugateGradientResult conjugate_gradients(MultiVectorProduct& product, MultiVector& b,
                                            const Preconditioner& precondition,
                                            const ConjugateGradientOptions& options,
                                            common::Progress& progress) {
  const std::size_t size = b.size();
  MultiVector& r = b;
  ConjugateGradientResult result{.x = MultiVector(size, Lanes{})};
  MultiVector z(size), q(size);
  precondition(r, z);
  MultiVector p = z;
  InnerProduct inner(product);
  product.pool().for_each(product.pieces(), [&](int piece) { inner.add_piece(piece, r, z); });
  const Lanes first = inner.total();
  Lanes rz = first;
  std::vector<double> residuals;
  while (result.iterations < options.most_iterations) {
    progress.report(
        "conjugate gradients",
        result.iterations == 0
            ? 0
            : std::clamp(std::log(result.residual) / std::log(options.tolerance), 0., 1.));
    product(p, q, [&](int piece) { inner.add_piece(piece, p, q); });
    const Lanes alpha = ratio(rz, inner.total());
    product.pool().for_each(product.pieces(), [&](int piece) {
      for (auto i = at(3 * product.first(piece)); i < at(3 * product.end(piece)); ++i)
        for (int lane = 0; lane < lane_count; ++lane) {
          result.x[i].v[lane] += alpha.v[lane] * p[i].v[lane];
          r[i].v[lane] -= alpha.v[lane] * q[i].v[lane];
        }
    });
    precondition(r, z);
    product.pool().for_each(product.pieces(), [&](int piece) { inner.add_piece(piece, r, z); });
    const Lanes before = std::exchange(rz, inner.total());
    const Lanes beta = ratio(rz, before);
    ++result.iterations;
    result.alpha.push_back(alpha);
    result.beta.push_back(beta);
    result.residual = largest_root(ratio(rz, first));
    if (!(result.residual < 1e6)) return result;
    if (result.residual <= options.tolerance) {
      result.converged = true;
      return result;
    }
    residuals.push_back(result.residual);
    if (iterations_left(residuals, options.tolerance) > options.most_left) return result;
    product.pool().for_each(product.pieces(), [&](int piece) {
      for (auto i = at(3 * product.first(piece)); i < at(3 * product.end(piece)); ++i)
        for (int lane = 0; lane < lane_count; ++lane)
          p[i].v[lane] = z[i].v[lane] + beta.v[lane] * p[i].v[lane];
    });
  }
  return result;
}

// The coefficients are those of the Lanczos process: M A is similar to a tridiagonal matrix with
// diagonal 1/alpha_i + beta_(i-1)/alpha_(i-1) and off-diagonal sqrt(beta_i)/alpha_i.
double largest_ritz_value(const ConjugateGradientResult& result) {
  double largest = 0;
  for (int lane = 0; lane < lane_count; ++lane) {
    const auto alpha = [&](int i) { return result.alpha[at(i)].v[lane]; };
    const auto beta = [&](int i) { return result.beta[at(i)].v[lane]; };
    int steps = 0;
    while (steps < result.iterations && alpha(steps) > 0) ++steps;
    if (steps == 0) continue;
    Eigen::VectorXd diagonal(steps), off(std::max(steps - 1, 0));
    for (int i = 0; i < steps; ++i) {
      diagonal[i] = 1 / alpha(i) + (i > 0 ? beta(i - 1) / alpha(i - 1) : 0);
      if (i + 1 < steps) off[i] = std::sqrt(beta(i)) / alpha(i);
    }
    largest = std::max(largest, spatial::tridiagonal_eigenvalues(diagonal, off).maxCoeff());
  }
  return largest;
}

}  // namespace kinetostat::fea

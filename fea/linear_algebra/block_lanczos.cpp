#include "kinetostat/fea/linear_algebra/block_lanczos.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::fea::block_lanczos {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index block = 8;
// A column that orthogonalisation leaves less than this of is rounding.
constexpr double nothing = 1e-12;

class BlockLanczos {
 public:
  BlockLanczos(const Product& a, const Product& mass, Index size, Index count,
               const LanczosOptions& options)
      : a_(a),
        mass_(mass),
        count_(count),
        tolerance_(options.tolerance),
        most_columns_(std::min(size, options.most_columns > 0
                                         ? std::max(options.most_columns, count + 3 * block)
                                         : 3 * count + 10 * block)) {
    basis_.resize(size, 0);
    projected_.resize(0, 0);
    std::mt19937_64 random(1);  // any start that has a share of every vector
    std::uniform_real_distribution<double> uniform(-1, 1);
    next_ = a_(
        mass_(MatrixXd::NullaryExpr(size, std::min(block, size), [&] { return uniform(random); })));
    orthonormalise(next_);
  }

  // One block more. Whether the wanted pairs are known, or there are no more.
  bool step() {
    if (next_.cols() == 0) return true;
    if (basis_.cols() + next_.cols() > most_columns_ && basis_.cols() > count_ + 2 * block)
      restart();
    const Index before = basis_.cols(), width = next_.cols();
    basis_.conservativeResize(Eigen::NoChange, before + width);
    basis_.rightCols(width) = next_;
    next_ = a_(mass_(next_));
    const MatrixXd image = next_;
    project(before, width);
    orthonormalise(next_);
    beside_ = next_.transpose() * mass_(image);
    ritz_ = spatial::symmetric_eigen(projected_);
    return next_.cols() == 0 || converged();
  }

  // Share of the pairs that are known.
  double share() const { return static_cast<double>(known_) / static_cast<double>(count_); }

  EigenPairs pairs() const {
    const Index found = std::min(count_, projected_.cols());
    return {.values = ritz_.values.tail(found).reverse(),
            .vectors = basis_ * ritz_.vectors.rightCols(found).rowwise().reverse()};
  }

 private:
  // The new columns of Q' M A M Q.
  void project(Index before, Index width) {
    const MatrixXd columns = basis_.transpose() * mass_(next_);
    MatrixXd grown = MatrixXd::Zero(before + width, before + width);
    grown.topLeftCorner(before, before) = projected_;
    grown.rightCols(width) = columns;
    grown.bottomRows(width) = columns.transpose();
    grown.bottomRightCorner(width, width) =
        0.5 * (columns.bottomRows(width) + columns.bottomRows(width).transpose());
    projected_ = std::move(grown);
  }

  // Twice, because once leaves what rounding does. Columns of which nothing is left are dropped.
  void orthonormalise(MatrixXd& columns) const {
    VectorXd sizes = columns.cwiseProduct(mass_(columns)).colwise().sum().cwiseSqrt();
    if (columns.cols() > 0) sizes.setConstant(sizes.maxCoeff());
    for (int pass = 0; pass < 2; ++pass) {
      columns -= basis_ * (basis_.transpose() * mass_(columns)).eval();
      orthonormalise_among_themselves(columns, sizes);
      sizes = VectorXd::Ones(columns.cols());
    }
  }

  void orthonormalise_among_themselves(MatrixXd& columns, const VectorXd& sizes) const {
    MatrixXd forces = mass_(columns);
    Index kept = 0;
    for (Index j = 0; j < columns.cols(); ++j) {
      for (Index i = 0; i < kept; ++i) {
        const double share = forces.col(i).dot(columns.col(j));
        columns.col(j) -= share * columns.col(i);
        forces.col(j) -= share * forces.col(i);
      }
      const double length = std::sqrt(std::max(columns.col(j).dot(forces.col(j)), 0.0));
      if (!(length > nothing * sizes[j])) continue;
      columns.col(kept) = columns.col(j) / length;
      forces.col(kept) = forces.col(j) / length;
      ++kept;
    }
    columns.conservativeResize(Eigen::NoChange, kept);
  }

  // The residual of a Ritz pair is what A M maps its share of the last block to, beyond the basis.
  bool converged() {
    const Index wanted = std::min(count_, projected_.cols());
    const Index last = beside_.cols();
    known_ = 0;
    for (Index k = 1; k <= wanted; ++k) {
      const Index column = projected_.cols() - k;
      const double residual = (beside_ * ritz_.vectors.col(column).tail(last)).norm();
      if (residual <= tolerance_ * std::abs(ritz_.values[column])) ++known_;
    }
    return known_ == count_;
  }

  // Only the best Ritz vectors are kept.
  void restart() {
    const Index kept = std::min(basis_.cols(), count_ + block);
    basis_ = (basis_ * ritz_.vectors.rightCols(kept)).eval();
    projected_ = ritz_.values.tail(kept).asDiagonal();
  }

  const Product &a_, &mass_;
  Index count_;
  double tolerance_;
  Index most_columns_;
  MatrixXd basis_, projected_;  // Q, M-orthonormal, and Q' M A M Q
  MatrixXd next_, beside_;      // the block that follows, and next' M A M of the last one
  spatial::SymmetricEigen ritz_;
  Index known_ = 0;
};

}  // namespace
}  // namespace kinetostat::fea::block_lanczos

namespace kinetostat::fea {

EigenPairs largest_eigenpairs(const Product& a, const Product& mass, Eigen::Index size, int count,
                              const LanczosOptions& options, common::Progress& progress) {
  block_lanczos::BlockLanczos lanczos(a, mass, size, std::min<Eigen::Index>(count, size), options);
  for (int step = 0; step < options.most_blocks; ++step) {
    progress.report("modes", lanczos.share());
    if (lanczos.step()) return lanczos.pairs();
  }
  throw common::NoConvergence(
      fmt::format("the modes are not found in {} steps of Lanczos' method", options.most_blocks));
}

}  // namespace kinetostat::fea

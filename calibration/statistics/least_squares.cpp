#include "kinetostat/calibration/statistics/least_squares.h"

#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include <Eigen/QR>

#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double huber_width = 1.345, cauchy_width = 2.385;
// A cost that is the same to this share: what rounding of the residuals hides.
constexpr double cost_rounding = 1e-13;
// Share of the damping lengths of one iteration that is left in the next.
constexpr double forgetting = 0.7;
// A column that has shrunk to this share has lost its influence: the step before was too long.
constexpr double lost = 1e-7;
// With which a problem is tried again that has run into such a place.
constexpr double careful_damping = 1e3;
// Share of the way from the start to a bound at which an unknown counts as being on it.
constexpr double on_bound = 1e-9;
// After a step in vain the next one is shorter by this, at most.
constexpr double shorter = 0.5;
// A longest step that was kept in full, with most of what it promised, is so much longer from then
// on.
constexpr double longer = 3, well_kept = 0.75;
// In a row that may promise too little to go on for.
constexpr int few_steps = 4;
// Beyond this damping a step is too short to change the unknowns in double precision.
constexpr double largest_damping = 1e18;

VectorXd or_constant(const VectorXd& given, Index size, double value) {
  if (given.size() == 0) return VectorXd::Constant(size, value);
  if (given.size() != size)
    throw std::invalid_argument("bounds of a least-squares problem have another size than it");
  return given;
}

double total_cost(Loss loss, const VectorXd& residual) {
  double sum = 0;
  for (const double r : residual) sum += cost_of(loss, r);
  return sum;
}

VectorXd weights_of(Loss loss, const VectorXd& residual) {
  return residual.unaryExpr([loss](double r) { return weight_of(loss, r); });
}

constexpr Index tall = 8192;        // of more rows only a triangle is kept
constexpr Index block_rows = 2048;  // that are brought to it at once

// The rows that fill(first, count) gives; of more than a block only their triangle.
template <typename Fill>
MatrixXd condensed_rows(Index rows, Index columns, const Fill& fill) {
  MatrixXd work(rows > tall ? block_rows + columns : rows, columns);
  Index kept = 0;
  for (Index first = 0, count = 0; first < rows; first += count) {
    count = std::min(work.rows() - kept, rows - first);
    work.middleRows(kept, count) = fill(first, count);
    kept += count;
    if (kept == rows) return work;
    Eigen::Ref<MatrixXd> filled = work.topRows(kept);
    const Eigen::HouseholderQR<Eigen::Ref<MatrixXd>> in_place(filled);
    kept = std::min(kept, columns);
    work.topRows(kept).triangularView<Eigen::StrictlyLower>().setZero();
  }
  return work.topRows(kept);
}

// The linear problem of one step: least |r + J s|^2 + damping |D s|^2 for s in a box.
struct StepProblem {
  MatrixXd jacobian;  // rows weighted, or their triangle
  VectorXd residual;
  VectorXd lengths;  // D
  VectorXd lower, upper;

  VectorXd free_step(const std::vector<Index>& moving, const VectorXd& right,
                     double damping) const {
    const auto n = static_cast<Index>(moving.size());
    const Index m = jacobian.rows();
    const VectorXd d = lengths(moving);
    MatrixXd matrix(m + n, n);
    matrix.topRows(m) = jacobian(Eigen::all, moving) * d.cwiseInverse().asDiagonal();
    matrix.bottomRows(n) = std::sqrt(damping) * MatrixXd::Identity(n, n);
    VectorXd extended = VectorXd::Zero(m + n);
    extended.head(m) = -right;
    return spatial::least_squares_solution(matrix, extended).cwiseQuotient(d);
  }

  // Held unknowns that would lower the damped cost by moving inwards.
  std::optional<Index> to_release(const std::vector<Index>& held, const VectorXd& step,
                                  double damping) const {
    const VectorXd gradient = jacobian.transpose() * (residual + jacobian * step) +
                              damping * lengths.cwiseAbs2().cwiseProduct(step);
    std::optional<Index> best;
    double most = 1e-10;
    for (const Index k : held) {
      if (lower[k] == upper[k]) continue;
      const double slope = gradient[k] / lengths[k];
      const double gain = (step[k] >= upper[k] ? slope : -slope) / (residual.norm() + 1e-300);
      if (gain > most) most = gain, best = k;
    }
    return best;
  }
};

// Active sets: the unknown that leaves its box most is held at its bound, and one that would rather
// come back is released. Without bounds a weak unknown beside a strong one that is far off diverges
// on the remainder of the strong one's curvature.
VectorXd bounded_step(const StepProblem& problem, double damping) {
  const Index n = problem.jacobian.cols();
  std::vector<Index> moving, held;
  for (Index k = 0; k < n; ++k) {
    const bool stays = problem.lower[k] == problem.upper[k] || problem.jacobian.col(k).isZero(0);
    (stays ? held : moving).push_back(k);
  }
  VectorXd step = VectorXd::Zero(n);
  for (Index turn = 0; turn < 4 * n + 4; ++turn) {
    VectorXd right = problem.residual;
    for (const Index k : held) right += step[k] * problem.jacobian.col(k);
    if (!moving.empty()) step(moving) = problem.free_step(moving, right, damping);
    double worst = 0;
    std::size_t where = moving.size();
    for (std::size_t i = 0; i < moving.size(); ++i) {
      const Index k = moving[i];
      const double over = std::max(problem.lower[k] - step[k], step[k] - problem.upper[k]);
      if (over * problem.lengths[k] > worst) worst = over * problem.lengths[k], where = i;
    }
    if (where < moving.size()) {
      const Index k = moving[where];
      step[k] = std::clamp(step[k], problem.lower[k], problem.upper[k]);
      held.push_back(k);
      moving.erase(moving.begin() + static_cast<std::ptrdiff_t>(where));
      continue;
    }
    // Releasing may go round in circles at the level of rounding; then the step is good enough.
    const std::optional<Index> back =
        turn < 2 * n + 2 ? problem.to_release(held, step, damping) : std::nullopt;
    if (!back) return step;
    held.erase(std::find(held.begin(), held.end(), *back));
    moving.push_back(*back);
  }
  return step.cwiseMax(problem.lower).cwiseMin(problem.upper);
}

class Solver {
 public:
  Solver(const ResidualFunction& residuals, const VectorXd& start,
         const LeastSquaresOptions& options)
      : residuals_(residuals), options_(options) {
    const Index n = start.size();
    lower_ = or_constant(options.lower, n, -infinity);
    upper_ = or_constant(options.upper, n, infinity);
    longest_ = or_constant(options.longest_step, n, infinity);
    if ((start.array() < lower_.array()).any() || (start.array() > upper_.array()).any())
      throw std::invalid_argument("the start of a least-squares problem is out of its bounds");
    result_.x = start;
  }

  LeastSquaresResult run() {
    const VectorXd start = result_.x;
    iterate(options_.first_damping);
    if (result_.status == LeastSquaresStatus::no_start) return std::move(result_);
    if (has_lost_an_unknown() && options_.first_damping < careful_damping) try_again(start);
    result_.weights = weights_of(options_.loss, result_.at.residual);
    settle_on_bounds(start);
    find_hits();
    return std::move(result_);
  }

 private:
  bool has_lost_an_unknown() const {
    const VectorXd now = result_.at.jacobian.colwise().norm();
    for (Index k = 0; k < now.size(); ++k)
      if (now[k] < lost * longest_lengths_[k]) return true;
    return false;
  }

  // The flat land where an unknown has no influence is no minimum, unless shorter steps end there
  // as well.
  void try_again(const VectorXd& start) {
    const LeastSquaresResult first = result_;
    result_.x = start;
    lengths_ = longest_lengths_ = {};
    iterate(careful_damping);
    if (!(result_.cost < first.cost)) {
      const int iterations = result_.iterations;
      result_ = first;
      result_.iterations = iterations;
    }
  }

  void iterate(double first_damping) {
    std::optional<Linearisation> first = evaluate(result_.x);
    result_.status = LeastSquaresStatus::no_start;
    if (!first) return;
    accept(result_.x, std::move(*first));
    result_.status = LeastSquaresStatus::converged;
    if (result_.x.size() > 0) result_.status = iterate_from_there(first_damping);
    if (is_tall() && result_.at.jacobian.size() == 0) result_.at = *residuals_(result_.x);
  }

  LeastSquaresStatus iterate_from_there(double first_damping) {
    scale_ = options_.scale > 0 ? options_.scale : result_.at.residual.norm();
    double damping = first_damping, growth = 2;
    double too_long = infinity;  // the change that was promised in vain from where it stands
    int in_vain = 0;
    while (result_.iterations < options_.max_iterations) {
      const StepProblem problem = step_problem();
      VectorXd step = bounded_step(problem, damping);
      double change = (problem.jacobian * step).norm();
      while (change > shorter * too_long && damping <= largest_damping) {
        raise(damping, growth);
        step = bounded_step(problem, damping);
        change = (problem.jacobian * step).norm();
      }
      const VectorXd candidate = (result_.x + step).cwiseMax(lower_).cwiseMin(upper_);
      // A short step may be short because it is damped: polishing takes whole ones.
      if (change <= options_.tolerance * scale_ || candidate == result_.x)
        return damping > largest_damping ? LeastSquaresStatus::stalled : polish();
      const double promised = problem.residual.squaredNorm() -
                              (problem.residual + problem.jacobian * step).squaredNorm();
      // Where rounding of the cost hides the progress only the length of the steps tells.
      if (promised <= cost_rounding * result_.cost) return polish();
      in_vain = promised < options_.least_gain ? in_vain + 1 : 0;
      if (in_vain > few_steps) return LeastSquaresStatus::converged;
      std::optional<Linearisation> next = evaluate_beside(candidate);
      const double cost = next ? total_cost(options_.loss, next->residual) : infinity;
      if (cost < result_.cost) {
        const double ratio = (result_.cost - cost) / promised;
        damping *= std::max(1.0 / 3, 1 - std::pow(2 * ratio - 1, 3));
        growth = 2;
        too_long = infinity;
        if (ratio > well_kept) lengthen(step);
        accept(candidate, std::move(*next));
      } else {
        if (damping > largest_damping) return LeastSquaresStatus::stalled;
        raise(damping, growth);
        too_long = change;
      }
    }
    return LeastSquaresStatus::max_iterations;
  }

  // What would go farther: a guess of how far the linear model holds must not cost many steps.
  void lengthen(const VectorXd& step) {
    for (Index k = 0; k < step.size(); ++k)
      if (std::abs(step[k]) >= longest_[k]) longest_[k] *= longer;
  }

  static void raise(double& damping, double& growth) {
    damping = std::max(damping, 1e-6) * growth;
    growth *= 2;
  }

  // Undamped steps as long as each is at most half as long as the one before.
  LeastSquaresStatus polish() {
    double previous = infinity;
    while (result_.iterations < options_.max_iterations) {
      const StepProblem problem = step_problem();
      const VectorXd step = bounded_step(problem, 0);
      const double change = (problem.jacobian * step).norm();
      if (change <= options_.tolerance * scale_ || change > 0.9 * previous) break;
      const VectorXd candidate = (result_.x + step).cwiseMax(lower_).cwiseMin(upper_);
      std::optional<Linearisation> next = evaluate_beside(candidate);
      if (!next || total_cost(options_.loss, next->residual) > result_.cost + slack()) break;
      accept(candidate, std::move(*next));
      previous = change;
    }
    return LeastSquaresStatus::converged;
  }

  // By which the cost may seem to grow for the rounding of the residuals alone.
  double slack() const { return 1e-10 * result_.cost + 1e-14 * scale_ * std::sqrt(result_.cost); }

  std::optional<Linearisation> evaluate(const VectorXd& x) {
    ++result_.iterations;
    std::optional<Linearisation> at = residuals_(x);
    if (!at || !at->residual.allFinite() || !at->jacobian.allFinite()) return std::nullopt;
    return at;
  }

  // Derivatives of many rows are not kept beside those of the next place: steps need their
  // triangle.
  bool is_tall() const { return result_.at.residual.size() > tall; }
  std::optional<Linearisation> evaluate_beside(const VectorXd& x) {
    if (is_tall()) result_.at.jacobian.resize(0, 0);
    return evaluate(x);
  }

  void accept(const VectorXd& x, Linearisation at) {
    result_.x = x;
    result_.at = std::move(at);
    result_.cost = total_cost(options_.loss, result_.at.residual);
    find_rows();
  }

  // [W J, W r], W of the roots of the weights.
  void find_rows() {
    const VectorXd roots = weights_of(options_.loss, result_.at.residual).cwiseSqrt();
    const Linearisation& at = result_.at;
    const Index n = at.jacobian.cols();
    rows_ = condensed_rows(at.residual.size(), n + 1, [&](Index first, Index count) {
      MatrixXd block(count, n + 1);
      block << at.jacobian.middleRows(first, count), at.residual.segment(first, count);
      return MatrixXd(roots.segment(first, count).asDiagonal() * block);
    });
  }

  StepProblem step_problem() {
    StepProblem problem;
    problem.jacobian = rows_.leftCols(result_.x.size());
    problem.residual = rows_.rightCols<1>();
    // The longest so far (Moré 1978): an unknown that has lost its influence on the way is still
    // restrained.
    const VectorXd now = problem.jacobian.colwise().norm();
    lengths_ = lengths_.size() == 0 ? now : (forgetting * lengths_).cwiseMax(now).eval();
    longest_lengths_ = longest_lengths_.size() == 0 ? now : longest_lengths_.cwiseMax(now).eval();
    problem.lengths = lengths_;
    // An unknown that nothing depends on stays where it is.
    for (double& length : problem.lengths)
      if (!(length > 0)) length = 1;
    problem.lower = (lower_ - result_.x).cwiseMax(-longest_);
    problem.upper = (upper_ - result_.x).cwiseMin(longest_);
    return problem;
  }

  // An unknown that has come from its start to a billionth of the way of a bound is on it: which
  // side of the last rounding it ends on must not decide whether it counts as fitted.
  void settle_on_bounds(const VectorXd& start) {
    for (Index k = 0; k < start.size(); ++k)
      for (const double bound : {lower_[k], upper_[k]})
        if (std::isfinite(bound) &&
            std::abs(result_.x[k] - bound) <= on_bound * std::abs(start[k] - bound))
          result_.x[k] = bound;
  }

  void find_hits() {
    const VectorXd slope =
        result_.at.jacobian.transpose() * result_.weights.cwiseProduct(result_.at.residual);
    for (Index k = 0; k < result_.x.size(); ++k) {
      BoundHit hit = BoundHit::none;
      if (result_.x[k] == lower_[k] && slope[k] >= 0) hit = BoundHit::lower;
      if (result_.x[k] == upper_[k] && slope[k] <= 0) hit = BoundHit::upper;
      result_.hit.push_back(hit);
    }
  }

  const ResidualFunction& residuals_;
  const LeastSquaresOptions& options_;
  VectorXd lower_, upper_, longest_;
  double scale_ = 0;
  MatrixXd rows_;             // of the last accepted place, weighted, its residual last
  VectorXd lengths_;          // by which steps are damped
  VectorXd longest_lengths_;  // of the columns, ever
  LeastSquaresResult result_;
};

// Columns of unit length over the free unknowns, and what they were divided by.
struct Scaled {
  MatrixXd matrix;
  VectorXd lengths;
};

Scaled scaled(const MatrixXd& jacobian, const std::vector<Index>& free) {
  Scaled result{condensed(jacobian)(Eigen::all, free), {}};
  result.lengths = result.matrix.colwise().norm();
  for (double& length : result.lengths)
    if (!(length > 0)) length = 1;
  result.matrix = result.matrix * result.lengths.cwiseInverse().asDiagonal();
  return result;
}

// R of the orthogonal factors, with as many rows as columns.
MatrixXd triangle(const MatrixXd& matrix) {
  const Index n = matrix.cols();
  MatrixXd padded = MatrixXd::Zero(std::max(matrix.rows(), n), n);
  padded.topRows(matrix.rows()) = matrix;
  return Eigen::HouseholderQR<MatrixXd>(padded)
      .matrixQR()
      .topRows(n)
      .triangularView<Eigen::Upper>();
}

}  // namespace

double weight_of(Loss loss, double residual) {
  const double size = std::abs(residual);
  if (loss == Loss::huber) return size <= huber_width ? 1 : huber_width / size;
  if (loss == Loss::cauchy) return 1 / (1 + std::pow(size / cauchy_width, 2));
  return 1;
}

double cost_of(Loss loss, double residual) {
  const double size = std::abs(residual);
  if (loss == Loss::huber && size > huber_width) return huber_width * (2 * size - huber_width);
  if (loss == Loss::cauchy)
    return cauchy_width * cauchy_width * std::log1p(std::pow(size / cauchy_width, 2));
  return size * size;
}

double influence_slope(Loss loss, double residual) {
  const double size = std::abs(residual);
  if (loss == Loss::huber) return size <= huber_width ? 1 : 0;
  if (loss == Loss::cauchy) {
    const double s = std::pow(size / cauchy_width, 2);
    return (1 - s) / ((1 + s) * (1 + s));
  }
  return 1;
}

std::vector<Index> LeastSquaresResult::free() const {
  std::vector<Index> result;
  for (std::size_t k = 0; k < hit.size(); ++k)
    if (hit[k] == BoundHit::none) result.push_back(static_cast<Index>(k));
  return result;
}

LeastSquaresResult minimise(const ResidualFunction& residuals, const VectorXd& start,
                            const LeastSquaresOptions& options) {
  return Solver(residuals, start, options).run();
}

MatrixXd condensed(const Eigen::Ref<const MatrixXd>& matrix) {
  return condensed_rows(matrix.rows(), matrix.cols(),
                        [&](Index first, Index count) { return matrix.middleRows(first, count); });
}

MatrixXd inverse_normal_matrix(const MatrixXd& jacobian, const std::vector<Index>& free) {
  MatrixXd result = MatrixXd::Zero(jacobian.cols(), jacobian.cols());
  const auto n = static_cast<Index>(free.size());
  if (n == 0) return result;
  const Scaled columns = scaled(jacobian, free);
  const MatrixXd inverse =
      columns.lengths.cwiseInverse().asDiagonal() * triangle(columns.matrix)
                                                        .triangularView<Eigen::Upper>()
                                                        .solve(MatrixXd::Identity(n, n))
                                                        .eval();
  result(free, free) = inverse * inverse.transpose();
  return result;
}

std::vector<WeakCombination> weak_combinations(const MatrixXd& jacobian,
                                               const std::vector<Index>& free, double from) {
  std::vector<WeakCombination> result;
  if (free.size() < 2) return result;
  const Scaled columns = scaled(jacobian, free);
  const spatial::SingularValues svd =
      spatial::singular_value_decomposition(triangle(columns.matrix));
  const VectorXd& values = svd.values;
  for (Index i = values.size() - 1; i >= 0 && values[0] >= from * values[i]; --i) {
    WeakCombination weak{VectorXd::Zero(jacobian.cols()), VectorXd::Zero(jacobian.cols()),
                         infinity};
    const VectorXd v = svd.v.col(i);
    const bool singular = !(values[i] > 1e-14 * values[0]);
    if (!singular) weak.condition_index = values[0] / values[i];
    weak.direction(free) = v.cwiseQuotient(columns.lengths) / (singular ? 1 : values[i]);
    weak.participation(free) = v.cwiseAbs() / v.cwiseAbs().maxCoeff();
    result.push_back(std::move(weak));
  }
  return result;
}

}  // namespace kinetostat::calibration

#include "kinetostat/calibration/base_fit.h"

#include <cmath>
#include <numeric>
#include <set>

#include <Eigen/QR>
#include <Eigen/SVD>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/files/error.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Relative size below which a sensitivity is nothing but rounding of the equilibrium.
constexpr double rounding = 1e-9;
// A stiffness factor beyond e^10 either way: the data want the spring rigid, or gone.
constexpr double runaway = 10;
// Longest step of a logarithm: a factor of e.
constexpr double longest_step = 1;

std::vector<Zero> zeros_of(const Campaign& campaign) {
  std::set<std::pair<std::size_t, Index>> found;
  if (campaign.zero == ZeroReading::estimated)
    for (const Value& value : values_in_use(campaign))
      found.emplace(campaign.readings[value.reading].session, value.component);
  std::vector<Zero> zeros;
  for (const auto& [session, component] : found) zeros.push_back({session, component});
  return zeros;
}

// The weighted least-squares problem: unknowns are log factors, then zeros.
class Problem {
 public:
  struct Linearisation {
    VectorXd residual;  // whitened, measured - predicted
    MatrixXd jacobian;  // of the whitened prediction
    std::vector<spatial::Vector6> predicted;
    std::optional<PredictionFailure> failure;
    double cost() const { return residual.squaredNorm(); }
  };

  Problem(const Predictor& predictor, const Campaign& campaign, const Noise& noise,
          const std::vector<Parameter>& parameters, files::Progress& progress)
      : predictor_(predictor),
        campaign_(campaign),
        noise_(noise),
        parameters_(parameters),
        zeros_(zeros_of(campaign)),
        values_(values_in_use(campaign)),
        progress_(progress) {}

  Index unknowns() const { return static_cast<Index>(parameters_.size() + zeros_.size()); }
  Index values() const { return static_cast<Index>(values_.size()); }
  const std::vector<Zero>& zeros() const { return zeros_; }
  const std::vector<Parameter>& parameters() const { return parameters_; }

  Linearisation at(const VectorXd& q) const {
    const auto p = static_cast<Index>(parameters_.size());
    Predictions predictions = predictor_.predict(parameters_, q.head(p), p > 0, progress_);
    Linearisation result;
    result.failure = predictions.failure;
    if (result.failure) return result;
    result.predicted = std::move(predictions.displacement);
    add_zeros(q, result.predicted);
    result.residual.resize(values());
    result.jacobian.setZero(values(), unknowns());
    for (Index i = 0; i < values(); ++i) {
      const Value& value = values_[static_cast<std::size_t>(i)];
      const double sigma = noise_.sigma[value.reading][value.component];
      const double measured = campaign_.readings[value.reading].displacement[value.component];
      result.residual[i] = (measured - result.predicted[value.reading][value.component]) / sigma;
      if (p > 0)
        result.jacobian.row(i).head(p) =
            predictions.derivatives[value.reading].row(value.component) / sigma;
      for (std::size_t z = 0; z < zeros_.size(); ++z)
        if (zero_applies(zeros_[z], value))
          result.jacobian(i, p + static_cast<Index>(z)) = 1 / sigma;
    }
    return result;
  }

  VectorXd measured() const {
    VectorXd y(values());
    for (Index i = 0; i < values(); ++i) {
      const Value& value = values_[static_cast<std::size_t>(i)];
      y[i] = campaign_.readings[value.reading].displacement[value.component] /
             noise_.sigma[value.reading][value.component];
    }
    return y;
  }

  std::string name(Index unknown) const {
    const auto p = static_cast<Index>(parameters_.size());
    if (unknown < p)
      return fmt::format("the stiffness of '{}'",
                         parameters_[static_cast<std::size_t>(unknown)].name);
    const Zero& zero = zeros_[static_cast<std::size_t>(unknown - p)];
    const std::string& session = campaign_.sessions[zero.session];
    return fmt::format("the zero of {}{}",
                       component_names[static_cast<std::size_t>(zero.component)],
                       session.empty() ? "" : fmt::format(" in session '{}'", session));
  }

  [[noreturn]] void fail_prediction(const PredictionFailure& failure) const {
    const Reading& reading = campaign_.readings[failure.reading];
    throw files::NoConvergence(
        fmt::format("{}:{}: the model has no equilibrium for reading '{}': {}. Check the load and "
                    "its unit, or mask the reading.",
                    campaign_.readings_file.string(), reading.line, reading.id, failure.reason));
  }

 private:
  bool zero_applies(const Zero& zero, const Value& value) const {
    return zero.component == value.component &&
           zero.session == campaign_.readings[value.reading].session;
  }

  void add_zeros(const VectorXd& q, std::vector<spatial::Vector6>& predicted) const {
    const auto p = static_cast<Index>(parameters_.size());
    for (std::size_t z = 0; z < zeros_.size(); ++z)
      for (std::size_t i = 0; i < predicted.size(); ++i)
        if (campaign_.readings[i].session == zeros_[z].session)
          predicted[i][zeros_[z].component] += q[p + static_cast<Index>(z)];
  }

  const Predictor& predictor_;
  const Campaign& campaign_;
  const Noise& noise_;
  const std::vector<Parameter>& parameters_;
  std::vector<Zero> zeros_;
  std::vector<Value> values_;
  files::Progress& progress_;
};

void require_enough_values(const Problem& problem) {
  if (problem.values() > problem.unknowns() || problem.unknowns() == 0) return;
  throw files::NotIdentifiable(
      fmt::format("{} measured values for {} unknowns (parameters and zeros) leave nothing to "
                  "judge the fit by. "
                  "Measure more, or declare less uncertain.",
                  problem.values(), problem.unknowns()));
}

void require_sensitivity(const Problem& problem, const Problem::Linearisation& state) {
  const auto p = static_cast<Index>(problem.parameters().size());
  const VectorXd sizes = state.jacobian.colwise().norm();
  double largest = problem.measured().norm();
  for (Index k = 0; k < p; ++k) largest = std::max(largest, sizes[k]);
  std::vector<std::string> idle;
  for (Index k = 0; k < p; ++k)
    if (!(sizes[k] > rounding * largest)) idle.push_back(problem.name(k));
  if (!idle.empty())
    throw files::NotIdentifiable(
        fmt::format("no reading depends on {}: these data cannot determine it. Load it in a "
                    "measured direction, or take it out of 'uncertain' in the robot file.",
                    fmt::join(idle, " and ")));
}

// A direction in the space of unknowns that changes no reading, in words.
void require_independence(const Problem& problem, const MatrixXd& scaled_jacobian) {
  if (problem.unknowns() == 0) return;
  const Eigen::JacobiSVD<MatrixXd> svd(Eigen::HouseholderQR<MatrixXd>(scaled_jacobian)
                                           .matrixQR()
                                           .topRows(problem.unknowns())
                                           .triangularView<Eigen::Upper>(),
                                       Eigen::ComputeFullV);
  if (svd.singularValues().tail<1>()[0] > rounding * svd.singularValues()[0]) return;
  const VectorXd direction = svd.matrixV().rightCols<1>();
  std::vector<std::string> members;
  for (Index k = 0; k < direction.size(); ++k)
    if (std::abs(direction[k]) > 0.1 * direction.cwiseAbs().maxCoeff())
      members.push_back(problem.name(k));
  throw files::NotIdentifiable(
      fmt::format("these data cannot tell {} apart: they change all readings in the same "
                  "proportion. Measure other poses, loads or components, or declare fewer of them "
                  "uncertain.",
                  fmt::join(members, " and ")));
}

void require_identifiable(const Problem& problem, const Problem::Linearisation& state) {
  require_sensitivity(problem, state);
  require_independence(problem, state.jacobian.colwise().normalized());
}

// Step of some unknowns that minimises |residual - J step|^2 + damping |D step|^2, with D the
// lengths of J's columns.
VectorXd damped_step(const MatrixXd& jacobian, const VectorXd& residual, double damping) {
  const Index n = jacobian.cols(), m = jacobian.rows();
  const VectorXd lengths = jacobian.colwise().norm();
  MatrixXd matrix(m + n, n);
  matrix.topRows(m) = jacobian * lengths.cwiseInverse().asDiagonal();
  matrix.bottomRows(n) = std::sqrt(damping) * MatrixXd::Identity(n, n);
  VectorXd right(m + n);
  right << residual, VectorXd::Zero(n);
  return matrix.householderQr().solve(right).cwiseQuotient(lengths);
}

// The same with no stiffness changing by more than a bounded factor: one after the other, the worst
// is held at its bound while the rest find their best. Without bounds a weak parameter beside a
// strong one that is far off runs away on what the strong one's curvature leaves over.
VectorXd bounded_step(const Problem& problem, const Problem::Linearisation& state, double damping) {
  const auto p = static_cast<Index>(problem.parameters().size());
  std::vector<Index> moving(static_cast<std::size_t>(problem.unknowns()));
  std::iota(moving.begin(), moving.end(), 0);
  VectorXd step = VectorXd::Zero(problem.unknowns());
  VectorXd residual = state.residual;
  while (!moving.empty()) {
    step(moving) = damped_step(state.jacobian(Eigen::all, moving), residual, damping);
    const auto worst = std::max_element(moving.begin(), moving.end(), [&](Index a, Index b) {
      return (a < p ? std::abs(step[a]) : 0) < (b < p ? std::abs(step[b]) : 0);
    });
    if (*worst >= p || std::abs(step[*worst]) <= longest_step) break;
    step[*worst] = std::copysign(longest_step, step[*worst]);
    residual -= step[*worst] * state.jacobian.col(*worst);
    moving.erase(worst);
  }
  return step;
}

void require_bounded(const Problem& problem, const VectorXd& q) {
  for (Index k = 0; k < static_cast<Index>(problem.parameters().size()); ++k)
    if (std::abs(q[k]) > runaway)
      throw files::NotIdentifiable(fmt::format(
          "{} runs away to {}: these readings {}. Check units and signs of load and "
          "displacement, or take it out of 'uncertain' in the robot file.",
          problem.name(k), q[k] > 0 ? "infinity" : "zero",
          q[k] > 0 ? "show no such compliance" : "are larger than any spring explains"));
}

struct Solution {
  VectorXd unknowns;
  Problem::Linearisation state;
  int iterations = 0;
};

Solution solve(const Problem& problem, const BaseFitOptions& options) {
  Solution now{VectorXd::Zero(problem.unknowns()), {}, 0};
  now.state = problem.at(now.unknowns);
  if (now.state.failure) problem.fail_prediction(*now.state.failure);
  if (problem.unknowns() == 0) return now;
  const VectorXd measured = problem.measured();
  const double size = measured.norm() + (measured - now.state.residual).norm();
  double damping = 0;
  while (now.iterations < options.max_iterations) {
    ++now.iterations;
    require_identifiable(problem, now.state);
    const VectorXd step = bounded_step(problem, now.state, damping);
    const double change = (now.state.jacobian * step).norm();
    if (change <= options.tolerance * size) return now;
    const VectorXd candidate = now.unknowns + step;
    Problem::Linearisation next = problem.at(candidate);
    const bool better = !next.failure && next.cost() <= now.state.cost();
    // Where rounding of the equilibrium hides the progress there is none left to make.
    if (!better && change <= 1e-9 * size) return now;
    if (better) {
      require_bounded(problem, candidate);
      now.unknowns = candidate;
      now.state = std::move(next);
      damping = damping > 1e-8 ? damping / 10 : 0;
    } else {
      damping = std::max(1e-3, damping * 10);
    }
  }
  throw files::NoConvergence(
      fmt::format("the fit of the uncertain parameters did not converge in {} iterations",
                  options.max_iterations));
}

MatrixXd covariance_of(const Problem& problem, const Problem::Linearisation& state,
                       const Noise& noise) {
  const Index n = problem.unknowns();
  if (n == 0) return MatrixXd(0, 0);
  const VectorXd lengths = state.jacobian.colwise().norm();
  const MatrixXd scaled = state.jacobian * lengths.cwiseInverse().asDiagonal();
  const MatrixXd r =
      Eigen::HouseholderQR<MatrixXd>(scaled).matrixQR().topRows(n).triangularView<Eigen::Upper>();
  const MatrixXd inverse = lengths.cwiseInverse().asDiagonal() *
                           r.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(n, n)).eval();
  const double variance = noise.source == NoiseSource::unknown
                              ? state.cost() / static_cast<double>(problem.values() - n)
                              : 1.0;
  return variance * inverse * inverse.transpose();
}

}  // namespace

std::vector<Value> values_in_use(const Campaign& campaign) {
  std::vector<Value> values;
  for (std::size_t i = 0; i < campaign.readings.size(); ++i)
    for (Index k = 0; k < 6; ++k)
      if (campaign.readings[i].uses(k)) values.push_back({i, k});
  return values;
}

BaseFit fit_base(const Predictor& predictor, const Campaign& campaign, const Noise& noise,
                 const std::vector<Parameter>& parameters, files::Progress& progress,
                 const BaseFitOptions& options) {
  if (!noise.comparable && !parameters.empty())
    throw files::InputError(
        {.file = campaign.file,
         .key = "noise",
         .what = "translations and rotations cannot be fitted together, because nothing says how "
                 "exact either is",
         .cure = "State 'noise: {translation: ..., rotation: ...}', or repeat readings"});
  const Problem problem(predictor, campaign, noise, parameters, progress);
  require_enough_values(problem);
  Solution solution = solve(problem, options);
  BaseFit fit;
  fit.covariance = covariance_of(problem, solution.state, noise);
  fit.error_source = noise.source;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const auto i = static_cast<Index>(k);
    fit.parameters.push_back(
        {parameters[k], solution.unknowns[i], std::sqrt(fit.covariance(i, i))});
  }
  fit.zeros = problem.zeros();
  for (std::size_t z = 0; z < fit.zeros.size(); ++z) {
    const auto i = static_cast<Index>(parameters.size() + z);
    fit.zeros[z].value = solution.unknowns[i];
    fit.zeros[z].standard_error = std::sqrt(fit.covariance(i, i));
  }
  fit.predicted = std::move(solution.state.predicted);
  fit.squared_error = solution.state.cost();
  fit.values = problem.values();
  fit.iterations = solution.iterations;
  return fit;
}

}  // namespace kinetostat::calibration

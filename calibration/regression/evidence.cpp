#include "kinetostat/calibration/regression/evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <span>

#include <Eigen/Cholesky>

#include "kinetostat/calibration/regression/held_out.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double at_bound = 5;  // what a value at the end of its range costs in log evidence

// Unknowns that a bound holds and no prior knows play no part.
std::vector<Index> that_count(const BaseFit& fit) {
  std::vector<Index> kept;
  for (Index k = 0; k < fit.at.jacobian.cols(); ++k) {
    const auto p = static_cast<std::size_t>(k);
    if (p >= fit.parameters.size() || fit.parameters[p].hit == BoundHit::none ||
        fit.parameters[p].parameter.prior)
      kept.push_back(k);
  }
  return kept;
}

// The posterior about a fit as a normal distribution, for any width of the priors.
class Posterior {
 public:
  Posterior(const BaseFit& fit, double exponent)
      : fit_(fit), kept_(that_count(fit)), fixed_(-0.5 * exponent * fit.squared_error) {
    const auto n = static_cast<Index>(kept_.size());
    const MatrixXd j = fit.at.jacobian(Eigen::all, kept_);
    curvature_ = exponent * j.transpose() * j;
    distance_ = deviation_ = VectorXd::Zero(n);
    scales_ = fitted_ = VectorXd::Ones(n);
    group_.assign(kept_.size(), -1);
    for (Index i = 0; i < n; ++i) {
      const auto p = static_cast<std::size_t>(kept_[static_cast<std::size_t>(i)]);
      if (p < fit.parameters.size()) add_parameter(fit.parameters[p], i);
      // Columns of unit length, so that units do not matter.
      const double widest =
          deviation_[i] > 0 ? 1 / (widest_prior * widest_prior * deviation_[i] * deviation_[i]) : 0;
      lengths_.push_back(std::sqrt(std::max(1e-300, curvature_(i, i) + widest)));
    }
    scales_ = fitted_;
    take_force(exponent * precisions().cwiseProduct(distance_),
               -exponent * (j.transpose() * fit.at.residual));
    scales_.setOnes();
  }

  std::set<int> groups() const {
    std::set<int> groups(group_.begin(), group_.end());
    groups.erase(-1);
    return groups;
  }
  void set_scale(int group, double scale) {
    for (std::size_t i = 0; i < group_.size(); ++i)
      if (group_[i] == group) scales_[static_cast<Index>(i)] = scale;
  }

  double log_evidence() const {
    const VectorXd precision = precisions();
    const Eigen::Map<const VectorXd> length(lengths_.data(), precision.size());
    MatrixXd a = curvature_;
    a.diagonal() += precision;
    a = (length.cwiseInverse().asDiagonal() * a * length.cwiseInverse().asDiagonal()).eval();
    a.diagonal().array() += 1e-12;
    const Eigen::LDLT<MatrixXd> factor(a);
    // The best values move a little when the priors change; those at the end of a range do not.
    VectorXd push = (force_ - precision.cwiseProduct(distance_)).cwiseQuotient(length);
    for (const Index i : held_) push[i] = 0;
    const double determinant =
        factor.vectorD().cwiseMax(1e-300).array().log().sum() + 2 * length.array().log().sum();
    double normalisation = 0;
    for (const double p : precision)
      if (p > 0) normalisation += std::log(p);
    const double gained =
        0.5 * push.dot(factor.solve(push)) - 0.5 * distance_.cwiseAbs2().dot(precision);
    return fixed_ + std::min(gained, most_gained_) + 0.5 * normalisation - 0.5 * determinant;
  }

  VectorXd information() const {
    VectorXd result = VectorXd::Zero(fit_.at.jacobian.cols());
    result(kept_) = precisions();
    hold_bounds(fit_, result);
    return result;
  }

 private:
  // At the best values the readings pull as much as the priors of the fit hold back. Of the two the
  // smaller, so that neither a fit that still moves is credited with where it might have gone, nor
  // a value that the readings do not see with what its prior would gain.
  void take_force(const VectorXd& of_priors, const VectorXd& of_readings) {
    force_ = of_priors.binaryExpr(of_readings, [](double a, double b) {
      return a * b > 0 ? std::copysign(std::min(std::abs(a), std::abs(b)), a) : 0;
    });
    // No values at all explain more than the part of the residual that is in their range.
    const Eigen::Map<const VectorXd> length(lengths_.data(), of_readings.size());
    MatrixXd a =
        length.cwiseInverse().asDiagonal() * curvature_ * length.cwiseInverse().asDiagonal();
    a.diagonal().array() += 1e-12;
    const VectorXd pull = of_readings.cwiseQuotient(length);
    most_gained_ = pull.size() == 0 ? 0 : 0.5 * pull.dot(Eigen::LDLT<MatrixXd>(a).solve(pull));
  }

  void add_parameter(const ParameterEstimate& estimate, Index i) {
    if (estimate.hit != BoundHit::none) held_.push_back(i);
    const auto& prior = estimate.parameter.prior;
    if (!prior) return;
    deviation_[i] = prior->deviation;
    distance_[i] = estimate.value - prior->mean;
    group_[static_cast<std::size_t>(i)] = prior->group;
    const Parameter& parameter = estimate.parameter;
    if (prior->group >= 0) {
      deviation_[i] /= prior->times;
      fitted_[i] = prior->times;
    }
    const double rounding = 1e-9 * prior->deviation;
    const auto is = [&](double value) { return std::abs(estimate.value - value) <= rounding; };
    // The range ends where the law has become another one, or absurd.
    if ((is(parameter.lower) || is(parameter.upper)) && !is(prior->mean)) fixed_ -= at_bound;
    // A range that ends where there is no effect holds all of the prior on one side, and of the
    // posterior the part that lies there: half where the value is at the end itself.
    const bool one_sided = prior->mean == parameter.lower || prior->mean == parameter.upper;
    if (one_sided && !is(prior->mean))
      fixed_ += estimate.hit == BoundHit::none
                    ? std::log(std::erfc(-std::abs(distance_[i] / estimate.standard_error) /
                                         std::numbers::sqrt2))
                    : std::numbers::ln2;
  }

  VectorXd precisions() const {
    return deviation_.binaryExpr(
        scales_, [](double d, double s) { return d > 0 ? 1 / (d * d * s * s) : 0; });
  }

  const BaseFit& fit_;
  std::vector<Index> kept_, held_;
  double fixed_;
  MatrixXd curvature_;
  VectorXd force_;                          // minus the gradient without priors
  double most_gained_ = 0;                  // by better values, whatever the priors
  VectorXd distance_, deviation_, scales_;  // from the mean, usual width, times which
  VectorXd fitted_;                         // times which it was fitted with
  std::vector<double> lengths_;
  std::vector<int> group_;
};

std::span<const double> scales(Sizes sizes) {
  static constexpr std::array<double, 14> all{300, 100,  30,   10,   3,    1,    0.3,
                                              0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4, 1e-4};
  return std::span(all).subspan(sizes == Sizes::usual ? 4 : 0);
}

}  // namespace

double log_mean_exp(const std::vector<double>& logs) {
  const double largest = *std::max_element(logs.begin(), logs.end());
  double sum = 0;
  for (const double x : logs) sum += std::exp(x - largest);
  return largest + std::log(sum / static_cast<double>(logs.size()));
}

double exponent_of(const BaseFit& fit) {
  const auto freedom = static_cast<double>(std::max<Index>(1, fit.degrees_of_freedom()));
  return std::min(1.0, freedom / std::max(fit.squared_error, 1e-300));
}

double penalised_error(const BaseFit& fit) {
  double sum = fit.squared_error;
  for (const ParameterEstimate& estimate : fit.parameters)
    if (const auto& prior = estimate.parameter.prior)
      sum += std::pow((estimate.value - prior->mean) / prior->deviation, 2);
  return sum;
}

// Groups hardly depend on one another's scale: each is averaged over beside the best of the others.
Evidence evidence(const BaseFit& fit, double exponent, Sizes sizes) {
  constexpr int rounds = 2;
  Posterior posterior(fit, exponent);
  const std::set<int> groups = posterior.groups();
  double averaging = 0;
  for (int round = 0; round < rounds; ++round) {
    averaging = 0;
    for (const int group : groups) {
      std::vector<double> logs;
      for (const double scale : scales(sizes)) {
        posterior.set_scale(group, scale);
        logs.push_back(posterior.log_evidence());
      }
      const auto best = std::max_element(logs.begin(), logs.end());
      posterior.set_scale(group, scales(sizes)[static_cast<std::size_t>(best - logs.begin())]);
      averaging += log_mean_exp(logs) - *best;
    }
  }
  return {posterior.log_evidence() + averaging, posterior.information()};
}

}  // namespace kinetostat::calibration

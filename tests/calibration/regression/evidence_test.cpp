#include "kinetostat/calibration/regression/evidence.h"

#include <array>
#include <cmath>
#include <cstdint>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <gtest/gtest.h>

#include "kinetostat/calibration/statistics/normal.h"

namespace kinetostat::calibration::evidence_test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Eigen::Index readings = 12;

VectorXd ramp() { return VectorXd::LinSpaced(readings, -1, 2); }
VectorXd measured(double slope) {
  VectorXd y = slope * ramp();
  for (Eigen::Index i = 0; i < readings; ++i) y[i] += 0.7 * std::sin(3.0 * double(i) + 1);
  return y;
}

// The fit of y = slope * x with unit noise, of which the slope is usually `usual`.
BaseFit fit_of(const VectorXd& y, const VectorXd& x, double usual, int group) {
  const double deviation = group < 0 ? usual : widest_prior * usual;
  const double slope = x.dot(y) / (x.squaredNorm() + 1 / (deviation * deviation));
  BaseFit fit;
  Parameter parameter{.name = "slope", .springs = {}, .stiffness = {}};
  parameter.prior = {0, deviation, group, group < 0 ? 1 : widest_prior};
  fit.parameters = {{parameter, slope}};
  fit.at = {slope * x - y, x};
  fit.squared_error = fit.at.residual.squaredNorm();
  fit.values = y.size();
  fit.estimated = 1;
  return fit;
}

// Log density of y, but for (2 pi)^(-n/2), with the slope integrated out.
double density(const VectorXd& y, double deviation) {
  const VectorXd x = ramp();
  const MatrixXd covariance =
      MatrixXd::Identity(readings, readings) + deviation * deviation * x * x.transpose();
  const Eigen::LLT<MatrixXd> factor(covariance);
  const MatrixXd l = factor.matrixL();
  return -0.5 * y.dot(factor.solve(y)) - l.diagonal().array().log().sum();
}

TEST(Evidence, IsTheDensityOfTheReadingsInALinearModel) {
  for (const double slope : {0.0, 0.4, 5.0}) {
    const VectorXd y = measured(slope);
    EXPECT_NEAR(evidence(fit_of(y, ramp(), 0.8, -1), 1).log, density(y, 0.8), 1e-9);
  }
}

TEST(Evidence, AveragesOverAnUnknownScale) {
  std::vector<double> scales{3, 1, 0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4, 1e-4};
  for (const Sizes sizes : {Sizes::usual, Sizes::any}) {
    if (sizes == Sizes::any) scales.insert(scales.begin(), {300, 100, 30, 10});
    for (const double slope : {0.0, 0.4, 5.0, 50.0}) {
      const VectorXd y = measured(slope);
      double sum = 0;
      for (const double scale : scales) sum += std::exp(density(y, scale * 0.8));
      EXPECT_NEAR(evidence(fit_of(y, ramp(), 0.8, 0), 1, sizes).log,
                  std::log(sum / double(scales.size())), 1e-9);
    }
  }
}

// A second value that no reading sees, far from its prior: it must not gain anything by a wider
// one.
TEST(Evidence, AValueThatReadingsDoNotSeeGainsNothing) {
  const VectorXd y = measured(0.4);
  BaseFit fit = fit_of(y, ramp(), 0.8, -1);
  const double alone = evidence(fit, 1, Sizes::any).log;
  for (const double far : {1.0, 10.0, 300.0}) {
    BaseFit with = fit;
    Parameter unseen{.name = "unseen", .springs = {}, .stiffness = {}};
    unseen.prior = {0, widest_prior * 1.0, 0, widest_prior};
    with.parameters.push_back({unseen, far});
    with.at.jacobian.conservativeResize(Eigen::NoChange, 2);
    with.at.jacobian.col(1).setZero();
    EXPECT_LE(evidence(with, 1, Sizes::any).log, alone + 1e-3) << far;
  }
}

// Whatever the priors and wherever the iteration stopped: half the least chi-square is the most.
TEST(Evidence, NeverExceedsTheBestFitOfTheReadings) {
  std::uint64_t state = 7;
  const auto random = [&state] {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return double(state >> 11) / double(1ull << 53) - 0.5;
  };
  for (int trial = 0; trial < 300; ++trial) {
    BaseFit fit;
    const Eigen::Index n = 1 + trial % 4;
    fit.at = {VectorXd::NullaryExpr(readings, [&] { return 40 * random(); }),
              MatrixXd::NullaryExpr(readings, n, [&] { return std::pow(10, 6 * random()); })};
    for (Eigen::Index k = 0; k < n; ++k) {
      Parameter p{.name = "p", .springs = {}, .stiffness = {}};
      p.prior = {0, std::pow(10, 4 * random()), trial % 3 == 0 ? -1 : int(k % 2)};
      fit.parameters.push_back({p, 10 * random()});
    }
    fit.squared_error = fit.at.residual.squaredNorm();
    fit.values = readings;
    const MatrixXd& j = fit.at.jacobian;
    const VectorXd best = j.colPivHouseholderQr().solve(fit.at.residual);
    const double least = (fit.at.residual - j * best).squaredNorm();
    for (const Sizes sizes : {Sizes::usual, Sizes::any})
      EXPECT_LE(evidence(fit, 0.7, sizes).log, -0.35 * least + double(n) * std::log(2.0) + 1e-3)
          << trial;
  }
}

// With a fixed width a guess that is thirty times too large would cost log(30) = 3.4. One that is
// thirty times too small is held to mean something: such an effect would be absurd.
TEST(Evidence, HardlyDependsOnTheUsualSizeUnlessTheEffectIsFarBeyondIt) {
  const VectorXd y = measured(3);
  const double right = evidence(fit_of(y, ramp(), 3, 0), 1).log;
  EXPECT_NEAR(evidence(fit_of(y, ramp(), 90, 0), 1).log, right, 0.3);
  EXPECT_NEAR(evidence(fit_of(y, ramp(), 1.5, 0), 1).log, right, 0.5);
  EXPECT_LT(evidence(fit_of(y, ramp(), 0.1, 0), 1).log, right - 10);
  EXPECT_GT(evidence(fit_of(y, ramp(), 3, -1), 1).log - evidence(fit_of(y, ramp(), 90, -1), 1).log,
            2.5);
}

TEST(Evidence, PriorsHaveTheScaleThatTheReadingsAskFor) {
  const VectorXd y = measured(5);
  const double deviation = 1 / std::sqrt(evidence(fit_of(y, ramp(), 500, 0), 1).information[0]);
  EXPECT_GT(deviation, 1.5);
  EXPECT_LT(deviation, 15);
}

// Two candidates that look alike, one of which is there, and noise 1.6 times as large as stated:
// the third trap. What is said to be right at 80 % must be right in 80 of 100 campaigns.
TEST(Evidence, IsAsOftenRightAsItSaysThoughTheNoiseIsLargerThanStated) {
  constexpr Eigen::Index n = 60;
  constexpr int campaigns = 2400;
  const auto random = [&](std::uint64_t seed) {
    Normal normal(seed);
    VectorXd x(n);
    for (double& value : x) value = normal();
    return x;
  };
  const VectorXd common = random(1);
  const std::array<VectorXd, 2> signatures = {common + 0.3 * random(2), common + 0.3 * random(3)};
  double stated = 0, right = 0, stated_unweighted = 0;
  for (std::uint64_t c = 0; c < campaigns; ++c) {
    const std::size_t truth = c % 2;
    const VectorXd y = signatures[truth] + 1.6 * random(100 + c);
    std::array<BaseFit, 2> fits;
    double exponent = 0;
    for (std::size_t k = 0; k < 2; ++k) {
      fits[k] = fit_of(y, signatures[k], 1, 0);
      exponent = std::max(exponent, exponent_of(fits[k]));
    }
    const double log_ratio = evidence(fits[1], exponent).log - evidence(fits[0], exponent).log;
    const double unweighted = evidence(fits[1], 1).log - evidence(fits[0], 1).log;
    stated += 1 / (1 + std::exp(-std::abs(log_ratio)));
    stated_unweighted += 1 / (1 + std::exp(-std::abs(unweighted)));
    right += (log_ratio > 0) == (truth == 1) ? 1 : 0;
  }
  // Four standard deviations of a binomial count.
  EXPECT_NEAR(stated / campaigns, right / campaigns, 4 * 0.5 / std::sqrt(campaigns));
  EXPECT_GT(stated_unweighted / campaigns, right / campaigns + 0.05);
}

}  // namespace
}  // namespace kinetostat::calibration::evidence_test

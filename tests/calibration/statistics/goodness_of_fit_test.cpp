#include "kinetostat/calibration/statistics/goodness_of_fit.h"

#include <cmath>

#include <gtest/gtest.h>

#include "kinetostat/calibration/statistics/normal.h"

namespace kinetostat::calibration::goodness_of_fit_test {
namespace {

// With two degrees of freedom the chance is exp(-x / 2).
TEST(ChiSquare, IsThatOfTheClosedForm) {
  for (const double x : {0.1, 1., 30., 1000.}) {
    const ChiSquareTest test = chi_square_test(x, 2);
    EXPECT_NEAR(test.p_value, std::exp(-x / 2), 1e-12 * std::exp(-x / 2));
    EXPECT_NEAR(test.lower_p_value, -std::expm1(-x / 2), 1e-12);
  }
}

// Thousands of readings that repeat each other to the last digit.
TEST(ChiSquare, ThatIsNothingAmongThousandsIsCertainlyTooSmall) {
  for (const double x : {0., 1e-30, 1e-8, 1.}) {
    const ChiSquareTest test = chi_square_test(x, 6000);
    EXPECT_EQ(test.p_value, 1);
    EXPECT_EQ(test.lower_p_value, 0);
  }
  EXPECT_EQ(chance_of_larger_chi_square(1e6, 6000), 0);
}

// A noise that comes from few repetitions is uncertain, and rejects sound models no more often.
TEST(Misfit, OverAnEstimatedNoiseRejectsAsOftenAsItSays) {
  Normal normal(3);
  const int trials = 4000, scatter_values = 8, others = 40;
  int rejected = 0, by_chi_square = 0;
  for (int trial = 0; trial < trials; ++trial) {
    double scatter = 0, rest = 0;
    for (int i = 0; i < scatter_values; ++i) scatter += std::pow(normal(), 2);
    for (int i = 0; i < others; ++i) rest += std::pow(normal(), 2);
    const double statistic = (scatter + rest) / (scatter / scatter_values);
    const int all = scatter_values + others;
    rejected += misfit_test(statistic, all, scatter_values).p_value < significance_level;
    by_chi_square += chi_square_test(statistic, all).p_value < significance_level;
  }
  const double spread = std::sqrt(significance_level * (1 - significance_level) * trials);
  EXPECT_NEAR(rejected, significance_level * trials, 4 * spread);
  EXPECT_GT(by_chi_square, 4 * significance_level * trials);
}

TEST(Misfit, OverAStatedNoiseIsThatOfChiSquare) {
  EXPECT_EQ(misfit_test(50, 30, 0).p_value, chi_square_test(50, 30).p_value);
  EXPECT_EQ(misfit_test(50, 30, 0).lower_p_value, chi_square_test(50, 30).lower_p_value);
}

}  // namespace
}  // namespace kinetostat::calibration::goodness_of_fit_test

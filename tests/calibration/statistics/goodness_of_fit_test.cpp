#include "kinetostat/calibration/statistics/goodness_of_fit.h"

#include <cmath>

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace kinetostat::calibration::goodness_of_fit_test

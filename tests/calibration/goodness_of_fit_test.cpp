#include "kinetostat/calibration/goodness_of_fit.h"

#include <cmath>

#include <gtest/gtest.h>

namespace kinetostat::calibration {
namespace {

// With two degrees of freedom above, the chance is (1 + 2 f / d)^(-d/2).
TEST(ChanceOfLargerF, IsThatOfTheClosedForm) {
  for (const double d : {1., 10., 400.})
    for (const double f : {0.1, 1., 7., 1e3}) {
      const double expected = std::pow(1 + 2 * f / d, -d / 2);
      EXPECT_NEAR(chance_of_larger_f(f, 2, d), expected, 1e-10 * expected + 1e-300);
    }
}

// Thousands of readings that repeat each other to the last digit.
TEST(ChanceOfLargerF, IsNoneWhereNoNumberIsThatSmall) {
  for (const double f : {1e3, 1e10, 1e25, 1e200}) EXPECT_EQ(chance_of_larger_f(f, 27, 3000), 0);
  EXPECT_GT(chance_of_larger_f(1e6, 27, 1), 1e-4);
}

}  // namespace
}  // namespace kinetostat::calibration

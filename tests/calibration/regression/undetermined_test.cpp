#include "kinetostat/calibration/regression/undetermined.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetostat::calibration::undetermined_test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

// Stiffnesses that are fitted to these multiples of their nominal values.
std::string said_of(const std::vector<double>& factors, double standard_error = 0.02) {
  std::vector<ParameterEstimate> estimates;
  for (const double factor : factors) {
    ParameterEstimate& estimate = estimates.emplace_back();
    estimate.parameter.springs.emplace_back();
    estimate.value = std::log(factor);
    estimate.standard_error = standard_error;
  }
  return common_factor(estimates);
}

TEST(CommonFactor, OfAllStiffnessesIsOneOfUnits) {
  EXPECT_THAT(said_of({2.1, 2.3}), HasSubstr("All 2 stiffnesses that these readings know are "
                                             "about 2.2 times"));
  EXPECT_THAT(said_of({2.1, 2.3}), HasSubstr("weights in lb taken for kg"));
  EXPECT_THAT(said_of({0.45, 0.46, 0.44}), HasSubstr("weights in kg taken for lb"));
  EXPECT_THAT(said_of({4.3, 4.6}), HasSubstr("forces in N taken for lbf"));
  EXPECT_THAT(said_of({3.1, 3.2}), testing::Not(HasSubstr("as of")));
}

TEST(CommonFactor, IsNotSaidOfSpringsThatAreSofterOrStiffer) {
  EXPECT_THAT(said_of({2.2}), IsEmpty());
  EXPECT_THAT(said_of({2.2, 1.1}), IsEmpty());
  EXPECT_THAT(said_of({1.4, 1.4}), IsEmpty());
  EXPECT_THAT(said_of({2.2, 2.2}, 0.5), IsEmpty());  // hardly known
}

}  // namespace
}  // namespace kinetostat::calibration::undetermined_test

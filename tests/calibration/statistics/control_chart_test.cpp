// Control charts against a published example and the chance of a false alarm.
#include "kinetostat/calibration/statistics/control_chart.h"

#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

namespace kinetostat::calibration::control_chart_test {
namespace {

// Montgomery, Introduction to Statistical Quality Control, 6th edition, example 6.5: costs of
// processing mortgage loans.
TEST(ControlChart, HasTheLimitsOfThePublishedExample) {
  const std::vector<double> costs{310, 288, 297, 298, 307, 303, 294, 297, 308, 306,
                                  294, 299, 297, 299, 314, 295, 293, 306, 301, 304};
  const ControlChart chart = individuals_chart(costs);
  EXPECT_NEAR(chart.mean, 300.5, 1e-12);
  EXPECT_NEAR(chart.mean_moving_range, 7.79, 0.005);
  EXPECT_NEAR(chart.upper, 321.22, 0.01);
  EXPECT_NEAR(chart.lower, 279.78, 0.01);
  EXPECT_TRUE(chart.outside.empty());
}

// 3 standard deviations either side of normal values: 0.27 %, and the deviation itself.
TEST(ControlChart, RaisesAFalseAlarmAsOftenAsItSays) {
  std::mt19937_64 engine(3);
  std::normal_distribution<double> normal(5, 2);
  std::vector<double> values(200'000);
  for (double& value : values) value = normal(engine);
  const ControlChart chart = individuals_chart(values, 20'000);
  EXPECT_NEAR(chart.deviation(), 2, 0.04);
  const double share = double(chart.outside.size()) / double(values.size());
  EXPECT_NEAR(share, 0.0027, 0.0006);
}

TEST(ControlChart, OfABaselineDoesNotWidenByWhatComesLater) {
  const std::vector<double> values{1, 2, 1, 2, 1, 2, 6};
  EXPECT_TRUE(individuals_chart(values).outside.empty());  // 6 has widened its own limits
  const ControlChart chart = individuals_chart(values, 6);
  EXPECT_DOUBLE_EQ(chart.mean, 1.5);
  EXPECT_DOUBLE_EQ(chart.upper, 1.5 + 2.66);
  EXPECT_EQ(chart.outside, (std::vector<std::size_t>{6}));
  EXPECT_EQ(individuals_chart(values, 99).upper, individuals_chart(values).upper);
  EXPECT_THROW(individuals_chart({1}), std::invalid_argument);
  EXPECT_THROW(individuals_chart({1, 2}, 1), std::invalid_argument);
}

// The mean of eight times 0.9 is another number than that.
TEST(ControlChart, OfEqualValuesHasNoneOutside) {
  for (const double value : {0.9, 0.9018, -1e-9 / 3, 1e12 / 7}) {
    EXPECT_TRUE(individuals_chart(std::vector<double>(8, value)).outside.empty());
    std::vector<double> values(9, value);
    values[5] *= 1.001;
    EXPECT_EQ(individuals_chart(values, 4).outside, (std::vector<std::size_t>{5}));
  }
}

}  // namespace
}  // namespace kinetostat::calibration::control_chart_test

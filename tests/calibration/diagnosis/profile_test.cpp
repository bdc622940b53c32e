#include "kinetostat/calibration/diagnosis/profile.h"

#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/campaign/noise_estimate.h"

#include "calibration/synthetic.h"

namespace kinetostat::calibration::profile_test {
namespace {

constexpr double sigma = 2e-6;  // [m]
const std::vector<double> loads = {-300, -150, 0, 100, 200, 400, 50, -250};

// A spring of 0.8 N/um read with an offset, a gap and what looks like noise.
Campaign campaign(double gap) {
  const vjm::Robot robot = test::bench();
  std::string csv = "fz,dz\n";
  int k = 0;
  for (const double f : loads) {
    const double moved = f / 0.8e6 + 3e-6 + (f > 0 ? 0.5 : f < 0 ? -0.5 : 0) * gap;
    csv += fmt::format("{},{:.9f}\n", f, 1e3 * (moved + sigma * std::sin(1.0 + 2.3 * ++k)));
  }
  return read_campaign(test::write_campaign("kinetostat: 1\ncampaign: spring\n"
                                            "units: {length: mm, force: N}\nzero: estimate\n"
                                            "displacement: difference\nwrench_point: reference\n"
                                            "noise: {translation: 2 um}\nreadings: readings.csv\n",
                                            csv),
                       robot.manipulator);
}

// With the compliance u = exp(-q) / k in the place of the logarithm q it is a straight line through
// the readings, whose zero is fitted, too: the rise is sum((F - mean F)^2) (u - best)^2 / sigma^2.
TEST(Profile, OfOneSpringAndItsZeroOffsetIsThatOfAStraightLine) {
  const vjm::Robot robot = test::bench();
  const Campaign read = campaign(0);
  const Noise noise = noise_of(read, {});
  common::Progress silent;
  const CandidateFitter fitter(robot, read, noise, 1, silent);
  const BaseFit best = fitter.fit({}, nullptr, silent);
  const std::vector<Profile> found = profiles(fitter, {}, best, 5, silent);
  ASSERT_EQ(found.size(), 1u);
  double mean = 0, squares = 0;
  for (const double f : loads) mean += f / static_cast<double>(loads.size());
  for (const double f : loads) squares += (f - mean) * (f - mean);
  const auto compliance = [](double q) { return std::exp(-q) / 1e6; };
  const double at_best = compliance(found[0].estimate.value);
  EXPECT_EQ(found[0].points.size(), 13u);
  for (const ProfilePoint& point : found[0].points)
    EXPECT_NEAR(point.rise, squares * std::pow((compliance(point.value) - at_best) / sigma, 2),
                1e-6 * (1 + point.rise));
  const double half = 1.959964 * sigma / std::sqrt(squares);  // of the compliance
  EXPECT_NEAR(compliance(found[0].interval[0].value()), at_best + half, 2e-3 * half);
  EXPECT_NEAR(compliance(found[0].interval[1].value()), at_best - half, 2e-3 * half);
  EXPECT_EQ(found[0].ended, "");
}

TEST(Profile, EndsWhereTheRangeOfAValueEnds) {
  const vjm::Robot robot = test::bench();
  const Campaign read = campaign(5e-6);
  const Noise noise = noise_of(read, {});
  common::Progress silent;
  const CandidateFitter fitter(robot, read, noise, 1, silent);
  std::vector<Candidate> gap = candidates(robot, {"clearance"});
  gap.resize(1);
  gap[0].effect.values[0] = 5e-6;
  const BaseFit best = fitter.fit(gap, nullptr, silent);
  const std::vector<Profile> found = profiles(fitter, gap, best, 1, silent);
  ASSERT_EQ(found.size(), 1u);  // the value of the effect comes first
  const ParameterEstimate& estimate = found[0].estimate;
  ASSERT_LT(estimate.value, 3 * estimate.standard_error);
  EXPECT_EQ(found[0].points.front().value, 0);
  EXPECT_GT(found[0].points.back().value, estimate.value + 2.9 * estimate.standard_error);
  EXPECT_EQ(found[0].ended, "its range ends");
  for (const ProfilePoint& point : found[0].points) EXPECT_GE(point.rise, -1e-6);
}

}  // namespace
}  // namespace kinetostat::calibration::profile_test

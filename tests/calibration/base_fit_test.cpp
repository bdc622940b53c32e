#include "kinetostat/calibration/base_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/files/error.h"

#include "calibration/synthetic.h"

namespace kinetostat::calibration {
namespace {

using testing::HasSubstr;

std::filesystem::path bench_campaign(const std::string& csv, const std::string& more = "") {
  return test::write_campaign(
      "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N, angle: rad}\n"
      "displacement: difference\nreadings: readings.csv\n" +
          more,
      csv);
}

double factor(const Comparison& comparison, std::size_t parameter) {
  return std::exp(comparison.refitted.value().fit.parameters.at(parameter).log_factor);
}

class Recovery : public testing::TestWithParam<std::vector<double>> {};

TEST_P(Recovery, FindsKnownStiffnessesWithoutNoise) {
  const vjm::Robot designed = test::orthoglide();
  std::vector<test::Planned> plan = test::orthoglide_plan(4, 3, 1);
  test::measure(test::scaled(designed, GetParam()).manipulator, plan);
  const auto file = test::write(plan, {.more = "noise: {translation: 10 um, rotation: 20 urad}\n"});
  const Comparison c = test::compare_files(designed, file);
  for (std::size_t i = 0; i < GetParam().size(); ++i)
    EXPECT_NEAR(factor(c, i) / GetParam()[i], 1, 1e-8);
}

INSTANTIATE_TEST_SUITE_P(Factors, Recovery,
                         testing::Values(std::vector<double>{1, 1}, std::vector<double>{0.7, 1.6},
                                         std::vector<double>{3, 0.3},
                                         std::vector<double>{0.5, 0.02}));

TEST(BaseFit, FindsStiffnessesFarFromTheDesignedOnes) {
  for (const double true_factor : {0.01, 100.0}) {
    const auto file =
        bench_campaign(fmt::format("fz,dz\n1000,{}\n2000,{}\n", 1 / true_factor, 2 / true_factor));
    EXPECT_NEAR(factor(test::compare_files(test::bench(), file), 0), true_factor,
                1e-8 * true_factor);
  }
}

// Readings F/k + zero of the session, with deviations known in closed form.
TEST(BaseFit, EstimatesOneZeroPerSession) {
  const auto file = bench_campaign("session,fz,dz\na,1000,3\na,2000,4\nb,1000,-4\nb,3000,-2\n",
                                   "zero: estimate\n");
  const Comparison c = test::compare_files(test::bench(2e6), file);
  const BaseFit& fit = c.refitted->fit;
  EXPECT_NEAR(factor(c, 0), 0.5, 1e-10);
  ASSERT_EQ(fit.zeros.size(), 2u);
  EXPECT_NEAR(fit.zeros[0].value, 2e-3, 1e-12);
  EXPECT_NEAR(fit.zeros[1].value, -5e-3, 1e-12);
  EXPECT_EQ(fit.degrees_of_freedom(), 1);
}

TEST(BaseFit, StandardErrorsFollowFromTheStatedNoise) {
  const auto file =
      bench_campaign("fz,dz\n1000,1.001\n2000,1.999\n-1000,-1\n", "noise: {translation: 2 um}\n");
  const BaseFit fit = test::compare_files(test::bench(), file).refitted->fit;
  // dz = F/k: sd(1/k) = sigma / |F|, and d(1/k)/(1/k) = -d(log k).
  const double f = std::sqrt(6e6), k = 1e6 * std::exp(fit.parameters[0].log_factor);
  EXPECT_NEAR(fit.parameters[0].standard_error, 2e-6 * k / f, 1e-9 * 2e-6 * k / f);
}

TEST(BaseFit, PreciseReadingsCountMore) {
  const auto file = bench_campaign("fz,dz,sigma\n1000,1.0,0.001\n1000,1.1,0.1\n");
  const Comparison c = test::compare_files(test::bench(), file);
  const double expected = (1.0 * 1e6 + 1.1 * 1e2) / (1e6 + 1e2);
  EXPECT_NEAR(1 / factor(c, 0), expected, 1e-10);
}

template <class Error>
std::string message(const vjm::Robot& robot, const std::filesystem::path& file) {
  try {
    const Comparison comparison = test::compare_files(robot, file);
    if (!comparison.refit_failure.empty()) return comparison.refit_failure;
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(BaseFit, SaysWhichStiffnessNoReadingDependsOn) {
  const auto file = bench_campaign("fz,dz\n0,0.1\n0,0.2\n");
  EXPECT_THAT(message<files::NotIdentifiable>(test::bench(), file),
              HasSubstr("no reading depends on the stiffness of 'spring'"));
}

TEST(BaseFit, SaysWhichUnknownsCannotBeToldApart) {
  vjm::Robot robot = test::bench();
  vjm::Chain chain("cell");
  chain.actuator("spring", vjm::Motion::tz, 1e6).actuator("screw", vjm::Motion::tz, 2e6);
  robot.manipulator = vjm::Manipulator("bench", {chain});
  robot.uncertain.push_back({"screw", {{0, "screw"}}});
  const auto file = bench_campaign("fz,dz\n1000,1\n2000,2\n3000,3\n");
  EXPECT_THAT(
      message<files::NotIdentifiable>(robot, file),
      HasSubstr("cannot tell the stiffness of 'spring' and the stiffness of 'screw' apart"));
  const auto one_load = bench_campaign("fz,dz\n1000,1\n1000,2\n1000,3\n", "zero: estimate\n");
  EXPECT_THAT(message<files::NotIdentifiable>(test::bench(), one_load),
              HasSubstr("cannot tell the stiffness of 'spring' and the zero of dz apart"));
}

TEST(BaseFit, SaysWhenThereAreTooFewValues) {
  EXPECT_THAT(message<files::NotIdentifiable>(test::bench(), bench_campaign("fz,dz\n1000,1\n")),
              HasSubstr("1 measured values for 1 unknowns"));
}

TEST(BaseFit, SaysWhenTheReadingsContradictAnySpring) {
  const auto file = bench_campaign("fz,dz\n1000,-1\n2000,-2\n");
  EXPECT_THAT(message<files::NotIdentifiable>(test::bench(), file),
              HasSubstr("the stiffness of 'spring' runs away to infinity"));
}

TEST(BaseFit, DoesNotMixMillimetresWithRadians) {
  vjm::Robot robot = test::bench();
  vjm::Chain chain("cell");
  chain.actuator("spring", vjm::Motion::tz, 1e6).actuator("twist", vjm::Motion::rz, 1e3);
  robot.manipulator = vjm::Manipulator("bench", {chain});
  const std::string csv = "fz,mz,dz,rz\n1000,1000,1,1e-3\n2000,2000,2,2e-3\n";
  EXPECT_THAT(message<files::InputError>(robot, bench_campaign(csv, "wrench_point: reference\n")),
              HasSubstr("noise: translations and rotations cannot be fitted together"));
  const auto stated = bench_campaign(
      csv, "wrench_point: reference\nnoise: {translation: 1 um, rotation: 1 urad}\n");
  EXPECT_NEAR(factor(test::compare_files(robot, stated), 0), 1, 1e-9);
}

}  // namespace
}  // namespace kinetostat::calibration

// Poses, in which nothing need change at one configuration: sizes are counted in what a model does
// not predict.
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "kinetostat/report/screen/diagnosis.h"

#include "calibration/two_links.h"

namespace kinetostat::calibration::poses_test {
namespace {

class Poses : public testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Seeds, Poses, testing::Range(1u, 7u));

// Sixty, one a minute, of an arm that yields by little beside its noise.
class Bench : public test::TwoLinks {
 public:
  explicit Bench(unsigned seed) : TwoLinks(seed) {
    options().displacement = DisplacementKind::absolute;
    options().translation_noise = 2e-5;
  }
  Campaign measured() {
    std::string csv = "id,session,time,q1,q2,fx\n";
    for (int r = 0; r < 60; ++r)
      csv += fmt::format("r{},am,{},{},{},{}\n", r, 60 * r, 1.5 * std::sin(0.9 * r),
                         1 + std::cos(1.3 * r), r % 2 == 0 ? 0 : 0.5);
    return measure(csv);
  }
  /// The only effect that is found; else all that is said.
  std::string only_one() {
    const Campaign campaign = measured();
    const Diagnosis d = diagnose(campaign, {});
    return d.verdict == Verdict::identified && d.found.size() == 1
               ? d.found[0].candidate.name()
               : report::text(robot(), campaign, d);
  }
};

TEST_P(Poses, NameAnEccentricDrive) {
  for (const char* joint : {"q1", "q2"}) {
    Bench bench(GetParam());
    bench.hide("eccentricity", joint, "cosine=3e-4 rad,sine=-1e-4 rad");
    EXPECT_EQ(bench.only_one(), fmt::format("eccentricity at arm.{}", joint));
  }
}

// A displaced frame leaves nothing that looks like a drift: its law idealises nothing.
TEST_P(Poses, NameWhatIsSmallBesideAnExactLaw) {
  Bench bench(GetParam());
  bench.hide("sensor_frame", "sensor", "x=1e-3 m,y=-5e-4 m");
  bench.hide("session_drift", "sensor", "x=2.5e-8 m/s");
  const Campaign campaign = bench.measured();
  const Diagnosis d = bench.diagnose(campaign, {});
  const std::string said = report::text(bench.robot(), campaign, d);
  ASSERT_EQ(d.found.size(), 2u) << said;
  EXPECT_EQ(d.found[1].candidate.name(), "session_drift at sensor") << said;
}

// An ellipse out of centre: the second order is as little a part of what is wrong with the first as
// two sines are alike.
TEST_P(Poses, NameEachOrderOfADrive) {
  Bench bench(GetParam());
  bench.hide("eccentricity", "q1", "cosine=3e-4 rad,sine=-1e-4 rad");
  bench.hide("eccentricity", "q1", "cosine=6e-5 rad,sine=3e-5 rad,order=2");
  const Campaign campaign = bench.measured();
  const Diagnosis d = bench.diagnose(campaign, {});
  const std::string said = report::first_screen(bench.robot(), campaign, d, "");
  ASSERT_EQ(d.found.size(), 2u) << said;
  std::vector<double> orders;
  for (const FoundEffect& found : d.found) {
    EXPECT_EQ(found.candidate.name(), "eccentricity at arm.q1");
    orders.push_back(found.candidate.effect.values[2]);
  }
  EXPECT_EQ(orders, (std::vector<double>{1, 2}));
  EXPECT_NE(said.find("+ eccentricity at joint q1 (order 2)"), std::string::npos) << said;
}

// What a balancer could be as well, and no reading of the target distinguishes from it.
TEST_P(Poses, NameEachOrderOfADriveThatLifts) {
  test::TwoLinksThatLift bench(GetParam(), 5e-6);
  bench.options().displacement = DisplacementKind::absolute;
  bench.hide("eccentricity", "q2", "cosine=3e-4 rad,sine=-1e-4 rad");
  bench.hide("eccentricity", "q2", "cosine=-2e-5 rad,sine=7e-5 rad,order=2");
  std::string csv = "id,session,time,q1,q2,fx\n";
  for (int r = 0; r < 60; ++r)
    csv += fmt::format("r{},am,{},{},{},{}\n", r, 60 * r, 1.5 * std::sin(0.9 * r),
                       1.5 * std::cos(1.3 * r), r % 2 == 0 ? 0 : 0.5);
  const Campaign campaign = bench.measure(csv);
  const Diagnosis d = bench.diagnose(campaign, {});
  const std::string said = report::first_screen(bench.robot(), campaign, d, "");
  ASSERT_EQ(d.found.size(), 2u) << said;
  for (const FoundEffect& found : d.found)
    EXPECT_EQ(found.candidate.name(), "eccentricity at arm.q2") << said;
  EXPECT_NE(d.found[0].decision.answers[0].effect_class.find("weight"), std::string::npos) << said;
}

// By a law of this test: a screw that grows carries its nut farther the farther out that is.
TEST_P(Poses, NameAScrewThatGrows) {
  test::Laboratory bench(
      "kinetostat: 1\nname: two slides\nunits: {length: mm, force: N, temperature: degC}\n"
      "chain_types:\n  arm:\n"
      "    - actuator: {name: x, axis: Tx, stiffness: 2.0e7 N/m}\n"
      "    - actuator: {name: z, axis: Tz, stiffness: 3.0e7 N/m}\n"
      "manipulator: {chain: arm}\nuncertain:\n  - {stiffness: x}\n  - {stiffness: z}\n");
  bench.options().components = {true, false, true, false, false, false};
  bench.options().displacement = DisplacementKind::absolute;
  bench.options().translation_noise = 2e-6;
  bench.options().seed = GetParam();
  std::string csv = "id,session,time,temperature,arm.x,arm.z,fx,fz\n";
  for (int r = 0; r < 60; ++r)
    csv += fmt::format("r{},am,{},{},{},{},{},{}\n", r, 60 * r, 22 + 3 * std::sin(0.17 * r),
                       400 * std::sin(0.9 * r), 200 * std::cos(1.3 * r), r % 2 == 0 ? 0 : 90,
                       r % 3 == 0 ? 0 : -120);
  Campaign campaign = bench.measure(csv);
  constexpr double alpha = 1.2e-5;
  for (Reading& reading : campaign.readings) {
    const double x = campaign.configurations[reading.configuration].joints.at("arm.x");
    reading.displacement[0] += alpha * (*reading.temperature - 20) * x;
  }
  const Diagnosis d = bench.diagnose(campaign, {});
  const std::string said = report::first_screen(bench.robot(), campaign, d, "");
  ASSERT_EQ(d.found.size(), 1u) << said;
  EXPECT_EQ(d.found[0].candidate.name(), "thermal_expansion at arm.x") << said;
  EXPECT_NEAR(d.found[0].candidate.effect.values[0], alpha, 4 * d.found[0].deviations[0]);
}

// By a law that the catalogue lacks: what the robot stands on turns with the temperature. Errors of
// all joints together follow what that is on average, and are not what is to be calibrated.
TEST_P(Poses, AreNotCalibratedWhereTheErrorFollowsTheTemperature) {
  Bench bench(GetParam());
  std::string csv = "id,session,time,temperature,q1,q2,fx\n";
  for (int r = 0; r < 60; ++r)
    csv += fmt::format("r{},am,{},{},{},{},{}\n", r, 60 * r, 24 + 4 * std::sin(0.17 * r),
                       1.5 * std::sin(0.9 * r), 1 + std::cos(1.3 * r), r % 2 == 0 ? 0 : 0.5);
  Campaign campaign = bench.measure(csv);
  for (Reading& reading : campaign.readings) {
    const auto& joints = campaign.configurations[reading.configuration].joints;
    const double q1 = joints.at("arm.q1"), q12 = q1 + joints.at("arm.q2");
    const double turn = 6e-5 * (*reading.temperature - 20);
    reading.displacement[0] -= turn * (0.5 * std::sin(q1) + 0.4 * std::sin(q12));
    reading.displacement[1] += turn * (0.5 * std::cos(q1) + 0.4 * std::cos(q12));
  }
  const Diagnosis d = bench.diagnose(campaign, {});
  EXPECT_FALSE(d.by_kinematics) << report::first_screen(bench.robot(), campaign, d, "");
}

TEST_P(Poses, NameADrift) {
  Bench bench(GetParam());
  bench.hide("session_drift", "sensor", "x=3e-8 m/s,y=-2e-8 m/s");
  EXPECT_EQ(bench.only_one(), "session_drift at sensor");
}

}  // namespace
}  // namespace kinetostat::calibration::poses_test

// What the rounds of a diagnosis keep, and where they start again.
#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/two_links.h"

namespace kinetostat::calibration::growth_test {
namespace {

class Lifter : public test::TwoLinksThatLift {
 public:
  explicit Lifter(unsigned seed) : TwoLinksThatLift(seed, 1e-5) {}
  std::string said(const Campaign& campaign, const Diagnosis& d) const {
    return report::text(robot(), campaign, d);
  }
};

std::vector<std::string> names(const Diagnosis& d) {
  std::vector<std::string> result;
  for (const FoundEffect& found : d.found) result.push_back(found.candidate.name());
  return result;
}

std::string postures(int r) {
  return fmt::format("{:.4f},{:.4f}", 0.9 * std::sin(0.9 * r), 0.7 + 0.9 * std::cos(1.3 * r));
}

class Growth : public testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Seeds, Growth, testing::Range(1u, 4u));

// No value of a balancer is known by itself, all of them together are: it is no effect without
// size, and what was found beside it is as likely as it is beside it.
TEST_P(Growth, KeepsWhatOnlyAllItsValuesDetermine) {
  Lifter lifter(GetParam());
  lifter.options().displacement = DisplacementKind::absolute;
  lifter.hide("payload", "platform", "mass=3 kg");
  lifter.hide("gravity_compensator", "q1",
              "stiffness=4 N/mm,arm=60 mm,distance=300 mm,free_length=250 mm");
  std::string csv = "id,q1,q2,fx,fz\n";
  for (int r = 0; r < 60; ++r)
    csv +=
        fmt::format("r{},{},{},{}\n", r, postures(r), r % 3 == 1 ? 200 : 0, r % 3 == 2 ? -300 : 0);
  const Campaign campaign = lifter.measure(csv);
  const Diagnosis d = lifter.diagnose(campaign, {});
  EXPECT_EQ(d.verdict, Verdict::identified) << lifter.said(campaign, d);
  EXPECT_THAT(names(d), testing::Contains("payload at platform")) << lifter.said(campaign, d);
  EXPECT_EQ(d.found.size(), 2u) << lifter.said(campaign, d);
  EXPECT_LT(d.after->reduced(), 1.5);
}

// An error of the geometry looks like weight and a scale of the instrument together, and like
// neither of them; the first round takes it.
TEST_P(Growth, TakesTwoEffectsInPlaceOfOneThatLooksLikeBoth) {
  for (const double times : {1, 2}) {
    Lifter lifter(GetParam());
    lifter.options().displacement = DisplacementKind::absolute;
    lifter.hide("payload", "platform", fmt::format("mass={} kg", 0.48 * times));
    lifter.hide("sensor_scale", "sensor", fmt::format("scale={}", 6e-5 * times));
    std::string csv = "id,q1,q2,fx,fz\n";
    for (int r = 0; r < 40; ++r)
      csv += fmt::format("r{},{},{},{}\n", r, postures(r), r % 3 == 1 ? 200 : 0,
                         r % 3 == 2 ? -300 : 0);
    const Campaign campaign = lifter.measure(csv);
    const Diagnosis d = lifter.diagnose(campaign, {});
    EXPECT_EQ(d.verdict, Verdict::identified) << lifter.said(campaign, d);
    EXPECT_THAT(names(d),
                testing::UnorderedElementsAre("payload at platform", "sensor_scale at sensor"))
        << lifter.said(campaign, d);
  }
}

// It stands where another effect explains what it leaves, else it would be what no effect explains.
TEST_P(Growth, TakesAnUnusualSizeBesideAnotherEffect) {
  Lifter lifter(GetParam());
  lifter.hide("hardening", "q1", "k3=1e13 N m/rad^3");
  lifter.hide("friction", "q2", "force=3 N m,presliding=1e-5 rad");
  std::string csv = "id,cycle,step,q1,q2,fx,fz\n";
  int n = 0;
  for (int run = 0; run < 6; ++run)
    for (const int load :
         {0, 150, 300, 450, 600, 450, 300, 150, 0, -150, -300, -450, -600, -450, -300, -150, 0}) {
      ++n;
      csv += fmt::format("a{0},{1},{0},{2},{3},{4}\n", n, run + 1, postures(run),
                         run % 2 == 1 ? load : 0, run % 2 == 0 ? load : 0);
    }
  const Campaign campaign = lifter.measure(csv);
  const Diagnosis d = lifter.diagnose(campaign, {});
  EXPECT_NE(d.verdict, Verdict::unexplained) << lifter.said(campaign, d);
  EXPECT_THAT(names(d), testing::Contains("friction at arm.q2")) << lifter.said(campaign, d);
  const auto is_curve = [](const FoundEffect& found) {
    return family_of(*found.candidate.effect.kind) == "load-deflection curve" &&
           found.candidate.effect.at == "arm.q1";
  };
  EXPECT_TRUE(std::any_of(d.found.begin(), d.found.end(), is_curve)) << lifter.said(campaign, d);
}

}  // namespace
}  // namespace kinetostat::calibration::growth_test

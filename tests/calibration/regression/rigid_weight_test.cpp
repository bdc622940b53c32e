// Weight that the commonest model of an arm, elastic joints and rigid links, does not know of.
#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/laboratory.h"

namespace kinetostat::calibration::rigid_weight_test {
namespace {

using test::Laboratory;

// Six axes; `mass` of its links.
std::string six_axis(bool masses) {
  const auto link = [&](const char* name, const char* end, const char* mass) {
    return std::string("  ") + name + ": {rigid: " + end +
           (masses ? std::string(", mass: ") + mass : "") + "}\n";
  };
  return "kinetostat: 1\nname: arm\nunits: {length: mm, force: N, angle: deg}\n"
         "gravity: {direction: [0, 0, -1]}\nlinks:\n" +
         link("link1", "[350, 0, 675]", "{mass: 400 kg, center: [100, 0, 300]}") +
         link("link2", "[0, 0, 1150]", "{mass: 200 kg, center: [0, 50, 500]}") +
         link("link3", "[250, 0, -41]", "{mass: 150 kg, center: [100, 0, 0]}") +
         link("link4", "[950, 0, 0]", "{mass: 80 kg, center: [300, 0, 20]}") +
         link("link5", "[240, 0, 0]", "{mass: 30 kg, center: [80, 0, 0]}") +
         "chain_types:\n  arm:\n"
         "    - actuator: {name: q1, axis: Rz, stiffness: 3.0e6 N m/rad}\n    - link: link1\n"
         "    - actuator: {name: q2, axis: Ry, stiffness: 3.3e6 N m/rad}\n    - link: link2\n"
         "    - actuator: {name: q3, axis: Ry, stiffness: 2.5e6 N m/rad}\n    - link: link3\n"
         "    - actuator: {name: q4, axis: Rx, stiffness: 3.3e5 N m/rad}\n    - link: link4\n"
         "    - actuator: {name: q5, axis: Ry, stiffness: 3.0e5 N m/rad}\n"
         "    - actuator: {name: q6, axis: Rx, stiffness: 4.2e5 N m/rad}\n    - link: link5\n"
         "    - tool: [0, 0, -120]\n"
         "manipulator: {chain: arm}\n";
}

// Poses all over the workspace, with and without a load.
std::string plan() {
  std::string text = "id,q1,q2,q3,q4,q5,q6,fx,fy,fz\n";
  int id = 0;
  for (const char* joints :
       {"0,-20,40,0,30,0", "40,10,60,30,-40,20", "-50,-40,10,-60,50,90", "90,30,-20,90,20,-45",
        "-120,0,90,45,-70,10", "20,-60,80,120,60,-90", "150,45,-45,-30,80,30",
        "-20,20,20,-90,-20,0", "60,-30,-30,60,40,60", "-80,60,30,15,-60,-20"})
    for (const char* force : {"0,0,0", "500,0,0", "0,500,0", "0,0,-1000"})
      text += "p" + std::to_string(++id) + "," + joints + "," + force + "\n";
  return text;
}

TEST(RigidWeight, TwelveKilogramsTooMuchOnLinkFourAreFound) {
  Laboratory laboratory(six_axis(true));
  laboratory.options().displacement = DisplacementKind::absolute;
  laboratory.options().components = {true, true, true, false, false, false};
  laboratory.options().translation_noise = 5e-6;
  laboratory.hide("self_weight", "link4", "mass=12 kg");
  const Diagnosis d = laboratory.diagnose(
      laboratory.measure(plan()),
      {"self_weight", "payload", "joint_compliance", "gravity_compensator", "preload"});
  EXPECT_THAT(d.without_place, testing::IsEmpty());
  ASSERT_FALSE(d.found.empty());
  const FoundEffect& found = d.found.front();
  EXPECT_EQ(found.candidate.name(), "self_weight at arm.link4");
  EXPECT_NEAR(found.candidate.effect.values[0], 12, 0.5);
  // It fits best of all that were fitted.
  for (const RankedCandidate& ranked : d.steps.front().ranking)
    if (ranked.fit) {
      EXPECT_LE(d.steps.front().ranking.front().fit->squared_error,
                ranked.fit->squared_error * (1 + 1e-9))
          << ranked.candidate.name();
    }
}

// Rigid links without a mass: nothing says where they are heavy, and that is said.
TEST(RigidWeight, WhereNothingHasAMassThatIsTheReason) {
  Laboratory laboratory(six_axis(false));
  laboratory.options().translation_noise = 5e-6;
  const Campaign campaign = laboratory.measure(plan());
  const Diagnosis d = laboratory.diagnose(campaign, {"self_weight", "payload"});
  ASSERT_EQ(d.without_place.size(), 1u);
  EXPECT_EQ(d.without_place[0].name, "self_weight");
  const std::vector<UnseenKind> unseen = unseen_kinds(d);
  const auto weight = std::find_if(unseen.begin(), unseen.end(), [](const UnseenKind& kind) {
    return kind.name == "self_weight";
  });
  ASSERT_NE(weight, unseen.end());
  EXPECT_THAT(weight->reason, testing::HasSubstr("'mass'"));
  EXPECT_THAT(report::text(laboratory.robot(), campaign, d),
              testing::HasSubstr("not observable, because no link of the robot file yields or has "
                                 "a 'mass': self_weight"));
  const io::Json json = laboratory.json(campaign, d);
  EXPECT_THAT(json["not_shown"].dump(), testing::HasSubstr("has a 'mass'"));
}

}  // namespace
}  // namespace kinetostat::calibration::rigid_weight_test

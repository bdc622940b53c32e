// What the first screen of a diagnosis says of what was found.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/report/screen/diagnosis.h"

#include "calibration/laboratory.h"
#include "calibration/load_loops.h"

namespace kinetostat::calibration::first_screen_test {
namespace {

using test::Laboratory;
using test::loops;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

std::string robot_of(const std::string& joint) {
  return "kinetostat: 1\nname: one joint\nunits: {length: mm, force: N, angle: rad}\n"
         "chain_types:\n  cell:\n    - actuator: {name: q, " +
         joint +
         "}\n    - tool: [400, 0, 0]\n"
         "manipulator: {chain: cell}\nuncertain:\n  - {stiffness: q}\n";
}

std::string said_of(const Laboratory& laboratory, const Campaign& campaign,
                    const std::vector<std::string>& kinds) {
  return report::first_screen(laboratory.robot(), campaign, laboratory.diagnose(campaign, kinds),
                              "");
}

// A ripple along a slide has a pitch, not 314 waves a metre.
TEST(FirstScreen, SaysThePitchOfARipple) {
  Laboratory laboratory(robot_of("axis: Tz, stiffness: 1000"));
  laboratory.options().displacement = DisplacementKind::absolute;
  laboratory.hide("eccentricity", "q", "cosine=20 um,sine=10 um,order=314.159265 m^-1 rad");
  std::string csv = "id,q,fz\n";
  for (int r = 0; r < 40; ++r)
    csv += fmt::format("r{},{},{}\n", r, 1.7 * ((r * 7) % 40), r % 2 == 0 ? 0 : 300);
  const std::string said = said_of(laboratory, laboratory.measure(csv), {"eccentricity"});
  EXPECT_THAT(said, HasSubstr("pitch 20 mm"));
  EXPECT_THAT(said, Not(HasSubstr("order")));
}

// What turns a joint is a torque, whatever the value is called in files.
TEST(FirstScreen, CallsATorqueATorque) {
  Laboratory laboratory(robot_of("axis: Ry, stiffness: 8.0e4 N m/rad"));
  laboratory.hide("friction", "q", "force=25 N m,presliding=0.0002 rad,gradual=1");
  const std::string said = said_of(laboratory, laboratory.measure(loops(4)), {"friction"});
  EXPECT_THAT(said, ContainsRegex("torque 2[0-9.]+ \\+- [0-9.]+ N m"));
  EXPECT_THAT(said, Not(HasSubstr("force")));
}

// A creep is as much as it is fast.
TEST(FirstScreen, SaysHowFastACreepIs) {
  Laboratory laboratory(robot_of("axis: Tz, stiffness: 1000"));
  laboratory.hide("creep", "q", "c=0.0002 mm/N,tau=200 s");
  const std::string said = said_of(laboratory, laboratory.measure(loops(4)), {"creep"});
  EXPECT_THAT(said, ContainsRegex("tau (19[0-9]|20[0-9])"));
}

// That something is identified does not mean that nothing else is there.
TEST(FirstScreen, SaysWhatIsLeftBeyondTheStatedNoise) {
  Laboratory laboratory(robot_of("axis: Tz, stiffness: 1000"));
  laboratory.hide("friction", "q", "force=60 N,presliding=3 um");
  Campaign campaign = laboratory.measure(loops(4));
  EXPECT_THAT(said_of(laboratory, campaign, {"friction"}), Not(HasSubstr("What is left")));
  for (Reading& reading : campaign.readings) reading.sigma /= 1.6;
  EXPECT_THAT(said_of(laboratory, campaign, {"friction"}),
              ContainsRegex("What is left is 1\\.[3-9][0-9]? times the stated noise"));
}

}  // namespace
}  // namespace kinetostat::calibration::first_screen_test

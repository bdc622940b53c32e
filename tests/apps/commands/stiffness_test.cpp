// What 'stiffness' and its like say of postures and of robots that are rigid in some direction.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::stiffness_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// Two links of 0.3 m that turn about the vertical, and a quill: nothing in it tilts.
void write_scara() {
  io::write_atomically(
      working_folder() / "scara.yaml",
      "kinetostat: 1\nname: scara\nunits: {length: mm, force: N, angle: deg}\nchain_types:\n"
      "  arm:\n"
      "    - actuator: {name: q1, axis: Rz, stiffness: 9e4 N m/rad, range: [-120, 120]}\n"
      "    - offset: [300, 0, 0]\n"
      "    - actuator: {name: q2, axis: Rz, stiffness: 4e4 N m/rad}\n"
      "    - offset: [300, 0, 0]\n"
      "    - actuator: {name: quill, axis: Tz, stiffness: 2e6 N/m}\n"
      "manipulator: {chain: arm}\n");
}

TEST(PostureWarning, NamesTheJointAndItsRange) {
  write_scara();
  for (const char* command : {"stiffness", "deflect", "modes"}) {
    const std::string load = std::string(command) == "deflect" ? " --wrench 10,0,0,0,0,0" : "";
    const Outcome beyond = kinetostat(std::string(command) + " scara.yaml --joints q1=170" + load);
    EXPECT_THAT(beyond.err, HasSubstr("joint q1 stands at 170 deg, outside of its range -120 to "
                                      "120 deg"))
        << command;
    const Outcome within = kinetostat(std::string(command) + " scara.yaml --joints q1=120" + load);
    EXPECT_THAT(within.err, Not(HasSubstr("outside of its range"))) << command;
  }
}

// At q1 = 0, q2 = 90 deg the tool is 0.3 m beyond the second axis, across: along x both joints
// yield, 0.3^2/9e4 + 0.3^2/4e4 m/N, along y the first, 0.3^2/9e4 m/N, coupled by -0.3^2/9e4.
TEST(StiffnessText, OfARobotThatIsRigidInRotationIsThatWithoutMoment) {
  write_scara();
  const Outcome outcome = kinetostat("stiffness scara.yaml --joints q2=90");
  EXPECT_THAT(outcome.err, IsEmpty());
  EXPECT_THAT(outcome.out, HasSubstr("no moment [N/mm]"));
  // The inverse: 4e4/0.3^2 = 444 N/mm along x and in the coupling, and 9e4/0.3^2 = 1000 more along
  // y.
  EXPECT_THAT(outcome.out, HasSubstr("x  444       444       0"));
  EXPECT_THAT(outcome.out, HasSubstr("y  444       1440      0"));
  EXPECT_THAT(outcome.out, HasSubstr("z  0         0         2000"));
}

}  // namespace
}  // namespace kinetostat::stiffness_test

// Requests without an answer: each ends with the reason, the last good state, and exit code 4 or 5.
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::unsolvable_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

struct Request {
  const char* name;
  std::string arguments;
  int code;
  const char* reason;  // on standard error
  const char* state;   // what is still known: on standard output, or in the reason
};

class Unsolvable : public testing::TestWithParam<Request> {
 protected:
  void SetUp() override {
    const auto write = [](const char* name, const std::string& text) {
      io::write_atomically(working_folder() / name, text);
    };
    write("unsolvable_path.csv", "x,fx\n0,10\n5000,10\n");
    write("free_turn.csv", "z [mm],mz [N m]\n600,5\n");
    write("unloaded_campaign.yaml",
          "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N}\n"
          "displacement: difference\nreadings: unloaded_readings.csv\n");
    write("unloaded_readings.csv", "fz,dz\n0,0.1\n0,0.2\n");
    // Carriages rolled by far too much to be assembled.
    std::string text = io::read_text(working_folder() / "data/robots/orthoglide_errors.yaml");
    const std::string roll = "rotation_vector: [1, 0, 0]";
    for (std::size_t at = text.find(roll); at != std::string::npos; at = text.find(roll, at))
      text.replace(at, roll.size(), "point: [0, 0, 900]");
    write("misfit.yaml", text);
    // Rigid drives and a spring in the tool that a wrench would bend without end.
    write("loose.yaml",
          "kinetostat: 1\nname: loose\nunits: {length: mm, force: N, angle: deg}\n"
          "gravity: {direction: [0, 0, -1]}\nchain_types:\n  arm:\n"
          "    - passive: {name: hinge, axis: Ry}\n    - offset: [500, 0, 0]\n"
          "    - mass: {name: weight, mass: 10 kg}\nmanipulator: {chain: arm}\n");
  }
};

TEST_P(Unsolvable, EndsWithReasonStateAndCode) {
  const Request& request = GetParam();
  const Outcome outcome = kinetostat(request.arguments + " --verbose");
  EXPECT_EQ(outcome.code, request.code) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr(request.reason));
  EXPECT_THAT(outcome.out + outcome.err, HasSubstr(request.state));
}

const std::string orthoglide = "data/robots/orthoglide.yaml ";

INSTANTIATE_TEST_SUITE_P(
    Requests, Unsolvable,
    testing::Values(
        Request{"pose_out_of_reach", "stiffness " + orthoglide + "--at 5000,0,0", 4,
                "cannot reach the pose", "the nearest it comes is"},
        Request{"joints_that_do_not_close", "stiffness " + orthoglide + "--joints x.rho=-2000", 4,
                "the loops cannot be closed", "the nearest it comes is"},
        Request{"mechanism_out_of_reach", "stiffness data/robots/delta.yaml --at 0,0,-900", 4,
                "cannot reach the pose", "the nearest it comes is"},
        Request{"wrench_on_a_free_motion",
                "deflect data/robots/stewart_gough_a.yaml --at 0,0,600 --wrench 0,0,0,0,0,1000", 4,
                "works on a motion that nothing resists", "Displacement at point (0, 0, 600)"},
        Request{"weight_on_a_free_motion", "deflect loose.yaml", 4,
                "works on a motion that nothing resists", "Displacement at point (500, 0, 0)"},
        Request{"move_of_a_rigid_chain", "deflect data/robots/bench.yaml --move 1,0,0", 4,
                "rigid against part of this displacement", "Displacement at point (0, 0, 0)"},
        Request{"beyond_the_last_equilibrium",
                "deflect " + orthoglide + "--at -73.65,-73.65,-73.65 --wrench -90000,-90000,-90000",
                4, "no equilibrium was found beyond", "Wrench at point"},
        Request{"unstable_equilibrium", "deflect data/robots/delta.yaml --wrench 0,0,-100000", 4,
                "this equilibrium is unstable", "unstable in"},
        Request{"iteration_of_the_papers_beyond_its_range",
                "deflect " + orthoglide + "--at 0,0,0 --move 2,2,2 --method fixed-point", 4,
                "the chains did not come to rest", "The state below is reached at 0 %"},
        Request{"chains_that_do_not_fit", "assemble misfit.yaml --at 0,0,0", 4,
                "no equilibrium was found beyond 0 % of the", "Platform: stable"},
        Request{"path_that_leaves_the_workspace",
                "compensate " + orthoglide + "--path unsolvable_path.csv", 4,
                "pose 2 of the path: chain", "2 poses, 1 compensated"},
        Request{"load_of_a_path_on_a_free_motion",
                "compensate data/robots/stewart_gough_a.yaml --path free_turn.csv", 4,
                "pose 1 of the path: the load works on a motion", "1 poses, 0 compensated"},
        Request{"readings_that_cannot_tell",
                "compare data/robots/bench.yaml unloaded_campaign.yaml", 5,
                "no reading depends on the stiffness of 'spring'", "Load it in a"}),
    [](const auto& test) { return test.param.name; });

// Else the answer would be a posture or a matrix of NaN.
TEST(UnsolvableOptions, BeyondComputingAreRefused) {
  const std::string requests[] = {"stiffness " + orthoglide + "--at inf,0,0",
                                  "stiffness " + orthoglide + "--at 1e300,0,0",
                                  "stiffness data/robots/bench.yaml --joints spring=inf",
                                  "trace " + orthoglide + "--at 0,0,0 --along inf,0,0",
                                  "map " + orthoglide + "--grid x=-1e300:1e300:3 --index weakest"};
  for (const std::string& arguments : requests) {
    const Outcome outcome = kinetostat(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_THAT(outcome.err, HasSubstr("is too large to compute with"));
  }
}

// The share of the load that was reached is a result for programs too.
TEST(UnsolvableJson, HoldsTheLastEquilibrium) {
  const Outcome outcome =
      kinetostat("deflect " + orthoglide +
                 "--at -73.65,-73.65,-73.65 --wrench -90000,-90000,-90000 --json last.json");
  EXPECT_EQ(outcome.code, 4);
  const io::Json json = io::read_json(working_folder() / "last.json")["equilibrium"];
  EXPECT_GT(json["reached"].get<double>(), 0.001);
  EXPECT_LT(json["reached"].get<double>(), 1);
  EXPECT_TRUE(json["stability"]["platform_held"]["stable"].get<bool>());
}

}  // namespace
}  // namespace kinetostat::unsolvable_test

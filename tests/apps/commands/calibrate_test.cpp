// What 'calibrate' writes has the error that it showed, and is where 'diagnose' sends people.
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::apps::calibrate_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;
using testing::StartsWith;

const std::string ur10 = "data/measurements/ur10_tracker/";

io::Json result(const std::string& name) { return io::read_json(working_folder() / name); }

// compare() fits the frame of the tracker anew, and nothing else.
TEST(Calibrate, WritesARobotFileWithTheErrorThatItShowed) {
  const Outcome made = kinetostat("calibrate " + ur10 +
                                  "campaign.yaml -q --hold-out 0 -o made.yaml --json made.json");
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_THAT(made.out, StartsWith("Kinematics calibrated: "));
  EXPECT_THAT(made.out, HasSubstr("Next: kinetostat diagnose made.yaml"));
  const Outcome compared =
      kinetostat("compare made.yaml " + ur10 + "campaign.yaml -q --json compared.json");
  ASSERT_EQ(compared.code, 0) << compared.err;
  const double shown = result("made.json")["stages"].back()["fitted"]["over_noise"];
  EXPECT_NEAR(result("compared.json")["as_designed"]["error_over_noise"].get<double>(), shown,
              1e-4 * shown);
  // Every value of the file has its standard deviation.
  EXPECT_THAT(io::read_text(working_folder() / "made.yaml"),
              HasSubstr("{effect: geometric_error, at: arm.elbow_joint, rz: {value: "));
  // Made once more from that file there is nothing left to do, and nothing is written.
  const Outcome again =
      kinetostat("calibrate made.yaml " + ur10 + "campaign.yaml -q --hold-out 5 -o again.yaml");
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("Nothing to calibrate"));
  EXPECT_FALSE(std::filesystem::exists(working_folder() / "again.yaml"));
  // With everything held to be new, its values take the place of those that are there.
  const Outcome forced =
      kinetostat("calibrate made.yaml " + ur10 + "campaign.yaml -q --hold-out 0 -o forced.yaml");
  ASSERT_EQ(forced.code, 0) << forced.err;
  const Outcome forced_compared =
      kinetostat("compare forced.yaml " + ur10 + "campaign.yaml -q --json forced.json");
  ASSERT_EQ(forced_compared.code, 0) << forced_compared.err;
  EXPECT_NEAR(result("forced.json")["as_designed"]["error_over_noise"].get<double>(), shown,
              1e-3 * shown);
  ASSERT_EQ(kinetostat("revert made.yaml -q").code, 0);
  EXPECT_EQ(io::read_text(working_folder() / "made.yaml"),
            io::read_text(working_folder() / (ur10 + "robot.yaml")));
}

TEST(Calibrate, ItsScreenFits) {
  const Outcome made =
      kinetostat("calibrate " + ur10 + "campaign.yaml -q --hold-out 2 -o screen.yaml");
  ASSERT_EQ(made.code, 0) << made.err;
  std::size_t lines = 0;
  std::istringstream text(made.out);
  for (std::string line; std::getline(text, line); ++lines) EXPECT_LE(line.size(), 100u) << line;
  EXPECT_LE(lines, 25u) << made.out;
}

TEST(Calibrate, ThreadsChangeNoDigit) {
  for (const int threads : {1, 3})
    ASSERT_EQ(kinetostat(fmt::format("calibrate data/measurements/six_axis_balancer/campaign.yaml "
                                     "-q --hold-out 3 --threads {0} --json t{0}.json",
                                     threads))
                  .code,
              0);
  EXPECT_EQ(io::read_text(working_folder() / "t1.json"),
            io::read_text(working_folder() / "t3.json"));
}

TEST(Calibrate, SaysWhatReadingsItNeeds) {
  const Outcome refused =
      kinetostat("calibrate data/measurements/arm_hysteresis/campaign.yaml -q -o no.yaml");
  EXPECT_EQ(refused.code, 5);
  EXPECT_THAT(refused.err, HasSubstr("displacement: absolute"));
  EXPECT_FALSE(std::filesystem::exists(working_folder() / "no.yaml"));
}

TEST(Calibrate, RefusesAToleranceThatIsNone) {
  for (const char* tolerance : {"1mm", "0,1mrad", "1 mrad,1 mm", "a,b"}) {
    const Outcome refused =
        kinetostat(fmt::format("calibrate {}campaign.yaml -q --tolerance '{}'", ur10, tolerance));
    EXPECT_EQ(refused.code, 2) << tolerance;
    EXPECT_THAT(refused.err, HasSubstr("--tolerance"));
  }
}

// One pose in eight, to save time.
void write_some_poses() {
  const std::filesystem::path folder = working_folder() / "some";
  std::istringstream rows(io::read_text(working_folder() / ur10 / "readings.csv"));
  std::string some;
  std::size_t row = 0;
  for (std::string line; std::getline(rows, line); ++row)
    if (row == 0 || row % 8 == 1) some += line + "\n";
  io::write_atomically(folder / "readings.csv", some);
  for (const char* file : {"campaign.yaml", "robot.yaml"})
    io::write_atomically(folder / file, io::read_text(working_folder() / ur10 / file));
}

TEST(StudyOfPoses, CalibratesWhereTheKinematicsComeFirst) {
  write_some_poses();
  const Outcome diagnosed =
      kinetostat("diagnose some/campaign.yaml -q --draws 99 --json some.json");
  ASSERT_EQ(diagnosed.code, 0) << diagnosed.err;
  EXPECT_EQ(io::read_json(working_folder() / "some.json").at("verdict"), "unexplained");
  EXPECT_THAT(diagnosed.out, StartsWith("Calibrate the kinematics first"));
  EXPECT_THAT(diagnosed.out, HasSubstr("Next: kinetostat calibrate some/campaign.yaml -o"));
  const Outcome studied = kinetostat("study some/campaign.yaml -q -o studied");
  ASSERT_EQ(studied.code, 0) << studied.err;
  EXPECT_THAT(studied.out, StartsWith("Calibrate the kinematics first"));
  EXPECT_THAT(studied.out, HasSubstr("Kinematics calibrated: "));
  EXPECT_THAT(studied.out,
              HasSubstr("kinetostat study studied/calibrated.yaml some/campaign.yaml"));
  const io::Json study = io::read_json(working_folder() / "studied/study.json");
  const io::Json& stages = study.at("waterfall");
  EXPECT_LT(stages[2].at("whitened").get<double>(), 0.5 * stages[1].at("whitened").get<double>());
  const Outcome compared =
      kinetostat("compare studied/calibrated.yaml some/campaign.yaml -q --json compared.json");
  ASSERT_EQ(compared.code, 0) << compared.err;
  EXPECT_EQ(io::read_json(working_folder() / "compared.json")
                .at("as_designed")
                .at("error_over_noise")
                .get<double>(),
            study.at("error_as_written").get<double>());
}

}  // namespace
}  // namespace kinetostat::apps::calibrate_test

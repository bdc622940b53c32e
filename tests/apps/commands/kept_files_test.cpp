// Results never replace the files that they are made from, whatever these are called.
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::kept_files_test {
namespace {

using io::read_text;
using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

struct Request {
  std::string command, replaced;
};

class KeptFiles : public testing::Test {
 protected:
  KeptFiles() {
    std::filesystem::remove_all(folder_);
    std::filesystem::copy(
        std::string(KINETOSTAT_SOURCE_DIR) + "/data/measurements/arm_nothing_hidden", folder_);
  }

  const std::filesystem::path folder_ = working_folder() / "kept";
};

TEST_F(KeptFiles, AreThoseThatACommandReads) {
  for (const auto& [command, replaced] : std::vector<Request>{
           {"compare kept/campaign.yaml --csv kept/readings.csv", "readings.csv"},
           {"compare kept/campaign.yaml --csv kept/../kept/./readings.csv", "readings.csv"},
           {"compare kept/campaign.yaml --json kept/robot.yaml", "robot.yaml"},
           {"compare kept/campaign.yaml -o kept/campaign.yaml", "campaign.yaml"},
           {"diagnose kept/campaign.yaml -o kept/robot.yaml", "robot.yaml"},
           {"plan kept/campaign.yaml -o kept/readings.csv", "readings.csv"},
           {"measure check kept/campaign.yaml -o kept/readings.csv", "readings.csv"},
           {"stiffness kept/robot.yaml -o kept/robot.yaml", "robot.yaml"}}) {
    const std::string before = read_text(folder_ / replaced);
    const Outcome outcome = kinetostat(command);
    EXPECT_EQ(outcome.code, 3) << command << outcome.out << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("is read, and the result would replace it")) << command;
    EXPECT_EQ(read_text(folder_ / replaced), before) << command;
  }
}

TEST_F(KeptFiles, AreThoseBehindLinks) {
  std::filesystem::create_symlink("readings.csv", folder_ / "results.csv");
  const std::string before = read_text(folder_ / "readings.csv");
  EXPECT_EQ(kinetostat("compare kept/campaign.yaml --csv kept/results.csv").code, 3);
  EXPECT_EQ(read_text(folder_ / "readings.csv"), before);
}

TEST_F(KeptFiles, AreMeasurementsWhereReadingsAreSimulated) {
  const std::string simulate =
      "simulate data/robots/orthoglide.yaml --plan data/measurements/plans/orthoglide.csv "
      "--noise-translation 5um --noise-rotation 20urad --out kept";
  const std::string before = read_text(folder_ / "readings.csv");
  const Outcome outcome = kinetostat(simulate);
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("was not made by 'simulate'"));
  EXPECT_EQ(read_text(folder_ / "readings.csv"), before);
  // What it made itself it makes again.
  EXPECT_EQ(kinetostat(simulate + "/new").code, 0);
  EXPECT_EQ(kinetostat(simulate + "/new --seed 2").code, 0);
}

}  // namespace
}  // namespace kinetostat::kept_files_test

#include "kinetostat/report/readings_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/comparison.h"

#include "support/temporary_folder.h"

namespace kinetostat::report::readings_picture_test {
namespace {

using io::Json;
using ::testing::ElementsAre;

// A spring of 1 N/um along z, two postures, read by a gauge of 4 um under loads known to 3 N.
class ReadingsPicture : public ::testing::Test {
 protected:
  ReadingsPicture() : robot_(slide()) {
    write("readings.csv",
          "id,drive,fz,dx,dz,direction\na,0,0,,0.001,loading\nb,0,100,,0.103,loading\n"
          "c,20,-100,0,,unloading\nd,20,100,,0.096,\n");
  }
  vjm::Robot slide() const {
    write("robot.yaml",
          "kinetostat: 1\nname: slide\nunits: {length: mm, force: N, angle: deg}\nchain_types:\n"
          "  arm:\n    - actuator: {name: drive, axis: Tz, stiffness: 1000}\n"
          "manipulator: {chain: arm}\n");
    return vjm::read_robot(folder_.path() / "robot.yaml");
  }
  void write(const std::string& name, const std::string& text) const {
    io::write_atomically(folder_.path() / name, text);
  }
  calibration::Campaign campaign(const std::string& noise) const {
    write("campaign.yaml",
          "kinetostat: 1\ncampaign: slide\nunits: {length: mm, force: N}\n"
          "displacement: difference\nwrench_point: reference\nreadings: readings.csv\n" +
              noise);
    return calibration::read_campaign(folder_.path() / "campaign.yaml", robot_.manipulator);
  }
  Json picture(const std::string& noise) const {
    const calibration::Campaign read = campaign(noise);
    common::Progress silent;
    const calibration::Comparison comparison = calibration::compare(robot_, read, 1, silent);
    return readings_picture(robot_, read, comparison.noise, readings_models(comparison));
  }
  test::TemporaryFolder folder_;
  vjm::Robot robot_;
};

TEST_F(ReadingsPicture, NoiseOfTheLoadCellIsPartOfThatOfTheReadings) {
  const Json plain = picture("noise: {translation: 4 um}\n");
  EXPECT_DOUBLE_EQ(plain["sigma"]["dz"][1].get<double>(), 4e-6);
  // 3 N on 1 N/um are 3 um, beside the 4 um of the gauge.
  const Json loud = picture("noise: {translation: 4 um}\nwrench_noise: {force: 3 N}\n");
  EXPECT_NEAR(loud["sigma"]["dz"][1].get<double>(), 5e-6, 1e-11);
}

TEST_F(ReadingsPicture, HasAnEntryForEachReading) {
  const Json json = picture("noise: {translation: 4 um}\n");
  EXPECT_THAT(json["id"], ElementsAre("a", "b", "c", "d"));
  EXPECT_THAT(json["load"]["fz"], ElementsAre(0, 100, -100, 100));
  EXPECT_THAT(json["pose"], ElementsAre(0, 0, 1, 1));
  EXPECT_THAT(json["stated"], ElementsAre(1, 1, 2, 0));
  EXPECT_TRUE(json["measured"]["dz"][2].is_null());
  EXPECT_FALSE(json["measured"].contains("dy"));
  EXPECT_NEAR(json["models"][0]["residual"]["dz"][3].get<double>(), -4e-6, 1e-11);
  EXPECT_NEAR(json["poses"][1]["position"][2].get<double>(), 0.02, 1e-12);
  EXPECT_EQ(json["poses"][1]["label"], "arm.drive 20");  // [mm]: it slides
}

TEST_F(ReadingsPicture, NothingIsSaidOfANoiseThatNobodyKnows) {
  EXPECT_FALSE(picture("").contains("sigma"));
}

// What the page draws from --json alone.
TEST_F(ReadingsPicture, ResultsHoldLoadsPosturesAndNoiseOfTheReadings) {
  const calibration::Campaign read =
      campaign("noise: {translation: 4 um}\nwrench_noise: {force: 3 N}\n");
  common::Progress silent;
  const Json reading = to_json(read, calibration::compare(robot_, read, 1, silent))["readings"][2];
  EXPECT_EQ(reading["configuration"], 1);
  EXPECT_NEAR(reading["sigma"][0].get<double>(), 4e-6, 1e-11);
  EXPECT_TRUE(reading["sigma"][2].is_null());  // was not measured
  EXPECT_EQ(reading["direction"], "unloading");
  EXPECT_THAT(reading["load"]["force"], ElementsAre(0, 0, -100));
  EXPECT_THAT(reading["load"]["moment"], ElementsAre(0, 0, 0));
  EXPECT_EQ(configurations(robot_, read).size(), 2u);
}

}  // namespace
}  // namespace kinetostat::report::readings_picture_test

#include "kinetostat/calibration/campaign.h"

#include <ctime>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/files/error.h"

#include "calibration/synthetic.h"
#include "support/matrix_near.h"

namespace kinetostat::calibration {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string head =
    "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N, angle: deg, time: s}\n"
    "displacement: difference\nreadings: readings.csv\n";

Campaign read(const std::string& csv, const std::string& more = "",
              const vjm::Manipulator& manipulator = test::bench().manipulator) {
  return read_campaign(test::write_campaign(head + more, csv), manipulator);
}

// The file exactly as the format was published.
TEST(CampaignFile, ReadsThePublishedExample) {
  const auto file = test::write_campaign(
      "kinetostat: 1\n"
      "campaign: load cell\n"
      "robot: ../robots/bench.yaml\n"
      "units: {length: mm, force: N, angle: deg, time: s}\n"
      "displacement: difference            # or absolute\n"
      "readings: readings.csv              # columns named in diagnosis.md; any subset of dx dy dz "
      "rx ry rz\n"
      "noise: {translation: 15 um}         # or a sigma column, or replicates\n",
      "id,fz,dz\na,1000,0.5\n");
  const Campaign c = read_campaign(file, test::bench().manipulator);
  EXPECT_EQ(c.name, "load cell");
  EXPECT_EQ(c.robot, "../robots/bench.yaml");
  EXPECT_EQ(c.displacement, DisplacementKind::difference);
  EXPECT_TRUE(c.noise_stated);
  ASSERT_EQ(c.readings.size(), 1u);
  EXPECT_EQ(c.readings[0].id, "a");
  EXPECT_EQ(c.readings[0].line, 2);
  EXPECT_DOUBLE_EQ(c.readings[0].load.force.z(), 1000);
  EXPECT_DOUBLE_EQ(c.readings[0].displacement.z(), 5e-4);
  EXPECT_DOUBLE_EQ(c.readings[0].sigma.z(), 15e-6);
  EXPECT_FALSE(c.readings[0].uses(0));
  EXPECT_TRUE(c.readings[0].uses(2));
}

TEST(CampaignFile, ReadsEveryColumnInItsUnit) {
  const Campaign c = read(
      "id,session,cycle,step,time,temperature,setting,replicate,x,y,z,roll,pitch,yaw,fx,fy,fz,mx,"
      "my,mz,px,py,pz,direction,dx,ry,sigma,sigma_ry,mask,mask_reason,operator\n"
      "a,s1,c1,4,2.5,21,low,1,10,20,30,0,0,90,1,2,3,4000,5000,6000,7,8,9,unloading,0.5,18,0.1,1.8,"
      "1,slipped,Ann\n"
      "b,s2,c1,5,3,22,low,2,10,20,30,0,0,90,1,2,3,4000,5000,6000,7,8,9,loading,0.5,18,0.1,1.8,,,"
      "\"Bob, jr\"\n");
  const Reading& r = c.readings[0];
  EXPECT_EQ(c.sessions[r.session], "s1");
  EXPECT_EQ(r.cycle, "c1");
  EXPECT_EQ(r.step, 4);
  EXPECT_EQ(r.time, 2.5);
  EXPECT_EQ(r.temperature, 21);
  EXPECT_EQ(r.setting, "low");
  EXPECT_EQ(r.replicate, "1");
  EXPECT_EQ(r.direction, LoadDirection::unloading);
  EXPECT_EQ(c.readings[1].direction, LoadDirection::loading);
  ASSERT_EQ(c.configurations.size(), 1u);
  const spatial::Pose& target = c.configurations[0].target.value();
  EXPECT_TRUE(
      kinetostat::test::matrix_near(target.position(), spatial::Vector3(0.01, 0.02, 0.03), 1e-15));
  EXPECT_TRUE(
      kinetostat::test::matrix_near(target.rotation().col(0), spatial::Vector3::UnitY(), 1e-15));
  EXPECT_EQ(r.load.force, spatial::Vector3(1, 2, 3));
  EXPECT_TRUE(kinetostat::test::matrix_near(r.load.moment, spatial::Vector3(4, 5, 6), 1e-14));
  EXPECT_TRUE(kinetostat::test::matrix_near(r.load.point_on_platform,
                                            spatial::Vector3(7e-3, 8e-3, 9e-3), 1e-16));
  EXPECT_DOUBLE_EQ(r.displacement[0], 5e-4);
  EXPECT_DOUBLE_EQ(r.displacement[4], M_PI / 10);
  EXPECT_DOUBLE_EQ(r.sigma[0], 1e-4);
  EXPECT_DOUBLE_EQ(r.sigma[4], M_PI / 100);
  EXPECT_TRUE(r.masked);
  EXPECT_EQ(r.mask_reason, "slipped");
  ASSERT_EQ(c.covariates.size(), 1u);
  EXPECT_EQ(c.covariates[0].name, "operator");
  EXPECT_THAT(c.covariates[0].values, ElementsAre("Ann", "Bob, jr"));
  EXPECT_THAT(c.notes, ElementsAre(HasSubstr("kept as covariates: 'operator'")));
}

TEST(CampaignFile, TakesActuatorCoordinatesByJointName) {
  const Campaign alone = read("spring,fz,dz\n2,1,1\n3,1,1\n2,2,1\n");
  ASSERT_EQ(alone.configurations.size(), 2u);
  EXPECT_DOUBLE_EQ(alone.configurations[0].joints.at("cell.spring"), 2e-3);
  const Campaign chains =
      read("x.rho,y.rho,z.rho,fz,dz\n-450,-451,-452,1,1\n", "", test::orthoglide().manipulator);
  EXPECT_DOUBLE_EQ(chains.configurations[0].joints.at("z.rho"), -0.452);
}

TEST(CampaignFile, StatesNoiseForAllAxesOrEach) {
  const auto sigma = [](const std::string& noise) {
    return read("fz,dx,dz\n1,1,1\n", "noise: " + noise + "\n").readings[0].sigma;
  };
  EXPECT_DOUBLE_EQ(sigma("{translation: 15 um}")[0], 15e-6);
  EXPECT_DOUBLE_EQ(sigma("{translation: [1 um, 2 um, 30 um]}")[2], 30e-6);
  EXPECT_DOUBLE_EQ(sigma("{translation: 1 um, rotation: 1 mrad}")[5], 1e-3);
}

TEST(CampaignFile, SaysWhatItAssumes) {
  EXPECT_THAT(read("fz,dz,drection\n1,1,\n").notes,
              testing::IsSupersetOf({HasSubstr("forces act at the platform's reference point"),
                                     HasSubstr("stands at its home coordinates"),
                                     HasSubstr("if 'direction' was meant, rename it")}));
}

TEST(CampaignFile, StepsNotRowsOrderTimeWhereThereAreSteps) {
  EXPECT_EQ(read("step,time,fz,dz\n2,20,1,1\n1,10,1,1\n").readings.size(), 2u);
  EXPECT_EQ(read("cycle,time,fz,dz\na,20,1,1\nb,10,1,1\n").readings.size(), 2u);
}

TEST(CampaignFile, ReadsAHundredThousandRowsInUnderASecond) {
  std::string csv = "id,x,y,z,fx,fy,fz,px,py,pz,dx,dy,dz\n";
  for (int i = 0; i < 100000; ++i)
    csv += fmt::format("r{},{},20.5,30.25,100.5,-20.25,{},0,0,50,0.0125,-0.25,0.{}\n", i, i % 500,
                       i % 97, i);
  const auto file = test::write_campaign(head + "noise: {translation: 15 um}\n", csv);
  const vjm::Manipulator manipulator = test::bench().manipulator;
  const std::clock_t begin = std::clock();  // of this process: others may be busy
  const Campaign c = read_campaign(file, manipulator);
  const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  EXPECT_EQ(c.readings.size(), 100000u);
  EXPECT_EQ(c.configurations.size(), 500u);
#if defined(NDEBUG) && !defined(__SANITIZE_ADDRESS__)
  EXPECT_LT(seconds, 1.0);
#else
  (void)seconds;
#endif
}

struct Broken {
  std::string name, yaml, csv, message;
};

class BrokenCampaign : public testing::TestWithParam<Broken> {};

TEST_P(BrokenCampaign, IsRefusedWithPlaceValueAndCure) {
  const auto file = test::write_campaign(GetParam().yaml, GetParam().csv);
  files::Progress silent;
  const vjm::Robot robot = test::orthoglide();
  std::string message = "no error";
  try {
    compare(robot, read_campaign(file, robot.manipulator), 1, silent);
  } catch (const files::InputError& error) {
    message = error.what();
  }
  EXPECT_THAT(message, HasSubstr(GetParam().message));
}

std::string without(const std::string& line) {
  std::string text = head;
  const std::size_t begin = text.find(line);
  return text.erase(begin, text.find('\n', begin) + 1 - begin);
}

const std::string pose = "x,y,z,fx,dx\n";

INSTANTIATE_TEST_SUITE_P(
    All, BrokenCampaign,
    testing::Values(
        Broken{"NoUnits", without("units"), pose + "0,0,0,1,1\n",
               "campaign.yaml:1: the key 'units' is missing"},
        Broken{"NoAngleUnit",
               "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N}\n"
               "displacement: difference\nreadings: readings.csv\n",
               "x,y,z,fx,rx\n0,0,0,1,1\n",
               "units.angle: no unit of angle is stated, but the readings have the column 'rx'. "
               "Write 'angle: deg' under 'units'"},
        Broken{"NoTimeUnit",
               "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N}\n"
               "displacement: difference\nreadings: readings.csv\n",
               "x,y,z,time,fx,dx\n0,0,0,1,1,1\n", "units.time: no unit of time is stated"},
        Broken{"NoiseWithoutUnit", head + "noise: {translation: 15}\n", pose + "0,0,0,1,1\n",
               "campaign.yaml:6: noise.translation: "},
        Broken{"NegativeNoise", head + "noise: {translation: -15 um}\n", pose + "0,0,0,1,1\n",
               "'-15 um' is not positive. Give the standard deviation"},
        Broken{"MisspeltKey", head + "nose: {translation: 15 um}\n", pose + "0,0,0,1,1\n",
               "campaign.yaml:6: nose: the key 'nose' is not known here. Did you mean 'noise'?"},
        Broken{"UnknownKind", without("displacement") + "displacement: relative\n",
               pose + "0,0,0,1,1\n", "displacement: 'relative' is not one of difference, absolute"},
        Broken{"NoReadingsFile", without("readings") + "readings: reading.csv\n",
               pose + "0,0,0,1,1\n", "reading.csv' does not exist. Did you mean 'readings.csv'?"},
        Broken{"NotANumber", head, pose + "0,0,0,1,0.5\n0,0,0,12 N,0.5\n",
               "readings.csv:3:7: fx: '12 N' is not a number. Write the number alone"},
        Broken{"EmptyLoad", head, pose + "0,0,0,,0.5\n",
               "readings.csv:2:7: fx: the cell is empty. Write a number"},
        Broken{"DuplicateId", head, "id," + pose + "a,0,0,0,1,1\nb,0,0,0,1,1\na,0,0,0,2,1\n",
               "readings.csv:4:1: id: the id 'a' is already used on line 2. Give each row"},
        Broken{"EmptyId", head, "id," + pose + ",0,0,0,1,1\n",
               "readings.csv:2:1: id: the id is empty"},
        Broken{"NothingMeasured", head, pose + "0,0,0,1,\n",
               "readings.csv:2:9: dx: the reading has no displacement at all. Write what was"},
        Broken{"NoDisplacementColumn", head, "x,y,z,fx\n0,0,0,1\n",
               "readings.csv:1: there is no column of displacement. Name at least one of dx"},
        Broken{"NoLoadColumn", head, "x,y,z,dx\n0,0,0,1\n",
               "readings.csv:1: there is no column of load"},
        Broken{"MomentWithoutPoint", head, "x,y,z,mz,rz\n0,0,0,1,1\n",
               "readings.csv:1: mz: moments are given without the point that they are taken about. "
               "Add the columns px, py, pz, or 'wrench_point: reference'"},
        Broken{"HalfAPoint", head, "x,y,z,fx,px,py,dx\n0,0,0,1,0,0,1\n",
               "readings.csv:1: pz: the column 'pz' is missing: px, py and pz go together"},
        Broken{"HalfAPose", head, "x,y,fx,dx\n0,0,1,1\n",
               "readings.csv:1: z: the column 'z' is missing: x, y and z go together"},
        Broken{"MissingJoint", head, "x.rho,y.rho,fx,dx\n-450,-450,1,1\n",
               "readings.csv:1: z.rho: the actuated joint 'z.rho' has no column"},
        Broken{"PoseTwice", head, "x,y,z,x.rho,y.rho,z.rho,fx,dx\n0,0,0,1,1,1,1,1\n",
               "the posture is given twice"},
        Broken{
            "UnitInHeader", head, "x,y,z,Fx [N],dx\n0,0,0,1,1\n",
            "readings.csv:1: Fx [N]: the column 'Fx [N]' is not known. Write 'fx'; units belong"},
        Broken{"TimeRunsBackwards", head,
               "cycle,time," + pose + "a,1,0,0,0,1,1\na,5,0,0,0,1,1\na,4,0,0,0,1,1\n",
               "readings.csv:4:3: time: time runs backwards in this cycle: '4' comes after '5' of "
               "line 3. Order the rows by time"},
        Broken{"SigmaForSomeOnly", head, "x,y,z,fx,dx,sigma\n0,0,0,1,1,0.01\n0,0,0,2,1,\n",
               "readings.csv:3:9: dx: this value has no standard deviation, but others have. State "
               "it under 'noise' in the campaign file or in a column sigma_dx"},
        Broken{"ZeroSigma", head, "x,y,z,fx,dx,sigma\n0,0,0,1,1,0\n",
               "readings.csv:2:11: sigma: '0' is not positive"},
        Broken{"MaskWithoutReason", head, pose.substr(0, pose.size() - 1) + ",mask\n0,0,0,1,1,1\n",
               "readings.csv:2:11: mask: the reading is masked without a reason. Say why in"},
        Broken{"WrongMask", head, "x,y,z,fx,dx,mask\n0,0,0,1,1,maybe\n",
               "mask: 'maybe' is neither 0 nor 1"},
        Broken{"AllMasked", head, "x,y,z,fx,dx,mask,mask_reason\n0,0,0,1,1,1,slipped\n",
               "every reading is masked"},
        Broken{"WrongDirection", head, "x,y,z,fx,dx,direction\n0,0,0,1,1,up\n",
               "readings.csv:2:11: direction: 'up' is not a direction of load. Write loading or"},
        Broken{"PoseOutOfReach", head, pose + "0,0,0,1,1\n0,0,900,1,1\n",
               "readings.csv:3: the posture of reading '2' is out of reach: chain "},
        Broken{"RaggedRow", head, pose + "0,0,0,1\n",
               "readings.csv:2: dx: this row has 4 cells, the header has 5"}),
    [](const auto& broken) { return broken.param.name; });

}  // namespace
}  // namespace kinetostat::calibration

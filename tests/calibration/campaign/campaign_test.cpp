#include "kinetostat/calibration/campaign/campaign.h"

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/campaign/noise.h"
#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/common/error.h"
#include "kinetostat/vjm/chain/chain_builder.h"

#include "calibration/synthetic.h"
#include "support/matrix_near.h"

namespace kinetostat::calibration::campaign_test {
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
  EXPECT_EQ(chains.joint_columns.at("z.rho").column, "z.rho");
}

TEST(CampaignFile, TakesMomentsThatAreNoneWithoutAPoint) {
  const Campaign pure = read("fz,mx,my,mz,dz\n5,0,0.000,-0,1\n9,0,0,0.0,2\n");
  EXPECT_TRUE(pure.readings[1].load.moment.isZero(0));
  EXPECT_THAT(pure.notes, ElementsAre(HasSubstr("No point of application"), HasSubstr("home")));
}

TEST(CampaignFile, CountsCopiesOfARowOnce) {
  const auto used = [](const Campaign& campaign) {
    return std::count_if(campaign.readings.begin(), campaign.readings.end(),
                         [](const Reading& reading) { return !reading.masked; });
  };
  // The table pasted twice, in parts or whole.
  const Campaign pasted =
      read("id,cycle,step,fz,dz\na,1,1,5,1\nb,1,2,9,2\nc,1,2,9,2\nd,1,1,5,1\ne,2,1,5,1\n");
  EXPECT_EQ(used(pasted), 3);
  EXPECT_TRUE(pasted.readings[2].masked && pasted.readings[3].masked);
  EXPECT_EQ(pasted.readings[2].mask_reason, "the same row as on line 3");
  EXPECT_THAT(pasted.warnings, ElementsAre(HasSubstr("2 of 5 rows of")));
  EXPECT_EQ(used(read("fz,dz\n5,1\n9,2\n9,2\n5,1\n")), 2);
  EXPECT_EQ(used(read("time,fz,dz\n1,5,1\n2,5,1\n2,5,1\n")), 2);
  // Repeated readings of a coarse gauge are readings.
  const Campaign coarse = read("fz,dz\n5,1\n9,2\n5,1\n");
  EXPECT_EQ(used(coarse), 3);
  EXPECT_TRUE(coarse.warnings.empty());
  EXPECT_EQ(used(read("cycle,fz,dz\n1,0,0\n1,5,1\n1,9,2\n1,5,1\n")), 4);
  EXPECT_EQ(used(read("replicate,fz,dz\n1,5,1\n2,5,1\n")), 2);
}

// A gantry whose drives are called x, y and z, and its tool 100 mm below them.
vjm::Manipulator gantry(const char* first = "x") {
  vjm::ChainBuilder chain("arm");
  chain.actuator(first, vjm::Motion::tx, 1e6).actuator("y", vjm::Motion::ty, 1e6);
  chain.actuator("z", vjm::Motion::tz, 1e6).offset(spatial::Pose::translation({0, 0, -0.1}));
  return vjm::Manipulator("gantry", {chain.build()});
}

TEST(CampaignFile, SaysWhereDrivesAreNamedLikeThePose) {
  const std::string csv = "x,y,z,fz,dz\n10,20,30,1,1\n";
  const Campaign unstated = read(csv, "", gantry());
  EXPECT_TRUE(unstated.configurations[0].target.has_value());  // as ever
  EXPECT_TRUE(unstated.configurations[0].joints.empty());
  ASSERT_EQ(unstated.warnings.size(), 1u);
  EXPECT_THAT(unstated.warnings[0],
              testing::AllOf(HasSubstr("platform's pose: x, y, z"), HasSubstr("posture: platform"),
                             HasSubstr("posture: joints"), HasSubstr("arm.x, arm.y, arm.z")));
  EXPECT_THAT(unstated.notes, testing::Contains(unstated.warnings[0]));

  const Campaign platform = read(csv, "posture: platform\n", gantry());
  EXPECT_TRUE(platform.configurations[0].target.has_value());
  EXPECT_THAT(platform.warnings, testing::IsEmpty());

  const Campaign joints = read(csv, "posture: joints\n", gantry());
  EXPECT_FALSE(joints.configurations[0].target.has_value());
  EXPECT_DOUBLE_EQ(joints.configurations[0].joints.at("arm.x"), 0.01);
  EXPECT_DOUBLE_EQ(joints.configurations[0].joints.at("arm.z"), 0.03);
  EXPECT_EQ(joints.joint_columns.at("arm.y").column, "y");
  EXPECT_THAT(joints.warnings, testing::IsEmpty());

  const Campaign whole = read("arm.x,arm.y,arm.z,fz,dz\n10,20,30,1,1\n", "", gantry());
  EXPECT_DOUBLE_EQ(whole.configurations[0].joints.at("arm.x"), 0.01);
  EXPECT_THAT(whole.warnings, testing::IsEmpty());
}

// Only the case of a letter, or some of the drives; and drives named otherwise are never meant.
TEST(CampaignFile, KnowsADriveThatIsNearlyNamedLikeThePose) {
  EXPECT_THAT(read("x,y,z,fz,dz\n1,2,3,1,1\n", "", gantry("X")).warnings,
              ElementsAre(HasSubstr("pose: x, y, z")));
  EXPECT_THAT(read("x,y,z,fz,dz\n1,2,3,1,1\n", "", gantry("along")).warnings,
              ElementsAre(HasSubstr("pose: y, z;")));
  EXPECT_THAT(read("x,y,z,fz,dz\n1,2,3,1,1\n", "", test::orthoglide().manipulator).warnings,
              testing::IsEmpty());
  const auto error_of = [](const std::string& csv, const std::string& more,
                           const vjm::Manipulator& manipulator) {
    try {
      read(csv, more, manipulator);
    } catch (const common::InputError& error) {
      return std::string(error.what());
    }
    ADD_FAILURE() << "was read";
    return std::string();
  };
  // A table of two drives: "z is missing" alone would lead the wrong way.
  EXPECT_THAT(error_of("x,y,fz,dz\n1,2,1,1\n", "", gantry()), HasSubstr("posture: joints"));
  EXPECT_THAT(error_of("x,y,fz,dz\n1,2,1,1\n", "posture: joints\n", gantry()),
              HasSubstr("actuated joint 'z' has no column"));
  EXPECT_THAT(
      error_of("x,y,z,fz,dz\n1,2,3,1,1\n", "posture: joints\n", test::orthoglide().manipulator),
      HasSubstr("no joint is named 'x'"));
  EXPECT_THAT(error_of("x,y,z,fz,dz\n1,2,3,1,1\n", "posture: tool\n", gantry()),
              HasSubstr("posture"));
}

// A drive that is named like any other column: its coordinate is asked for by its whole name.
TEST(CampaignFile, SaysWhereADriveIsNamedLikeAColumn) {
  vjm::ChainBuilder chain("arm");
  chain.actuator("rz", vjm::Motion::rz, 1e4).offset(spatial::Pose::translation({0.3, 0, 0}));
  const vjm::Manipulator arm("arm", {chain.build()});
  EXPECT_THAT(read("fz,dz,rz\n1,1,2\n", "", arm).warnings, ElementsAre(HasSubstr("'arm.rz'")));
  EXPECT_THAT(read("arm.rz,fz,dz,rz\n30,1,1,2\n", "", arm).warnings, testing::IsEmpty());
  EXPECT_THAT(read("x,y,z,fz,dz,rz\n300,0,0,1,1,2\n", "", arm).warnings, testing::IsEmpty());
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

TEST(CampaignFile, ReadsAHundredThousandRows) {
  std::string csv = "id,x,y,z,fx,fy,fz,px,py,pz,dx,dy,dz\n";
  for (int i = 0; i < 100000; ++i)
    csv += fmt::format("r{},{},20.5,30.25,100.5,-20.25,{},0,0,50,0.0125,-0.25,0.{}\n", i, i % 500,
                       i % 97, i);
  const auto file = test::write_campaign(head + "noise: {translation: 15 um}\n", csv);
  const vjm::Manipulator manipulator = test::bench().manipulator;
  const Campaign c = read_campaign(file, manipulator);
  EXPECT_EQ(c.readings.size(), 100000u);
  EXPECT_EQ(c.configurations.size(), 500u);
}

// A chi-square is r' C^-1 r, whatever is measured of each reading.
TEST(CampaignFile, CorrelatedNoiseWhitensTogether) {
  const Campaign c = read(
      "fz,dx,dy,dz,sigma_dx,sigma_dy,sigma_dz,corr_dx_dz\n1,3,1,4,1,2,3,0.8\n1,1,,2,1,2,3,-0.5\n");
  const Noise noise = noise_of(c, {});
  for (const std::size_t i : {0u, 1u}) {
    const std::vector<Eigen::Index> used = components_in_use(c.readings[i]);
    spatial::Matrix6 covariance = spatial::Matrix6::Identity();
    covariance(0, 2) = covariance(2, 0) = i == 0 ? 0.8 : -0.5;
    covariance = c.readings[i].sigma.asDiagonal() * covariance * c.readings[i].sigma.asDiagonal();
    const Eigen::VectorXd r = c.readings[i].displacement(used);
    const Eigen::MatrixXd part = covariance(used, used);
    Eigen::MatrixXd whitened = r;
    noise.whiten(i, used, whitened);
    EXPECT_NEAR(whitened.squaredNorm(), r.dot(part.inverse() * r), 1e-9);
  }
}

TEST(CampaignFile, InstrumentsSayHowExactTheirReadingsAre) {
  const Campaign c =
      read("instrument,fz,dx,dz\ntracker,1,1,1\ngauge,1,,1\n,1,1,1\n",
           "instruments:\n"
           "  tracker: {translation: [10 um, 10 um, 20 um], correlation: {dx_dz: 0.3}}\n"
           "  gauge: {translation: 2 um}\n"
           "instrument: tracker\n");
  EXPECT_EQ(c.readings[0].instrument, "tracker");
  EXPECT_DOUBLE_EQ(c.readings[0].sigma.z(), 20e-6);
  EXPECT_DOUBLE_EQ(c.readings[1].sigma.z(), 2e-6);
  EXPECT_DOUBLE_EQ(c.readings[2].sigma.z(), 20e-6);
  ASSERT_TRUE(c.readings[0].correlation);
  EXPECT_DOUBLE_EQ(c.correlations[*c.readings[0].correlation](2, 0), 0.3);
  EXPECT_FALSE(c.readings[1].correlation);
  EXPECT_TRUE(c.noise_stated);
}

TEST(CampaignFile, RolesAreOfSessionsOrOfRows) {
  const Campaign c = read("session,role,fz,dz\na,,1,1\nb,,1,1\na,select,1,1\nb,fit,1,1\n",
                          "roles: {b: confirm}\n");
  EXPECT_EQ(c.readings[0].role, Role::fit);
  EXPECT_EQ(c.readings[1].role, Role::confirm);
  EXPECT_EQ(c.readings[2].role, Role::select);
  EXPECT_EQ(c.readings[3].role, Role::fit);
  const Campaign part = only(c, {Role::confirm, Role::select});
  EXPECT_TRUE(part.readings[0].masked);
  EXPECT_EQ(part.readings[0].mask_reason, "to fit");
  EXPECT_FALSE(part.readings[1].masked);
  EXPECT_FALSE(part.readings[2].masked);
}

// One wrench, written down in four frames: the same load, read by cells with these axes.
TEST(CampaignFile, WrenchesMayBeGivenInAnyStatedFrame) {
  const vjm::Manipulator manipulator = test::orthoglide().manipulator;
  const spatial::Vector3 force(10, -20, 30), moment(1, 2, -3);  // about the reference point, base
  const spatial::Pose platform(spatial::rotation_from_rpy({0.1, -0.2, 0.3}), {0.01, 0.02, -0.03});
  const auto csv = [&](const spatial::Vector3& f, const spatial::Vector3& m) {
    std::string text = "x,y,z,roll,pitch,yaw,fx,fy,fz,mx,my,mz,dx\n";
    return text + fmt::format("10,20,-30,{},{},{},{},{},{},{},{},{},1\n", 0.1 * 180 / M_PI,
                              -0.2 * 180 / M_PI, 0.3 * 180 / M_PI, f.x(), f.y(), f.z(), 1e3 * m.x(),
                              1e3 * m.y(), 1e3 * m.z());
  };
  spatial::Matrix3 cell_axes;  // of the last one that was read
  const auto load = [&](const std::string& text, const std::string& more) {
    const vjm::Load read_load = read(text, more, manipulator).readings[0].load;
    cell_axes = read_load.cell;
    return read_load.at_reference_point(platform);
  };
  spatial::Vector6 expected;
  expected << force, moment;
  const auto same = [&](const spatial::Vector6& actual) {
    return kinetostat::test::matrix_near(actual, expected, 1e-10);
  };
  EXPECT_TRUE(same(load(csv(force, moment), "wrench_point: reference\n")));
  EXPECT_TRUE(cell_axes.isIdentity(0));
  const spatial::Matrix3 r = platform.rotation();
  EXPECT_TRUE(same(load(csv(r.transpose() * force, r.transpose() * moment),
                        "wrench_frame: platform\nwrench_point: reference\n")));
  // A load cell on the platform reads about its own origin in its own axes.
  const spatial::Pose cell(spatial::rotation_from_rpy({0, 0, M_PI / 2}), {0.05, 0, 0.1});
  const spatial::Matrix3 axes = r * cell.rotation();
  const spatial::Vector3 about = moment - (r * cell.position()).cross(force);
  EXPECT_TRUE(same(load(csv(axes.transpose() * force, axes.transpose() * about),
                        "frames: {cell: {on: platform, pose: {point: [50, 0, 100], rpy: [0, 0, "
                        "90]}}}\nwrench_frame: cell\n")));
  EXPECT_LT((cell_axes - axes).norm(), 1e-12);
  // One on the table, about a point that does not move.
  const spatial::Vector3 origin(0.2, -0.1, 0.05);
  const spatial::Vector3 about_origin = moment - (origin - platform.position()).cross(force);
  EXPECT_TRUE(same(load(csv(force, about_origin),
                        "frames: {table: {on: base, pose: [200, -100, 50]}}\nwrench_frame: "
                        "table\n")));
}

}  // namespace
}  // namespace kinetostat::calibration::campaign_test

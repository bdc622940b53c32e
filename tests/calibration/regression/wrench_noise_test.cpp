// The noise of a load cell, carried to the displacements.
#include "kinetostat/calibration/regression/wrench_noise.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/regression/campaign_noise.h"
#include "kinetostat/calibration/regression/simulate.h"
#include "kinetostat/common/error.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/chain_builder.h"

#include "calibration/synthetic.h"

namespace kinetostat::calibration::wrench_noise_test {
namespace {

using spatial::Matrix6;

std::string plan_of(int poses, int loads, unsigned seed) {
  std::string csv = "x,y,z,fx,fy,fz,mx,my,mz,px,py,pz\n";
  for (const test::Planned& r : test::orthoglide_plan(poses, loads, seed)) {
    std::vector<double> row;
    for (const double v : r.position) row.push_back(v * 1e3);
    for (const double v : r.load.force) row.push_back(v);
    for (const double v : r.load.moment) row.push_back(v * 1e3);
    for (const double v : r.load.point_on_platform) row.push_back(v * 1e3);
    csv += fmt::format("{}\n", fmt::join(row, ","));
  }
  return csv;
}

// The noise of the load is far above that of the instrument; noise of the load is stated or kept
// silent.
Comparison compared(unsigned seed, bool stated, const vjm::Robot& robot) {
  const kinetostat::test::TemporaryFolder folder;
  io::write_atomically(folder.path() / "plan.csv", plan_of(10, 4, seed));
  common::Progress silent;
  SimulationOptions options{.translation_noise = 1e-7,
                            .rotation_noise = 1e-6,
                            .force_noise = 1,
                            .wrench_share = 0.01,
                            .seed = seed};
  const SimulatedCampaign made =
      simulate(test::orthoglide(), "robot.yaml", folder.path() / "plan.csv", options, silent);
  std::string yaml = made.yaml;
  if (!stated) yaml.replace(yaml.find("wrench_noise"), 12, "# wrench_noise");
  io::write_atomically(folder.path() / "readings.csv", made.readings);
  // The name of the robot is for people only.
  yaml.erase(yaml.find("robot: "), yaml.find("units:") - yaml.find("robot: "));
  io::write_atomically(folder.path() / "campaign.yaml", yaml);
  return compare(robot, read_campaign(folder.path() / "campaign.yaml", robot.manipulator), 1,
                 silent);
}

std::pair<double, double> band(const ChiSquareTest& test) {
  const auto n = static_cast<double>(test.degrees_of_freedom);
  const boost::math::chi_squared law(n);
  return {boost::math::quantile(law, 0.001) / n, boost::math::quantile(law, 0.999) / n};
}

TEST(WrenchNoise, ChiSquareIsOneWhenItIsStatedAndFarAboveWhenItIsNot) {
  vjm::Robot robot = test::orthoglide();
  robot.uncertain.clear();
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const ChiSquareTest stated = *compared(seed, true, robot).nominal.chi_square;
    EXPECT_EQ(stated.degrees_of_freedom, 240);
    EXPECT_GT(stated.reduced(), band(stated).first);
    EXPECT_LT(stated.reduced(), band(stated).second);
    EXPECT_GT(compared(seed, false, robot).nominal.chi_square->reduced(), 5);
  }
}

// The robot that is compared is 25 % too stiff: once fitted the noise is that of the right one.
TEST(WrenchNoise, FollowsTheFittedCompliance) {
  const vjm::Robot robot = test::scaled(test::orthoglide(), {1.25, 1.25});
  const Comparison c = compared(5, true, robot);
  ASSERT_TRUE(c.fitted);
  EXPECT_GT(c.fitted->chi_square->reduced(), band(*c.fitted->chi_square).first);
  EXPECT_LT(c.fitted->chi_square->reduced(), band(*c.fitted->chi_square).second);
  for (const ParameterEstimate& p : c.fitted->fit.parameters)
    EXPECT_NEAR(p.value, std::log(1 / 1.25), 4 * p.standard_error);
}

// Central differences of the prediction by each component of the wrench.
void expect_exact_derivatives(const vjm::Robot& robot, const Campaign& campaign,
                              const std::vector<vjm::Effect>& effects) {
  common::Progress silent;
  const auto predict = [&](std::size_t component, double step) {
    Campaign other = campaign;
    for (Reading& r : other.readings)
      (component < 3 ? r.load.force : r.load.moment)[static_cast<Eigen::Index>(component % 3)] +=
          step;
    return Predictor(robot.manipulator, other, 1, silent)
        .with_effects(effects)
        .predict_with_compliance({}, {}, silent);
  };
  const Predictions at = predict(0, 0);
  for (std::size_t k = 0; k < 6; ++k) {
    const double h = k < 3 ? 2 : 0.2;
    const Predictions up = predict(k, h), down = predict(k, -h);
    for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
      const spatial::Vector6 slope = (up.displacement[i] - down.displacement[i]) / (2 * h);
      EXPECT_LT((at.by_wrench[i].col(static_cast<Eigen::Index>(k)) - slope).norm(),
                1e-5 * slope.norm());
    }
  }
}

TEST(WrenchNoise, TheCovarianceIsCarriedByTheExactDerivative) {
  const vjm::Robot robot = test::orthoglide();
  std::vector<test::Planned> plan = test::orthoglide_plan(3, 2, 3);
  Campaign campaign = read_campaign(
      test::write(plan, {.more = "frames: {t: {on: base, pose: {point: [1, 2, 3], rpy: [10, 20, "
                                 "30]}}}\ndisplacement_frame: t\ntarget_point: [30, -20, 80]\n"}),
      robot.manipulator);
  std::vector<vjm::Effect> of_cell;
  for (const auto& [kind, size] : {std::pair("wrench_zero", "fx=40 N,fy=-60 N,mz=3 N m"),
                                   std::pair("wrench_saturation", "force=1e-6 1/N^2"),
                                   std::pair("wrench_channel_gain", "fx=0.1,fz=-0.05")})
    of_cell.push_back(vjm::effect_from_words(kind, "load", size, robot.kinds(),
                                             robot.without_effects(), robot.units));
  for (const DisplacementKind kind : {DisplacementKind::difference, DisplacementKind::absolute})
    for (const std::vector<vjm::Effect>& effects : {std::vector<vjm::Effect>{}, of_cell}) {
      campaign.displacement = kind;
      expect_exact_derivatives(robot, campaign, effects);
    }
}

// A robot of three joints, pushed off its reference point.
vjm::Robot arm() {
  vjm::ChainBuilder chain("arm");
  chain.actuator("q1", vjm::Motion::rz, 2e5).offset(spatial::Pose::translation({0.4, 0, 0.3}));
  chain.actuator("q2", vjm::Motion::ry, 1e5).offset(spatial::Pose::translation({0.5, 0, 0}));
  chain.actuator("q3", vjm::Motion::rx, 5e4).offset(spatial::Pose::translation({0.1, 0.05, 0}));
  return {.file = "arm.yaml",
          .name = "arm",
          .units = {},
          .manipulator = vjm::Manipulator("arm", {chain.build()}),
          .uncertain = {},
          .link_files = {}};
}

std::filesystem::path pushed(const std::string& more) {
  return test::write_campaign(
      "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N, angle: deg}\n"
      "displacement: difference\nreadings: readings.csv\n"
      "noise: {translation: 1 nm, rotation: 1 nrad}\n"
      "wrench_noise: {force: 2 N, share: 1 %}\n" +
          more,
      "session,q1,q2,q3,fx,fy,fz,dx,dy,dz,rx,ry,rz\na,20,30,40,3,-2,5,1,1,1,1,1,1\n"
      "b,-50,10,70,-4,3,2,1,1,1,1,1,1\na,60,-20,10,1,5,-3,1,1,1,1,1,1\n");
}

Eigen::MatrixXd covariance(const Noise& noise, std::size_t reading) {
  return noise.sigma[reading].asDiagonal() * *noise.correlation[reading] *
         noise.sigma[reading].asDiagonal();
}

Noise carried(const vjm::Robot& robot, const Campaign& campaign, const BaseFit* found = nullptr) {
  common::Progress silent;
  return with_wrench_noise(noise_of(campaign, replicate_groups(campaign)), campaign,
                           Predictor(robot.manipulator, campaign, 1, silent), {}, {}, silent,
                           found);
}

// A force has noise of a moment about any other point: the same load about another point, with its
// covariance there, moves the robot by the same covariance.
TEST(WrenchNoise, OfAForceHasItsLeverArm) {
  const vjm::Robot robot = arm();
  const Campaign at_point =
      read_campaign(pushed("wrench_point: [150, -80, 200]\n"), robot.manipulator);
  common::Progress silent;
  const Predictor predictor(robot.manipulator, at_point, 1, silent);
  Campaign at_reference = at_point;
  for (std::size_t i = 0; i < at_point.readings.size(); ++i) {
    vjm::Load& load = at_reference.readings[i].load;
    const spatial::Vector3 arm =
        predictor.posture_of(i).platform.rotation() * load.point_on_platform;
    load.moment += arm.cross(load.force);
    load.point_on_platform.setZero();
    Matrix6 moved = Matrix6::Identity();
    moved.bottomLeftCorner<3, 3>() = spatial::skew(arm);
    Matrix6& w = at_reference.wrench_covariance[i];
    w = moved * w * moved.transpose();
    EXPECT_GT((w.bottomRightCorner<3, 3>().norm()), 0.01);
  }
  const Campaign armless = read_campaign(pushed("wrench_point: reference\n"), robot.manipulator);
  const Noise here = carried(robot, at_point), there = carried(robot, at_reference),
              without = carried(robot, armless);
  for (std::size_t i = 0; i < at_point.readings.size(); ++i) {
    const Eigen::MatrixXd c = covariance(here, i);
    EXPECT_LT((c - covariance(there, i)).norm(), 1e-3 * c.norm());
    EXPECT_GT((c - covariance(without, i)).norm(), 0.1 * c.norm());
  }
}

// Seen of a target and in a frame that a fit has found as where the campaign states both.
TEST(WrenchNoise, IsThatOfTheTargetAndFrameThatWereFound) {
  const vjm::Robot robot = arm();
  const Campaign open = read_campaign(
      pushed("wrench_point: [150, -80, 200]\nsession_frame: estimate\ntarget_pose: estimate\n"),
      robot.manipulator);
  const spatial::Vector3 rpy(20, -10, 60);
  const spatial::Vector3 turn = spatial::log_rotation(spatial::rotation_from_rpy(rpy * M_PI / 180));
  BaseFit found;
  found.targets.emplace_back();
  found.targets[0].value.head<3>() = spatial::Vector3(0.03, -0.05, 0.08);
  for (std::size_t session = 0; session < 2; ++session) {
    found.frames.push_back({.session = session});
    found.frames.back().value.tail<3>() = -turn;
  }
  const Noise as_found = carried(robot, open, &found);
  const Campaign stated = read_campaign(
      pushed(fmt::format("wrench_point: [150, -80, 200]\nframes: {{t: {{on: base, pose: {{point: "
                         "[0, 0, 0], rpy: [{}, {}, {}]}}}}}}\ndisplacement_frame: t\n"
                         "target_point: [30, -50, 80]\n",
                         rpy.x(), rpy.y(), rpy.z())),
      robot.manipulator);
  const Noise as_stated = carried(robot, stated), elsewhere = carried(robot, open);
  for (std::size_t i = 0; i < open.readings.size(); ++i) {
    const Eigen::MatrixXd c = covariance(as_stated, i);
    EXPECT_LT((covariance(as_found, i) - c).norm(), 1e-6 * c.norm());
    EXPECT_GT((covariance(elsewhere, i) - c).norm(), 0.1 * c.norm());
  }
}

// One spring along z: by hand.
TEST(WrenchNoise, OfASpringAddsInSquare) {
  const auto file = test::write_campaign(
      "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N}\ndisplacement: difference\n"
      "readings: readings.csv\nnoise: {translation: 3 um}\n"
      "wrench_noise: {force: 2 N, share: 0.5 %}\n",
      "fz,dz\n0,0\n1000,1\n-2000,-2\n");
  const vjm::Robot robot = test::bench();
  const Campaign campaign = read_campaign(file, robot.manipulator);
  common::Progress silent;
  const Noise noise = noise_of(robot, campaign, 1, silent);
  const double c = 1 / (1e6 * std::exp(0.0));
  for (const auto& [i, force] : {std::pair(0u, 0.0), {1u, 1000.0}, {2u, 2000.0}})
    EXPECT_NEAR(noise.sigma[i][2], std::sqrt(9e-12 + c * c * (4 + std::pow(0.005 * force, 2))),
                1e-12);
}

// Readings that would make the spring rigid: what design tells bounds it to three standard
// deviations, a factor of e each.
TEST(WrenchNoise, OfASpringThatTheReadingsMakeRigidIsThatOfOneNearTheDesign) {
  const auto file = test::write_campaign(
      "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N}\ndisplacement: difference\n"
      "readings: readings.csv\nnoise: {translation: 3 um}\nwrench_noise: {force: 20 N}\n",
      "fz,dz\n0,0\n1000,0\n-2000,0\n3000,0\n");
  const vjm::Robot robot = test::bench();
  common::Progress silent;
  const Noise noise = noise_of(robot, read_campaign(file, robot.manipulator), 1, silent);
  const double most = 20 / 1e6, least = most * std::exp(-3.0);
  for (const Eigen::VectorXd& sigma : noise.sigma) {
    EXPECT_LT(sigma[2], std::hypot(3e-6, most));
    EXPECT_GT(sigma[2], std::hypot(3e-6, 0.99 * least));
  }
}

TEST(WrenchNoise, IsRefusedWithoutTheNoiseOfTheInstrument) {
  const auto file = test::write_campaign(
      "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N}\ndisplacement: difference\n"
      "readings: readings.csv\nwrench_noise: {force: 2 N}\n",
      "fz,dz\n0,0\n1000,1\n");
  try {
    (void)read_campaign(file, test::bench().manipulator);
    FAIL();
  } catch (const common::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("State 'noise"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace kinetostat::calibration::wrench_noise_test

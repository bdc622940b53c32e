// A target that sits on the platform where nobody knows.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/campaign/replicates.h"
#include "kinetostat/calibration/design/plan_models.h"
#include "kinetostat/calibration/regression/base_fit.h"
#include "kinetostat/calibration/regression/session_frame.h"
#include "kinetostat/report/base_fit.h"

#include "calibration/synthetic.h"
#include "support/matrix_near.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using kinetostat::test::matrix_near;
using kinetostat::test::Random;
using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;

// Three joints that turn about different axes, softer than rigid, at the end of an arm.
vjm::Robot arm() {
  vjm::ChainBuilder chain("arm");
  chain.actuator("q1", vjm::Motion::rz, 2e5).offset(Pose::translation({0.4, 0, 0.3}));
  chain.actuator("q2", vjm::Motion::ry, 1e5).offset(Pose::translation({0.5, 0, 0}));
  chain.actuator("q3", vjm::Motion::rx, 5e4).offset(Pose::translation({0.1, 0.05, 0}));
  return {.file = "arm.yaml",
          .name = "arm",
          .units = {},
          .manipulator = vjm::Manipulator("arm", {chain.build()}),
          .uncertain = {{"q2", {{0, "q2"}}}},
          .link_files = {}};
}

// A tracker in two set-ups, a target on the flange.
struct Truth {
  Pose target = Pose(spatial::exp_rotation(Vector3(0.4, -0.9, 1.3)), {0.03, -0.05, 0.08});
  std::vector<Pose> trackers = {Pose(spatial::exp_rotation(Vector3(0.2, 0.1, 2)), {2, 1, 0.4}),
                                Pose(spatial::exp_rotation(Vector3(-0.3, 0.2, -1)), {-1, 3, 0})};
  double factor = 0.8;  // of the stiffness of q2
};

std::filesystem::path measured(const vjm::Robot& robot, const Truth& truth, bool rotations,
                               bool turns, const std::string& more) {
  const vjm::Robot soft = test::scaled(robot, {truth.factor});
  Random random(4);
  std::string csv = "session,q1 [deg],q2 [deg],q3 [deg],fx,fy,fz,dx,dy,dz";
  csv += rotations ? ",rx [rad],ry [rad],rz [rad]\n" : "\n";
  for (int i = 0; i < 16; ++i) {
    const std::size_t session = static_cast<std::size_t>(i % 2);
    const Vector3 q = turns ? random.vector(60) : Vector3(10, 20, 30);
    const Vector3 force = random.vector(300);
    const vjm::Posture posture =
        vjm::posture_from_joints(
            soft.manipulator,
            {{"q1", q[0] * M_PI / 180}, {"q2", q[1] * M_PI / 180}, {"q3", q[2] * M_PI / 180}})
            .posture;
    const vjm::Equilibrium e =
        vjm::equilibrium_under_load(soft.manipulator, posture, {.force = force});
    const Pose seen = truth.trackers[session].inverse() * e.platform * truth.target;
    csv += fmt::format("s{}", session);
    const auto add = [&csv](const Vector3& v, double unit) {
      for (const double x : v) csv += fmt::format(",{}", x / unit);
    };
    add(q, 1), add(force, 1), add(seen.position(), 1e-3);
    if (rotations) add(spatial::log_rotation(seen.rotation()), 1);
    csv += "\n";
  }
  return test::write_campaign(
      "kinetostat: 1\ncampaign: tracker\nunits: {length: mm, force: N, angle: "
      "deg}\ndisplacement: absolute\nwrench_point: reference\nsession_frame: "
      "estimate\nreadings: readings.csv\nnoise: {translation: 10 um, rotation: 20 urad}\n" +
          more,
      csv);
}

BaseFit fit_of(const vjm::Robot& robot, const Campaign& campaign) {
  common::Progress silent;
  const Noise noise = noise_of(campaign, replicate_groups(campaign));
  return fit_base(Predictor(robot.manipulator, campaign, 1, silent), campaign, noise,
                  uncertain_parameters(robot), silent);
}

TEST(Target, IsFoundBesideFramesAndStiffnessByPositionsOfItsPoint) {
  const vjm::Robot robot = arm();
  const Truth truth;
  const Campaign campaign = read_campaign(
      measured(robot, truth, false, true, "target_pose: estimate\n"), robot.manipulator);
  const BaseFit fit = fit_of(robot, campaign);
  EXPECT_LT(fit.squared_error, 1e-10);
  EXPECT_NEAR(std::exp(fit.parameters[0].value), truth.factor, 1e-8);
  ASSERT_EQ(fit.targets.size(), 1U);
  EXPECT_TRUE(matrix_near(fit.targets[0].value.head<3>(), truth.target.position(), 1e-9));
  EXPECT_TRUE(fit.targets[0].value.tail<3>().array().isNaN().all());
  ASSERT_EQ(fit.frames.size(), 2U);
  EXPECT_EQ(fit.estimated, 1 + 12 + 3);
}

// On the link behind the second joint, beside a target on the flange whose place is known.
TEST(Target, IsFoundOnAnyBody) {
  const vjm::Robot robot = arm();
  const vjm::Robot soft = test::scaled(robot, {0.8});
  const Vector3 flange(0.02, 0.01, 0.03);
  const Pose elbow(spatial::exp_rotation(Vector3(0.5, -0.3, 1.2)), {0.06, -0.04, 0.1});
  const Pose tracker(spatial::exp_rotation(Vector3(0.2, 0.1, 2)), {2, 1, 0.4});
  for (const bool rotations : {false, true}) {
    Random random(7);
    std::string csv = "q1 [deg],q2 [deg],q3 [deg],fx,fy,fz,dx,dy,dz,elbow.dx,elbow.dy,elbow.dz";
    csv += rotations ? ",elbow.rx [rad],elbow.ry [rad],elbow.rz [rad]\n" : "\n";
    for (int i = 0; i < 12; ++i) {
      const Vector3 q = random.vector(60), force = random.vector(300);
      const vjm::Posture posture =
          vjm::posture_from_joints(
              soft.manipulator,
              {{"q1", q[0] * M_PI / 180}, {"q2", q[1] * M_PI / 180}, {"q3", q[2] * M_PI / 180}})
              .posture;
      const vjm::Equilibrium e =
          vjm::equilibrium_under_load(soft.manipulator, posture, {.force = force});
      const VectorXd& x = e.chains[0].coordinates;
      const Pose link = Pose::rotation(spatial::exp_rotation(x[0] * Vector3::UnitZ())) *
                        Pose::translation({0.4, 0, 0.3}) *
                        Pose::rotation(spatial::exp_rotation(x[1] * Vector3::UnitY()));
      const Pose seen = tracker.inverse() * link * elbow;
      const auto add = [&csv](const Vector3& v, double unit) {
        for (const double value : v) csv += fmt::format(",{}", value / unit);
      };
      csv += fmt::format("{},{},{}", q[0], q[1], q[2]);
      add(force, 1), add(tracker.inverse() * (e.platform * flange), 1e-3);
      add(seen.position(), 1e-3);
      if (rotations) add(spatial::log_rotation(seen.rotation()), 1);
      csv += "\n";
    }
    const Campaign campaign = read_campaign(
        test::write_campaign(
            fmt::format("kinetostat: 1\ncampaign: tracker\nunits: {{length: mm, force: N, angle: "
                        "deg}}\ndisplacement: absolute\nwrench_point: reference\nsession_frame: "
                        "estimate\ntarget_point: [20, 10, 30]\nreadings: readings.csv\nnoise: "
                        "{{translation: 10 um}}\nsensors: {{elbow: {{kind: {}, on: q2, "
                        "target_pose: estimate, noise: {}}}}}\n",
                        rotations ? "pose" : "position",
                        rotations ? "{translation: 10 um, rotation: 20 urad}" : "10 um"),
            csv),
        robot.manipulator);
    const BaseFit fit = fit_of(robot, campaign);
    EXPECT_LT(fit.squared_error, 1e-9);
    EXPECT_NEAR(std::exp(fit.parameters[0].value), 0.8, 1e-7);
    ASSERT_EQ(fit.targets.size(), 1U);
    const TargetEstimate& found = fit.targets[0];
    EXPECT_EQ(campaign.sensors[found.sensor].name, "elbow");
    EXPECT_TRUE(matrix_near(found.value.head<3>(), elbow.position(), 1e-9));
    if (rotations) {
      EXPECT_TRUE(
          matrix_near(spatial::exp_rotation(found.value.tail<3>()), elbow.rotation(), 1e-8));
    }
    EXPECT_EQ(fit.estimated, 1 + 6 + (rotations ? 6 : 3));
    EXPECT_TRUE(report::to_json(campaign, fit)["targets"].contains("elbow"));
  }
}

// A planned session has to find it as well: what it does to the readings, by central differences.
TEST(Target, IsAmongTheUnknownsOfAPlannedSession) {
  const vjm::Robot robot = arm();
  const Campaign planned = read_campaign(
      measured(robot, Truth(), true, true, "target_pose: estimate\n"), robot.manipulator);
  const std::vector<Index> components = {0, 1, 2, 3, 4, 5};
  common::Progress silent;
  const Forecast at = forecast(robot, {}, planned, components, 1, silent);
  ASSERT_EQ(at.by_targets.cols(), 6);
  for (Index k = 0; k < 3; ++k) {
    const auto moved = [&](double h) {
      Campaign other = planned;
      other.observation.target[k] += h;
      return forecast(robot, {}, other, components, 1, silent).mean;
    };
    const VectorXd slope = (moved(1e-3) - moved(-1e-3)) / 2e-3;
    EXPECT_TRUE(matrix_near(VectorXd(at.by_targets.col(k)), slope, 1e-6 * slope.norm()));
  }
  EXPECT_GT(at.by_targets.rightCols(3).norm(), 1);
  const Eigen::MatrixXd unknowns = session_unknowns(planned, planned, components, at);
  EXPECT_EQ(unknowns.cols(), 12);
  EXPECT_TRUE(unknowns.rightCols(6).isApprox(at.by_targets));
}

TEST(Target, HasAPoseWhereRotationsAreRead) {
  const vjm::Robot robot = arm();
  const Truth truth;
  const Campaign campaign = read_campaign(
      measured(robot, truth, true, true, "target_pose: estimate\n"), robot.manipulator);
  const BaseFit fit = fit_of(robot, campaign);
  EXPECT_LT(fit.squared_error, 1e-10);
  ASSERT_EQ(fit.targets.size(), 1U);
  EXPECT_TRUE(matrix_near(fit.targets[0].value.head<3>(), truth.target.position(), 1e-9));
  EXPECT_TRUE(matrix_near(spatial::exp_rotation(fit.targets[0].value.tail<3>()),
                          truth.target.rotation(), 1e-9));
  for (std::size_t s = 0; s < 2; ++s) {
    const Pose frame(spatial::exp_rotation(fit.frames[s].value.tail<3>()),
                     fit.frames[s].value.head<3>());
    EXPECT_TRUE(matrix_near(frame.position(), truth.trackers[s].inverse().position(), 1e-8));
  }
  EXPECT_GT(fit.targets[0].standard_error.minCoeff(), 0);
}

// In one posture it might as well be the instrument that stands elsewhere.
TEST(Target, StaysAsStatedWhereNothingTurnsAndSaysSo) {
  const vjm::Robot robot = arm();
  Truth truth;
  truth.target = Pose();
  const Campaign campaign = read_campaign(
      measured(robot, truth, true, false, "target_pose: estimate\n"), robot.manipulator);
  const BaseFit fit = fit_of(robot, campaign);
  ASSERT_EQ(fit.targets.size(), 1U);
  EXPECT_TRUE(fit.targets[0].standard_error.tail<3>().array().isNaN().any() ||
              fit.targets[0].standard_error.tail<3>().minCoeff() > 1e-3);
}

// Derivatives of every sensor's reading by the place of the target.
TEST(Target, DerivativesAgreeWithCentralDifferences) {
  const vjm::Robot robot = arm();
  for (const char* kind : {"absolute", "difference"})
    for (const char* axes : {"base", "platform"}) {
      const bool absolute = std::string(kind) == "absolute";
      if (absolute && std::string(axes) == "platform") continue;
      const Campaign campaign = read_campaign(
          test::write_campaign(
              fmt::format("kinetostat: 1\ncampaign: t\nunits: {{length: mm, force: N, angle: "
                          "deg}}\ndisplacement: {}\ndisplacement_frame: {}\nwrench_point: "
                          "reference\nreadings: readings.csv\nsensors: {{tip: {{kind: "
                          "position, on: platform}}}}\n",
                          kind, axes),
              "q1,q2,q3,fx,fy,fz,dx,rx,tip.dx,tip.dy,tip.dz\n10,20,30,3000,-2000,4000,1,1,1,1,1\n"),
          robot.manipulator);
      common::Progress silent;
      const Predictor predictor(robot.manipulator, campaign, 1, silent);
      const std::vector<Parameter> parameters = uncertain_parameters(robot);
      const VectorXd at = starts_of(parameters);
      const Vector6 pose = (Vector6() << 0.03, -0.05, 0.08, 0.4, -0.9, 1.3).finished();
      const Index count = absolute ? 6 : 3;
      const VectorXd::Index all = 1 + count;
      const Predictions exact =
          predictor.predict(parameters, at, parameters, silent,
                            {.targets = {{.sensor = 0, .pose = pose, .differentiated = count}}});
      ASSERT_EQ(exact.derivatives[0].cols(), all);
      for (Index k = 0; k < all; ++k) {
        const double h = 1e-4;
        const auto shifted = [&](double step) {
          VectorXd q = at;
          Vector6 there = pose;
          (k == 0 ? q[0] : there[k - 1]) += step;
          return predictor
              .predict(parameters, q, {}, silent, {.targets = {{.sensor = 0, .pose = there}}})
              .displacement[0];
        };
        const VectorXd differences =
            (8 * (shifted(h) - shifted(-h)) - (shifted(2 * h) - shifted(-2 * h))) / (12 * h);
        EXPECT_TRUE(matrix_near(VectorXd(exact.derivatives[0].col(k)), differences, 1e-9))
            << kind << " " << axes << " " << k;
      }
    }
}

TEST(Target, NeedsReadingsOfThePlatform) {
  const vjm::Robot robot = arm();
  try {
    (void)read_campaign(
        test::write_campaign("kinetostat: 1\ncampaign: t\nunits: {length: mm, force: N, angle: "
                             "deg}\ndisplacement: difference\ntarget_pose: estimate\nreadings: "
                             "readings.csv\nsensors: {tip: {kind: position, on: q2}}\n",
                             "fz,tip.dx\n1,1\n"),
        robot.manipulator);
    FAIL();
  } catch (const common::InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("target_pose: no reading is of the platform"));
  }
}

}  // namespace
}  // namespace kinetostat::calibration

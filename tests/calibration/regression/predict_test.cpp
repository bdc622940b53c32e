#include "kinetostat/calibration/regression/predict.h"

#include <numbers>

#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/vjm/chain/chain_builder.h"

#include "calibration/laboratory.h"
#include "calibration/synthetic.h"
#include "support/matrix_near.h"

namespace kinetostat::calibration::predict_test {
namespace {

using Eigen::VectorXd;
using spatial::Vector3;

// Large enough loads that the rotation vector is not its own increment.
std::vector<test::Planned> strongly_loaded() {
  std::vector<test::Planned> plan = test::orthoglide_plan(2, 2, 3);
  for (test::Planned& reading : plan) reading.load.moment *= 3;
  test::measure(test::orthoglide().manipulator, plan);
  return plan;
}

// With a heavy tool on one chain: it sags without load.
vjm::Robot heavy_orthoglide() {
  vjm::Robot robot = test::orthoglide();
  vjm::ChainBuilder chain(robot.manipulator.chains()[0]);
  chain.mass("tool", 3, {0.2, 0.1, -0.1});
  robot.manipulator = robot.manipulator.with_chain(0, chain.build()).with_gravity({0, 0, -9.81});
  return robot;
}

struct Kind {
  const char* name;
  const char* displacement;
  bool heavy;
  const char* more = "";
};

const char* tracker =
    "frames: {tracker: {on: base, pose: {point: [900, 200, 300], rpy: [20, -30, 130]}}}\n"
    "displacement_frame: tracker\ntarget_point: [30, -20, 80]\n";

class PredictionDerivatives : public testing::TestWithParam<Kind> {};

TEST_P(PredictionDerivatives, AgreeWithCentralDifferences) {
  const vjm::Robot robot = GetParam().heavy ? heavy_orthoglide() : test::orthoglide();
  std::filesystem::path file = test::write(strongly_loaded(), {});
  std::string yaml = io::read_text(file);
  yaml.replace(yaml.find("difference"), 10, GetParam().displacement);
  io::write_atomically(file, yaml + GetParam().more);
  const Campaign campaign = read_campaign(file, robot.manipulator);
  common::Progress silent;
  const Predictor predictor(robot.manipulator, campaign, 1, silent);
  const std::vector<Parameter> parameters = uncertain_parameters(robot);
  const VectorXd at = VectorXd::LinSpaced(2, 0.1, -0.2);
  const Predictions exact = predictor.predict(parameters, at, true, silent);
  ASSERT_FALSE(exact.failure);
  const double h = 1e-3;
  for (Eigen::Index p = 0; p < 2; ++p) {
    const auto shifted = [&](double steps) {
      return predictor.predict(parameters, at + steps * h * VectorXd::Unit(2, p), false, silent)
          .displacement;
    };
    const auto f1 = shifted(1), b1 = shifted(-1), f2 = shifted(2), b2 = shifted(-2);
    for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
      EXPECT_GT(exact.displacement[i].tail<3>().norm(), 0.01);
      const spatial::Vector6 differences =
          (8 * (f1[i] - b1[i]) - (f2[i] - b2[i])) / (12 * h);  // fourth order
      // Rounding of poses of the size of 1 m takes its part.
      EXPECT_LT((exact.derivatives[i].col(p) - differences).norm(),
                1e-6 * differences.norm() + 2e-12);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, PredictionDerivatives,
                         testing::Values(Kind{"difference", "difference", false},
                                         Kind{"absolute", "absolute", false},
                                         Kind{"heavy_difference", "difference", true},
                                         Kind{"heavy_absolute", "absolute", true},
                                         Kind{"heavy_platform_axes", "difference", true,
                                              "displacement_frame: platform\n"
                                              "target_point: [30, -20, 80]\n"},
                                         Kind{"heavy_tracker", "absolute", true, tracker},
                                         Kind{"tracker", "difference", false, tracker}),
                         [](const auto& kind) { return std::string(kind.param.name); });

// Weight moves the platform before and after the load: a difference leaves it out.
TEST(Prediction, ADifferenceIsTakenFromTheStateThatSagsUnderItsWeight) {
  const vjm::Robot robot = heavy_orthoglide();
  const std::filesystem::path file = test::write(strongly_loaded(), {});
  const Campaign campaign = read_campaign(file, robot.manipulator);
  common::Progress silent;
  const Predictions predictions =
      Predictor(robot.manipulator, campaign, 2, silent).predict({}, VectorXd(), false, silent);
  ASSERT_FALSE(predictions.failure);
  for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
    const Reading& reading = campaign.readings[i];
    const vjm::Posture posture =
        vjm::posture_at(robot.manipulator, *campaign.configurations[reading.configuration].target)
            .posture;
    const spatial::Pose sagged = equilibrium_under_load(robot.manipulator, posture, {}).platform;
    const spatial::Pose loaded =
        equilibrium_under_load(robot.manipulator, posture, reading.load).platform;
    EXPECT_GT(spatial::pose_difference(posture.platform, sagged).norm(), 1e-4);
    EXPECT_TRUE(kinetostat::test::matrix_near(predictions.displacement[i],
                                              spatial::pose_difference(sagged, loaded), 1e-10));
  }
}

// A slide that hangs: with its weight put on against friction a pull downwards meets no more of it,
// settled it moves as if it had no weight.
TEST(Prediction, FrictionStartsAgainstTheWeightOrSettled) {
  const auto displacements = [](bool heavy, double settled) {
    test::Laboratory laboratory(fmt::format(
        "kinetostat: 1\nname: slide\nunits: {{length: mm, force: N, angle: deg}}\n{}"
        "links: {{hook: {{rigid: [0, 0, 10], mass: {{mass: 20 kg, center: [0, 0, 0]}}}}}}\n"
        "chain_types:\n  cell:\n    - actuator: {{name: q, axis: Tz, stiffness: 1000}}\n"
        "    - link: hook\nmanipulator: {{chain: cell}}\n",
        heavy ? "gravity: {direction: [0, 0, -1]}\n" : ""));
    laboratory.options().translation_noise = 0;
    laboratory.hide("friction", "q",
                    fmt::format("force=50 N,presliding=0.1 um,settled={}", settled));
    const Campaign campaign = laboratory.measure(
        "id,cycle,step,fz\na,1,1,0\nb,1,2,-100\nc,1,3,-200\nd,1,4,0\ne,2,1,0\nf,2,2,200\n");
    std::vector<double> z;
    for (const Reading& reading : campaign.readings) z.push_back(reading.displacement[2]);
    return z;
  };
  const std::vector<double> light = displacements(false, 0), settled = displacements(true, 1),
                            against = displacements(true, 0);
  ASSERT_EQ(light.size(), 6u);
  for (std::size_t i = 0; i < light.size(); ++i) EXPECT_NEAR(settled[i], light[i], 1e-9) << i;
  // Downwards all of the load reaches the drive; upwards friction first turns round: 2 x 50 N.
  EXPECT_NEAR(against[1], -100e-6, 1e-9);
  EXPECT_NEAR(against[2], -200e-6, 1e-9);
  EXPECT_NEAR(against[5], (200 - 2 * 50) * 1e-6, 1e-9);
  EXPECT_NEAR(settled[2], -(200 - 50) * 1e-6, 1e-9);
}

// A link that grows within a cycle shows; what it had grown before that cancels.
TEST(Prediction, DifferencesCountFromTheTemperatureOfTheirCycle) {
  test::Laboratory laboratory(
      "kinetostat: 1\nname: arm\nunits: {length: m, force: N, angle: rad}\n"
      "chain_types:\n  arm:\n    - actuator: {name: q1, axis: Rz, stiffness: 1.0e6}\n"
      "    - tool: [0.5, 0, 0]\n    - actuator: {name: q2, axis: Rz, stiffness: 1.0e6}\n"
      "manipulator: {chain: arm}\n");
  laboratory.options().components = {true, false, false, false, false, false};
  laboratory.options().translation_noise = 0;
  laboratory.hide("thermal_expansion", "q2", "alpha=2e-5 1/K");
  const Campaign campaign = laboratory.measure(
      "id,session,cycle,step,time,temperature,fx\na,s,1,1,0,20,0\nb,s,1,2,60,21,0\n"
      "c,s,1,3,120,23,0\nd,s,2,1,180,24,0\ne,s,2,2,240,22,0\n");
  const double expected[] = {0, 1e-5, 3e-5, 0, -2e-5};
  ASSERT_EQ(campaign.readings.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(campaign.readings[i].displacement[0], expected[i], 1e-12) << i;
}

// Two cycles that go on where the last one ended are one; each by itself starts relaxed.
TEST(Prediction, HistoryContinuesFromCycleToCycleWhereTheCampaignSaysSo) {
  test::Laboratory laboratory(
      "kinetostat: 1\nname: bench\nunits: {length: m, force: N, angle: rad}\n"
      "chain_types: {c: [{actuator: {name: z, axis: Tz, stiffness: 1.0e6}}]}\n"
      "manipulator: {chain: c}\n"
      "effects: [{effect: friction, at: z, force: 40, presliding: 1.0e-5}]\n");
  const auto predicted = [&](const std::vector<std::string>& cycles, const std::string& more) {
    std::string csv = "cycle,fz,dz\n";
    const double forces[] = {100, 200, 60, 0, 100, -50};
    for (std::size_t i = 0; i < 6; ++i) csv += fmt::format("{},{},0\n", cycles[i], forces[i]);
    const Campaign campaign = read_campaign(
        test::write_campaign("kinetostat: 1\ncampaign: h\nunits: {length: m, force: N}\n"
                             "displacement: difference\nreadings: readings.csv\n" +
                                 more,
                             csv),
        laboratory.robot().manipulator);
    common::Progress silent;
    const Predictions all = Predictor(laboratory.robot().without_effects(),
                                      laboratory.robot().effects, campaign, 1, silent)
                                .predict({}, VectorXd(), false, silent);
    EXPECT_FALSE(all.failure);
    VectorXd dz(6);
    for (std::size_t i = 0; i < 6; ++i) dz[static_cast<Eigen::Index>(i)] = all.displacement[i][2];
    return dz;
  };
  const std::vector<std::string> one(6, "a"), two = {"b", "b", "b", "a", "a", "a"};
  EXPECT_EQ(predicted(two, "history: continues\n"), predicted(one, ""));
  EXPECT_GT((predicted(two, "") - predicted(one, "")).norm(), 1e-6);
  EXPECT_EQ(predicted(one, "history: starts\n"), predicted(one, ""));
}

TEST(Prediction, IsTheChangeFromTheUnloadedPostureOrThePoseItself) {
  const vjm::Robot robot = test::orthoglide();
  const std::vector<test::Planned> plan = strongly_loaded();
  const std::filesystem::path file = test::write(plan, {});
  Campaign campaign = read_campaign(file, robot.manipulator);
  common::Progress silent;
  const auto predict = [&] {
    return Predictor(robot.manipulator, campaign, 2, silent).predict({}, VectorXd(), false, silent);
  };
  const Predictions difference = predict();
  campaign.displacement = DisplacementKind::absolute;
  const Predictions absolute = predict();
  for (std::size_t i = 0; i < plan.size(); ++i) {
    EXPECT_TRUE(
        kinetostat::test::matrix_near(difference.displacement[i], plan[i].displacement, 1e-10));
    EXPECT_TRUE(kinetostat::test::matrix_near(absolute.displacement[i].head<3>(),
                                              plan[i].position + plan[i].displacement.head<3>(),
                                              1e-10));
    EXPECT_TRUE(kinetostat::test::matrix_near(absolute.displacement[i].tail<3>(),
                                              plan[i].displacement.tail<3>(), 1e-10));
  }
}

// What a tracker sees of a target on the platform, put together from the platform's pose.
TEST(Prediction, IsWhatTheStatedFrameSeesOfTheStatedPoint) {
  const vjm::Robot robot = heavy_orthoglide();
  const std::filesystem::path file = test::write(strongly_loaded(), {.more = tracker});
  Campaign campaign = read_campaign(file, robot.manipulator);
  common::Progress silent;
  const auto predict = [&] {
    return Predictor(robot.manipulator, campaign, 1, silent)
        .predict({}, VectorXd(), false, silent)
        .displacement;
  };
  const auto difference = predict();
  campaign.displacement = DisplacementKind::absolute;
  const auto absolute = predict();
  campaign.displacement = DisplacementKind::difference;
  campaign.observation = {.frame = {}, .platform_axes = true, .target = {0.03, -0.02, 0.08}};
  const auto own = predict();
  const spatial::Pose frame(spatial::rotation_from_rpy(Vector3(20, -30, 130) * M_PI / 180),
                            {0.9, 0.2, 0.3});
  const spatial::Pose target = spatial::Pose::translation({0.03, -0.02, 0.08});
  for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
    const Reading& r = campaign.readings[i];
    const vjm::Posture posture =
        vjm::posture_at(robot.manipulator, *campaign.configurations[r.configuration].target)
            .posture;
    const auto seen = [&](const vjm::Load& load) {
      return frame.inverse() * equilibrium_under_load(robot.manipulator, posture, load).platform *
             target;
    };
    const spatial::Pose before = seen({}), after = seen(r.load);
    const spatial::Vector6 moved = spatial::pose_difference(before, after);
    EXPECT_TRUE(kinetostat::test::matrix_near(difference[i], moved, 1e-10));
    EXPECT_TRUE(kinetostat::test::matrix_near(absolute[i].head<3>(), after.position(), 1e-10));
    EXPECT_TRUE(kinetostat::test::matrix_near(spatial::exp_rotation(absolute[i].tail<3>()),
                                              after.rotation(), 1e-10));
    const spatial::Matrix3 back = (frame * before).rotation().transpose() * frame.rotation();
    EXPECT_TRUE(kinetostat::test::matrix_near(own[i].head<3>(), back * moved.head<3>(), 1e-10));
    EXPECT_TRUE(kinetostat::test::matrix_near(own[i].tail<3>(), back * moved.tail<3>(), 1e-10));
  }
}

TEST(Prediction, DoesNotDependOnTheNumberOfThreads) {
  const vjm::Robot robot = test::orthoglide();
  const Campaign campaign = read_campaign(test::write(strongly_loaded(), {}), robot.manipulator);
  common::Progress silent;
  const auto predict = [&](int threads) {
    return Predictor(robot.manipulator, campaign, threads, silent)
        .predict({}, VectorXd(), false, silent)
        .displacement;
  };
  EXPECT_EQ(predict(1), predict(7));
}

TEST(Prediction, TakesTheRotationVectorNearestToTheMeasuredOne) {
  const double pi = std::numbers::pi;
  const Vector3 vector(0, 0, 3.1);
  const double nan = std::nan("");
  EXPECT_NEAR(nearest_rotation_vector(vector, Vector3(0, 0, -3.1)).z(), 3.1 - 2 * pi, 1e-15);
  EXPECT_EQ(nearest_rotation_vector(vector, Vector3(0, 0, 3.0)), vector);
  EXPECT_NEAR(nearest_rotation_vector(vector, Vector3(nan, nan, -3.1)).z(), 3.1 - 2 * pi, 1e-15);
  EXPECT_EQ(nearest_rotation_vector(vector, Vector3(nan, nan, nan)), vector);
}

}  // namespace
}  // namespace kinetostat::calibration::predict_test

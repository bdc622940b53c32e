// Joints of which one turns and another slides: screws, racks and pinions.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/chain/kinematics.h"
#include "kinetostat/vjm/io/sub_manipulator.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/stiffness.h"

#include "vjm/random_chain.h"
#include "vjm/robot_text.h"

namespace kinetostat::vjm::screw_test {
namespace {

using Eigen::VectorXd;
using spatial::Matrix6;
using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;
using ::testing::HasSubstr;

std::string robot_with(const std::string& elements) {
  return "kinetostat: 1\nname: screw\nunits: {length: mm, force: N, angle: deg}\n"
         "chain_types:\n  chain:\n" +
         elements + "manipulator: {chain: chain}\n";
}

// A drive of 200 N m/rad, a screw with the coupling given, and a nut that is free to turn on it.
std::string drive_with(const std::string& coupling) {
  return robot_with(
      "    - actuator: {name: motor, axis: Rx, stiffness: 200 N m/rad}\n"
      "    - coupled: {to: motor, axis: Tx, " +
      coupling + "}\n    - passive: {name: nut, axis: Rx}\n");
}

// Force over displacement along the axis, with the platform free to turn about it.
double felt_stiffness(const std::string& coupling) {
  const Robot robot = robot_from(drive_with(coupling));
  const Posture posture = posture_from_joints(robot.manipulator, {}).posture;
  const double force = 1e-3;
  const Equilibrium e =
      equilibrium_under_load(robot.manipulator, posture, {.force = {force, 0, 0}});
  EXPECT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
  return force / e.displacement.translation.x();
}

// A screw of lead l in front of a torsional spring k has the axial stiffness k (2 pi / l)^2.
TEST(Screw, HasTheAxialStiffnessOfItsTorsionalSpring) {
  const double expected = 200 * std::pow(2 * M_PI / 5e-3, 2);
  for (const char* coupling : {"lead: 5", "lead: 5 mm", "lead: -5 mm", "lead: 0.005 m",
                               "factor: 5 mm/turn", "factor: -5 mm/turn", "factor: 5 mm/rev"})
    EXPECT_NEAR(felt_stiffness(coupling), expected, 1e-6 * expected) << coupling;
}

// A pinion of radius r: k / r^2.
TEST(Screw, ARackHasTheStiffnessOfItsPinion) {
  const double expected = 200 / (0.02 * 0.02);
  for (const char* coupling : {"radius: 20 mm", "radius: -20", "factor: 20 mm/rad"})
    EXPECT_NEAR(felt_stiffness(coupling), expected, 1e-6 * expected) << coupling;
}

// The other way round: what slides turns something. A linear spring k felt as k (l / 2 pi)^2.
TEST(Screw, ASlideMayTurn) {
  for (const char* coupling : {"lead: 5 mm", "factor: 72 deg/mm"}) {
    const Robot robot = robot_from(
        robot_with("    - actuator: {name: slide, axis: Tx, stiffness: 1.0e5 N/m}\n"
                   "    - coupled: {to: slide, axis: Rx, " +
                   std::string(coupling) + "}\n    - passive: {name: free, axis: Tx}\n"));
    const Posture posture = posture_from_joints(robot.manipulator, {}).posture;
    const Equilibrium e =
        equilibrium_under_load(robot.manipulator, posture, {.moment = {1e-6, 0, 0}});
    const double expected = 1e5 * std::pow(5e-3 / (2 * M_PI), 2);
    EXPECT_NEAR(1e-6 / e.displacement.rotation.x(), expected, 1e-6 * expected) << coupling;
  }
}

// One turn of a right-handed screw leads it forward by its lead, of a left-handed one backward.
TEST(Screw, IsRightHandedUnlessItsLeadIsNegative) {
  for (const double lead : {5.0, -5.0}) {
    const Robot robot = robot_from(drive_with("lead: " + std::to_string(lead)));
    const PostureResult quarter = posture_from_joints(robot.manipulator, {{"motor", M_PI / 2}});
    EXPECT_NEAR(quarter.posture.platform.position().x(), 1e-3 * lead / 4, 1e-15);
    EXPECT_NEAR(spatial::log_rotation(quarter.posture.platform.rotation()).x(), M_PI / 2, 1e-12);
  }
}

// A ball screw whose nut does not turn: the stage slides, and the drive's coordinate is the
// motor's.
TEST(Screw, ANutThatIsGuidedOnlySlides) {
  const Robot robot =
      robot_from(robot_with("    - actuator: {name: motor, axis: Rz, stiffness: 50 N m/rad}\n"
                            "    - coupled: {to: motor, axis: Tz, lead: 10 mm}\n"
                            "    - coupled: {to: motor, axis: Rz, factor: -1}\n"));
  const PostureResult up = posture_at(robot.manipulator, Pose::translation({0, 0, 0.025}));
  ASSERT_TRUE(up.reached) << up.reason;
  EXPECT_NEAR(up.posture.coordinates[0][0], 5 * M_PI, 1e-9);
}

// Chains with screws in all directions, sprung and free: derivatives against differences.
TEST(Screw, DerivativesAreExact) {
  samples::RandomChains random(31);
  ChainKinematics at, before, after;
  for (int trial = 0; trial < 30; ++trial) {
    ChainBuilder builder("screws", random.pose(0.2));
    builder.actuator("motor", random.motion(), 1e4);
    builder.offset(random.pose(0.2));
    builder.coupled("motor", random.motion(), random.uniform(-0.3, 0.3));
    builder.passive("p", random.motion()).offset(random.pose(0.2));
    builder.coupled("p", random.motion(), random.uniform(-2, 2));
    builder.link("l", random.pose(0.3), random.compliance());
    const Chain chain = builder.build();
    const VectorXd x = random.state(chain, 0.7);
    const Vector6 wrench = random.vector6(1, 1);
    evaluate(chain, x, at);
    Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(chain.size(), chain.size());
    add_wrench_hessian(chain, at, {at_end(chain, at, wrench)}, hessian);
    const double h = 1e-6;
    for (Eigen::Index k = 0; k < chain.size(); ++k) {
      const VectorXd step = h * VectorXd::Unit(chain.size(), k);
      evaluate(chain, x - step, before);
      evaluate(chain, x + step, after);
      const Vector6 slope = spatial::pose_difference(before.end, after.end) / (2 * h);
      EXPECT_LT((slope - at.jacobian.col(k)).norm(), 1e-8) << trial;
      const VectorXd bend = (after.jacobian - before.jacobian).transpose() * wrench / (2 * h);
      EXPECT_LT((bend - hessian.col(k)).norm(), 1e-8) << trial;
    }
  }
}

// The tangent stiffness under a load that winds the screw, against differences of equilibria.
TEST(Screw, TangentStiffnessIsTheDerivativeOfTheWrench) {
  const Robot robot =
      robot_from(robot_with("    - actuator: {name: motor, axis: Rx, stiffness: 20 N m/rad}\n"
                            "    - coupled: {to: motor, axis: Tx, lead: 60 mm}\n"
                            "    - offset: [200, 0, 0]\n"
                            "    - link: soft\n") +
                 "links: {soft: {stiffness: [[2e2,0,0,0,0,0],[0,3e2,0,0,0,0],[0,0,1e2,0,0,0],"
                 "[0,0,0,5e5,0,0],[0,0,0,0,6e5,0],[0,0,0,0,0,7e5]]}}\n");
  const Posture posture = posture_from_joints(robot.manipulator, {}).posture;
  const Load load{.force = {300, 40, -60}, .moment = {5, -3, 2}};
  const Equilibrium e = equilibrium_under_load(robot.manipulator, posture, load);
  ASSERT_EQ(e.status, EquilibriumStatus::converged);
  const double h = 1e-6;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const auto wrench = [&](double step) {
      return equilibrium_at_pose(robot.manipulator, posture,
                                 spatial::displaced(e.platform, step * Vector6::Unit(k)))
          .wrench.coordinates();
    };
    const Vector6 slope = (wrench(h) - wrench(-h)) / (2 * h);
    EXPECT_LT((slope - e.stiffness->matrix().col(k)).norm(), 1e-5 * e.stiffness->matrix().norm());
  }
}

// A mechanism that is free along a screw may stand in the place of a link.
TEST(Screw, AFreeScrewMotionOfALinkIsAJoint) {
  Vector6 screw;
  screw << 0.1, 0, 0, 1, 0, 0;
  const Matrix6 stiffness =
      1e6 * (Matrix6::Identity() - screw * screw.transpose() / screw.squaredNorm());
  ChainBuilder chain("c");
  LinkModel{.parts = {part_with_free_motions(Pose(), stiffness, 1)}}.append_to(chain, "link");
  const Manipulator manipulator("m", {chain.build()});
  const UnloadedStiffness s =
      unloaded_stiffness(manipulator, posture_from_joints(manipulator, {}).posture);
  EXPECT_EQ(s.free.rank, 5);
  EXPECT_LT((s.stiffness->matrix() - stiffness).norm(), 1e-9 * stiffness.norm());
}

TEST(Screw, AFactorWithoutItsUnitIsRefused) {
  const auto error_of = [](const std::string& coupling) {
    try {
      robot_from(drive_with(coupling));
    } catch (const common::InputError& error) {
      return std::string(error.what());
    }
    ADD_FAILURE() << coupling << " was accepted";
    return std::string();
  };
  for (const char* coupling : {"factor: 5", "factor: 5 mm", "factor: 5 rad/mm", "factor: 5 N"})
    EXPECT_THAT(error_of(coupling), HasSubstr("unit of length and angle")) << coupling;
  EXPECT_THAT(error_of("factor: 0 mm/turn"), HasSubstr("zero"));
  EXPECT_THAT(error_of("lead: 0"), HasSubstr("zero"));
  EXPECT_THAT(error_of("lead: 5 mm/turn"), HasSubstr("a length is expected"));
  EXPECT_THAT(error_of("lead: 5, radius: 3"), HasSubstr("lead"));
  try {
    robot_from(
        robot_with("    - passive: {name: q, axis: Rx}\n"
                   "    - coupled: {to: q, axis: Ry, lead: 5}\n"));
    FAIL() << "was accepted";
  } catch (const common::InputError& error) {
    EXPECT_THAT(std::string(error.what()), HasSubstr("both turn"));
  }
}

}  // namespace
}  // namespace kinetostat::vjm::screw_test

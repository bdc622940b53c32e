// The twin's mechanics against closed forms: what it hides can only be trusted if it is right.
#include <numbers>

#include <gtest/gtest.h>

#include "random.h"
#include "robot.h"

namespace twin {
namespace {

constexpr double length = 0.8, E = 70e9, G = 26e9, side = 0.02;
const Beam beam{.length = length,
                .area = side * side,
                .Iy = std::pow(side, 4) / 12,
                .Iz = std::pow(side, 4) / 12,
                .J = 0.1406 * std::pow(side, 4),
                .E = E,
                .G = G};

Built cantilever(int elements, Beam of = beam) {
  const RobotSpec robot{"cantilever",
                        {{"chain", {}, {}, {{.kind = Item::link, .name = "beam", .beam = of}}}}};
  return build(robot, posture_of(robot, Eigen::VectorXd()), {{}, elements});
}

Vector6 displacement(Built& built, const Vector3& force, const Vector3& moment) {
  const Pose before = built.structure.pose_of(built.platform);
  EXPECT_TRUE(built.structure.settle({{built.platform, force, moment}}));
  const Pose after = built.structure.pose_of(built.platform);
  Vector6 d;
  d << after.x - before.x, vector_of(after.R * before.R.transpose());
  return d;
}

TEST(TwinMechanics, CantileverDeflectsAsInTheTextbook) {
  Built built = cantilever(5);
  const double F = 1e-3, I = beam.Iy;
  const Vector6 d = displacement(built, {0, F, 0}, {F, 0, 0});
  EXPECT_NEAR(d[1], F * std::pow(length, 3) / (3 * E * I), 1e-6 * d[1]);
  EXPECT_NEAR(d[5], F * length * length / (2 * E * I), 1e-6 * d[5]);
  EXPECT_NEAR(d[3], F * length / (G * beam.J), 1e-6 * d[3]);
}

TEST(TwinMechanics, SelfWeightIsThatOfAUniformBeam) {
  Beam heavy = beam;
  heavy.density = 0.27;  // so light that displacements are small
  Built built = cantilever(16, heavy);
  const Vector6 d = displacement(built, Vector3::Zero(), Vector3::Zero());
  const double q = heavy.density * heavy.area * 9.80665;
  EXPECT_NEAR(d[2], -q * std::pow(length, 4) / (8 * E * beam.Iy), 3e-3 * std::abs(d[2]));
}

TEST(TwinMechanics, RollsUpIntoACircleUnderAMoment) {
  const int elements = 40;
  Built built = cantilever(elements);
  const double M = E * beam.Iz * std::numbers::pi / length;  // half a turn
  for (int i = 1; i <= 20; ++i)
    ASSERT_TRUE(built.structure.settle({{built.platform, Vector3::Zero(), {0, 0, M * i / 20}}}));
  // The end of a half circle stands a diameter away. The elements are chords of the circle.
  const Pose end = built.structure.pose_of(built.platform);
  EXPECT_NEAR(end.x.y(), 2 * length / std::numbers::pi, 2e-3 * length);
  EXPECT_NEAR(end.x.x(), 0, 2e-3 * length);
}

TEST(TwinMechanics, BucklesAtEulersLoad) {
  const double euler = std::numbers::pi * std::numbers::pi * E * beam.Iy / (4 * length * length);
  const double side_force = 1e-3;
  // Lateral stiffness of a compressed cantilever: P / (tan(kl)/k - l) with k^2 = P/EI.
  for (const double share : {0.3, 0.6, 0.9}) {
    Built compressed = cantilever(16);
    const double P = share * euler, k = std::sqrt(P / (E * beam.Iz));
    const Vector6 d = displacement(compressed, {-P, side_force, 0}, Vector3::Zero());
    EXPECT_NEAR(d[1], side_force / P * (std::tan(k * length) / k - length), 0.01 * d[1]) << share;
  }
}

TEST(TwinMechanics, GradientIsThatOfTheEnergy) {
  Random random(3);
  const RobotSpec robot = arm_3r();
  Built built = build(robot, posture_of(robot, Eigen::Vector3d(0.3, -0.5, 1.1)), {{}, 2});
  for (Coupling& c : built.structure.couplings()) {
    c.law.reset();
    c.stiffness = Matrix6::Identity() * 50;  // soft, so that differences can be taken
  }
  built.structure.add(
      Strut{{ground, {{0.1, 0.2, 0.3}, Matrix3::Identity()}}, built.platform, 30, 0.2});
  const auto random_step = [&](double size) {
    Eigen::VectorXd step(6 * built.structure.bodies());
    for (Eigen::Index i = 0; i < step.size(); ++i) step[i] = size * random.normal();
    return step;
  };
  built.structure.move(random_step(0.2));
  const std::vector<DeadLoad> loads{{built.platform, {1, -2, 3}, Vector3::Zero()}};
  const Eigen::VectorXd gradient = built.structure.gradient(loads), way = random_step(1);
  Structure ahead = built.structure, behind = built.structure;
  ahead.move(1e-5 * way);
  behind.move(-1e-5 * way);
  const double slope = (ahead.energy(loads) - behind.energy(loads)) / 2e-5;
  EXPECT_NEAR(gradient.dot(way), slope, 1e-6 * std::abs(slope));
}

TEST(TwinMechanics, SensitivityIsTheDifferenceOfSolutions) {
  for (const RobotSpec& robot : {arm_3r(), orthoglide()}) {
    const Posture posture = robot.serial ? posture_of(robot, Eigen::Vector3d(0.3, -0.5, 1.1))
                                         : posture_at(robot, {0.05, -0.04, 0.03});
    const int groups = static_cast<int>(robot.springs().size());
    const auto end = [&](int changed, double by) {
      BuildOptions options{.factors = std::vector<double>(static_cast<std::size_t>(groups), 1),
                           .elements = 3};
      if (changed >= 0) options.factors[static_cast<std::size_t>(changed)] = std::exp(by);
      Built built = build(robot, posture, options);
      built.structure.gravity(Vector3::Zero());
      EXPECT_TRUE(built.structure.settle({{built.platform, {20, 30, -40}, {1, 2, 3}}}));
      return built;
    };
    const Built base = end(-1, 0);
    const Eigen::MatrixXd exact = base.structure.sensitivity(base.platform, groups);
    for (int g = 0; g < groups; ++g) {
      const Built more = end(g, 2e-2), less = end(g, -2e-2);
      const Vector3 d =
          (more.structure.pose_of(more.platform).x - less.structure.pose_of(less.platform).x) /
          4e-2;
      EXPECT_LT((exact.col(g).head<3>() - d).norm(), 1e-2 * d.norm() + 5e-9)
          << robot.name << " " << g;
    }
  }
}

TEST(TwinMechanics, SlopesOfJointLawsAreThoseOfTheirForces) {
  const double k = 1e4;
  for (const JointLawPointer& law :
       {linear_law(k), hardening_law(k, 2e-3), clearance_law(k, 1e-3), two_slope_law(k, 1.7, 1e-3),
        creep_law(k, 1e-5, 60), servo_droop_law(k, 0.3, 1e-3), lifting_law(k, 0.5, 1e-3),
        gear_loss_law(linear_law(k), 0.2, 1e-4)})
    for (const double d : {-4e-3, -1.1e-3, -2e-4, 3e-5, 9e-4, 3e-3}) {
      const double h = 1e-8, slope = (law->at(d + h).force - law->at(d - h).force) / (2 * h);
      EXPECT_NEAR(law->at(d).tangent, slope, 1e-3 * k) << d;
      law->accept(0, 1);
    }
}

TEST(TwinMechanics, FrictionLosesFourTimesItsForceTimesTheWay) {
  const double k = 1e4, force = 5, s = 1e-5, way = 5e-3;
  const JointLawPointer law = friction_law(linear_law(k), force, s);
  double work = 0, before = law->at(0).force, at = 0;
  const auto ramp = [&](double to, bool count) {
    const double from = at;
    for (int i = 1; i <= 500; ++i) {
      const double next = from + (to - from) * i / 500, now = law->at(next).force;
      if (count) work += 0.5 * (now + before) * (to - from) / 500;
      before = now;
      law->accept(next, 0);
    }
    at = to;
  };
  ramp(way, false);
  ramp(-way, true);
  ramp(way, true);
  EXPECT_NEAR(work, 4 * force * way, 0.02 * 4 * force * way);
}

}  // namespace
}  // namespace twin

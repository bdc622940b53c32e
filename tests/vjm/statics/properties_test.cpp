// What must hold for any manipulator: energy, reciprocity, independence of frame and unit.
#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/stiffness.h"

#include "support/matrix_near.h"
#include "vjm/random_chain.h"

namespace kinetostat::vjm::properties_test {
namespace {

using samples::RandomChains;
using spatial::Compliance6;
using spatial::Matrix6;
using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;

// What the numbers of a model are multiplied by when its units change.
struct Units {
  double length = 1, force = 1;

  Pose pose(const Pose& p) const { return {p.rotation(), length * p.position()}; }
  double stiffness(Motion m, double k) const {
    return k * force * (is_rotation(m) ? length : 1 / length);
  }
  Compliance6 compliance(const Compliance6& c) const {
    const Vector6 twist = (Vector6() << Vector3::Constant(length), Vector3::Ones()).finished();
    const Vector6 wrench = (Vector6() << Vector3::Ones(), Vector3::Constant(length)).finished();
    return Compliance6(twist.asDiagonal() * c.matrix() *
                       (force * wrench).cwiseInverse().asDiagonal());
  }
  Vector6 wrench(const Vector6& w) const {
    Vector6 result = force * w;
    result.tail<3>() *= length;
    return result;
  }
};

// Two flexible links, a drive, a few passive joints, a node with a mass.
Chain random_chain(unsigned seed, int passive, const Pose& base, const Units& units = {}) {
  RandomChains random(seed);
  ChainBuilder chain("random" + std::to_string(seed), base);
  const auto offset = [&](double size) { chain.offset(units.pose(random.pose(size))); };
  const auto link = [&](const std::string& name) {
    const Pose end = random.pose(0.3);
    chain.link(name, units.pose(end), units.compliance(random.compliance()));
  };
  const Motion drive = static_cast<Motion>(3 + seed % 3);
  chain.actuator("drive", drive, units.stiffness(drive, 2e5));
  offset(0.3);
  link("l1");
  for (int i = 0; i < passive; ++i) {
    chain.passive("p" + std::to_string(i),
                  static_cast<Motion>(3 + (seed + static_cast<unsigned>(i)) % 3));
    offset(0.2);
  }
  chain.node("elbow", units.length * random.vector(0.2));
  link("l2");
  chain.mass("mass", 2.0, units.length * random.vector(0.1));
  return chain.build();
}

struct Example {
  Manipulator manipulator;
  Posture posture;
};

// A serial arm, or a robot of three such chains whose ends are one platform.
Example example(unsigned seed, bool parallel, const Pose& base = {}, const Units& units = {}) {
  std::vector<Chain> chains;
  const int passive = parallel ? 2 : 0;
  const Units plain;
  for (unsigned i = 0; i < (parallel ? 3u : 1u); ++i) {
    ChainBuilder chain(random_chain(10 * seed + i, passive, base, units));
    // All ends are brought to the frame of the base.
    ChainKinematics kinematics;
    const Chain plain_chain = random_chain(10 * seed + i, passive, Pose(), plain);
    evaluate(plain_chain, plain_chain.home(), kinematics);
    chain.offset(units.pose(kinematics.end.inverse()));
    chains.push_back(chain.build());
  }
  Manipulator manipulator("example", chains);
  PostureResult result = posture_at(manipulator, base);
  EXPECT_TRUE(result.reached) << result.reason;
  return {std::move(manipulator), std::move(result.posture)};
}

class Properties : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(SerialAndParallel, Properties, ::testing::Bool(),
                         [](const auto& test) { return test.param ? "parallel" : "serial"; });

// The trapezoidal rule is exact to rounding for a smooth closed path.
TEST_P(Properties, WorkAlongAClosedPathIsZero) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const Example e = example(seed, GetParam());
    RandomChains random(seed + 100);
    const Vector6 a = random.vector6(2e-3, 4e-3), b = random.vector6(2e-3, 4e-3);
    constexpr int points = 48;
    double work = 0, turnover = 0;
    for (int i = 0; i < points; ++i) {
      const double s = 2 * std::numbers::pi * i / points;
      const Vector6 d = std::cos(s) * a + std::sin(2 * s) * b;
      Vector6 rate = -std::sin(s) * a + 2 * std::cos(2 * s) * b;
      rate.tail<3>() = spatial::left_jacobian(d.tail<3>()) * rate.tail<3>();
      const Equilibrium held =
          equilibrium_at_pose(e.manipulator, e.posture, spatial::displaced(e.posture.platform, d));
      ASSERT_EQ(held.status, EquilibriumStatus::converged) << held.reason;
      ASSERT_TRUE(held.held.stable());
      const double power = held.wrench.coordinates().dot(rate);
      work += power;
      turnover += std::abs(power);
    }
    EXPECT_LT(std::abs(work), 1e-8 * turnover) << seed;
  }
}

TEST_P(Properties, EnergyIsTheWorkDoneOnTheWay) {
  const Example e = example(3, GetParam());
  const Vector6 d{3e-3, -2e-3, 1e-3, 2e-3, 4e-3, -3e-3};
  // Gauss-Legendre with five points over two halves of the way.
  constexpr std::array<double, 5> nodes = {0, -0.5384693101056831, 0.5384693101056831,
                                           -0.9061798459386640, 0.9061798459386640};
  constexpr std::array<double, 5> weights = {0.5688888888888889, 0.4786286704993665,
                                             0.4786286704993665, 0.2369268850561891,
                                             0.2369268850561891};
  const auto at = [&](double s) {
    return equilibrium_at_pose(e.manipulator, e.posture,
                               spatial::displaced(e.posture.platform, s * d));
  };
  double work = 0;
  for (const double middle : {0.25, 0.75})
    for (std::size_t i = 0; i < 5; ++i)
      work += 0.25 * weights[i] * at(middle + 0.25 * nodes[i]).wrench.coordinates().dot(d);
  EXPECT_NEAR(work, at(1).energy, 1e-8 * work);
}

// Maxwell and Betti: a small load at the elbow moves the platform as one on the platform moves the
// elbow.
TEST_P(Properties, DisplacementsAreReciprocal) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const Example e = example(seed, GetParam());
    const Chain& chain = e.manipulator.chains()[0];
    const std::size_t elbow = chain.node_index("elbow");
    RandomChains random(seed + 50);
    const Vector3 at_elbow = random.vector(1.0), at_platform = random.vector(1.0);
    const auto solved = [&](const Load& load) {
      Equilibrium result = equilibrium_under_load(e.manipulator, e.posture, load);
      EXPECT_EQ(result.status, EquilibriumStatus::converged) << result.reason;
      return result;
    };
    const auto platform_after = [&](double sign) {
      const NodeLoad load{.chain = 0, .node = elbow, .force = sign * at_elbow};
      return solved({.nodes = {load}}).displacement.translation;
    };
    const auto elbow_after = [&](double sign) {
      ChainKinematics kinematics;
      evaluate(chain, solved({.force = sign * at_platform}).chains[0].coordinates, kinematics);
      return kinematics.nodes[elbow];
    };
    // Both signs, so that only the third order is left of what is not linear.
    const Vector3 platform_moved = 0.5 * (platform_after(1) - platform_after(-1));
    const Vector3 elbow_moved = 0.5 * (elbow_after(1) - elbow_after(-1));
    EXPECT_NEAR(at_platform.dot(platform_moved), at_elbow.dot(elbow_moved),
                1e-7 * at_elbow.norm() * elbow_moved.norm())
        << seed;
  }
}

TEST_P(Properties, TangentUnderAPureForceIsSymmetric) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const Example e = example(seed, GetParam());
    const Equilibrium loaded =
        equilibrium_under_load(e.manipulator, e.posture, {.force = {60, -40, 50}});
    ASSERT_EQ(loaded.status, EquilibriumStatus::converged) << loaded.reason;
    EXPECT_LT(spatial::symmetry_defect(loaded.compliance->matrix()), 1e-9) << seed;
  }
}

TEST_P(Properties, ResultsTurnWithTheFrame) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    RandomChains random(seed + 200);
    const Pose base = random.pose(2.0);
    const Matrix6 turn = [&] {
      Matrix6 both = Matrix6::Zero();
      both.topLeftCorner<3, 3>() = both.bottomRightCorner<3, 3>() = base.rotation();
      return both;
    }();
    const Example here = example(seed, GetParam()), there = example(seed, GetParam(), base);
    const Vector3 force(50, -80, 30), moment(4, 7, -5), gravity(1, -2, -9);
    const auto solved = [&](const Example& e, const Matrix6& t) {
      const Eigen::Matrix3d r = t.topLeftCorner<3, 3>();
      return equilibrium_under_load(e.manipulator.with_gravity(r * gravity), e.posture,
                                    {.force = r * force, .moment = r * moment});
    };
    const Equilibrium a = solved(here, Matrix6::Identity()), b = solved(there, turn);
    ASSERT_EQ(a.status, EquilibriumStatus::converged) << a.reason;
    ASSERT_EQ(b.status, EquilibriumStatus::converged) << b.reason;
    const Vector6 expected = turn * a.displacement.coordinates();
    EXPECT_LT((b.displacement.coordinates() - expected).norm(), 1e-9 * expected.norm()) << seed;
    EXPECT_TRUE(test::matrix_near_relative(
        b.compliance->matrix(), Matrix6(turn * a.compliance->matrix() * turn.transpose()), 1e-8));
    EXPECT_NEAR(a.energy, b.energy, 1e-8 * a.energy);
  }
}

TEST_P(Properties, ResultsScaleWithTheUnits) {
  for (const Units units : {Units{1e3, 1}, Units{1e-3, 1e6}, Units{39.37, 0.2248}}) {
    const Example si = example(4, GetParam()), other = example(4, GetParam(), {}, units);
    const Vector6 wrench{50, -80, 30, 4, 7, -5};
    const Vector6 scaled = units.wrench(wrench);
    const Vector6 displacement =
        equilibrium_under_load(si.manipulator, si.posture, {wrench.head<3>(), wrench.tail<3>()})
            .displacement.coordinates();
    const Vector6 again = equilibrium_under_load(other.manipulator, other.posture,
                                                 {scaled.head<3>(), scaled.tail<3>()})
                              .displacement.coordinates();
    EXPECT_LT((again.head<3>() / units.length - displacement.head<3>()).norm(),
              1e-9 * displacement.head<3>().norm());
    EXPECT_LT((again.tail<3>() - displacement.tail<3>()).norm(),
              1e-9 * displacement.tail<3>().norm());
  }
}

}  // namespace
}  // namespace kinetostat::vjm::properties_test

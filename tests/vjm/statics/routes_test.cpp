#include "vjm/statics/routes.h"

#include <gtest/gtest.h>

#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/stiffness.h"

#include "support/matrix_near.h"
#include "vjm/random_chain.h"

namespace kinetostat::vjm::routes_test {
namespace {

using samples::RandomChains;
using spatial::Matrix6;
using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;
using test::matrix_near_relative;

struct Case {
  Chain chain;
  ChainKinematics kinematics;
  VirtualJointModel model;
};

Case evaluated(Chain chain, const Eigen::VectorXd& x) {
  Case result{std::move(chain), {}, {}};
  evaluate(result.chain, x, result.kinematics);
  result.model = virtual_joint_model(result.chain, result.kinematics);
  return result;
}

// In units in which translations and rotations weigh alike.
Matrix6 weighed(const Matrix6& stiffness, double length) {
  Vector6 scale = Vector6::Ones();
  scale.tail<3>().setConstant(1 / length);
  return scale.asDiagonal() * stiffness * scale.asDiagonal();
}

void expect_all_formulas_agree(const Case& c) {
  const Matrix6 expected =
      weighed(unloaded_stiffness(c.chain, c.kinematics).value().matrix(), c.model.length);
  // Where little or nothing is left, it is compared with what there was before the joints.
  const double size = weighed(locked_stiffness(c.model), c.model.length).cwiseAbs().maxCoeff();
  for (const Matrix6& result : {block_inverse_stiffness(c.model), two_term_stiffness(c.model),
                                recursive_stiffness(c.model)})
    EXPECT_TRUE(test::matrix_near(weighed(result, c.model.length), expected, 1e-10 * size));
}

TEST(PublishedFormulas, AgreeOnRandomChains) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    RandomChains random(seed);
    for (int passive = 0; passive <= 5; ++passive) {
      const Chain chain = random.chain(passive);
      SCOPED_TRACE(::testing::Message() << "seed " << seed << ", " << passive << " passive joints");
      expect_all_formulas_agree(evaluated(chain, random.state(chain, 0.5)));
    }
  }
}

// More passive joints than motions, and the same joint twice.
TEST(PublishedFormulas, AgreeWithRedundantPassiveJoints) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    RandomChains random(seed);
    ChainBuilder chain(random.chain(2));
    chain.passive("first", Motion::rz).passive("again", Motion::rz);
    chain.offset(random.pose(0.2));
    chain.passive("slide", Motion::tx).offset(Pose::translation(random.vector(0.3)));
    chain.passive("parallel", Motion::tx);
    if (seed % 2 == 0)
      for (int i = 0; i < 4; ++i)
        chain.passive("more" + std::to_string(i), random.motion()).offset(random.pose(0.1));
    SCOPED_TRACE(seed);
    expect_all_formulas_agree(evaluated(chain.build(), random.state(chain.build(), 0.5)));
  }
}

// A stretched arm whose passive axes are parallel or meet: its usual Jacobian is singular.
TEST(PublishedFormulas, AgreeInSingularPostures) {
  RandomChains random(7);
  for (const Motion second : {Motion::ry, Motion::rz, Motion::rx}) {
    ChainBuilder chain("stretched");
    chain.actuator("a", Motion::rz, 1e5);
    chain.link("l1", Pose::translation({0.3, 0, 0}), random.compliance());
    chain.passive("p1", Motion::ry);
    chain.link("l2", Pose::translation({0.3, 0, 0}), random.compliance());
    chain.passive("p2", second).passive("p3", Motion::rx);
    chain.offset(Pose::translation({0.2, 0, 0})).passive("p4", Motion::rx);
    expect_all_formulas_agree(
        evaluated(chain.build(), Eigen::VectorXd::Zero(chain.so_far().size())));
  }
}

TEST(PublishedFormulas, FewerThanSixSpringsHaveOnlyTheBlockInverse) {
  ChainBuilder leg("leg");
  leg.passive("b1", Motion::rx).passive("b2", Motion::ry).actuator("length", Motion::tz, 1e6, 0.7);
  leg.passive("p1", Motion::rx).passive("p2", Motion::ry).passive("p3", Motion::rz);
  const Case c = evaluated(leg.build(), leg.so_far().home());
  EXPECT_THROW(two_term_stiffness(c.model), std::domain_error);
  EXPECT_THROW(recursive_stiffness(c.model), std::domain_error);
  Matrix6 expected = Matrix6::Zero();
  expected(2, 2) = 1e6;
  EXPECT_TRUE(matrix_near_relative(block_inverse_stiffness(c.model), expected, 1e-12));
}

TEST(PublishedFormulas, WrenchThatMeetsNoSpringIsRefused) {
  ChainBuilder chain("rigid but for one joint");
  chain.actuator("a", Motion::rz, 1e5).offset(Pose::translation({0.3, 0, 0}));
  const Case c = evaluated(chain.build(), Eigen::VectorXd::Zero(1));
  EXPECT_THROW(block_inverse_stiffness(c.model), std::domain_error);
}

Chain six_joints(RandomChains& random) {
  ChainBuilder chain("six");
  for (int i = 0; i < 6; ++i) {
    chain.actuator("q" + std::to_string(i), static_cast<Motion>(3 + i % 3),
                   random.uniform(1e4, 1e6));
    chain.offset(random.pose(0.4));
  }
  return chain.build();
}

TEST(PublishedFormulas, SalisburyAgreesForElasticActuators) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    RandomChains random(seed);
    const Chain chain = six_joints(random);
    const Case c = evaluated(chain, random.state(chain, 1.0));
    const Matrix6 expected = unloaded_stiffness(chain, c.kinematics).value().matrix();
    EXPECT_TRUE(matrix_near_relative(
        weighed(salisbury_stiffness(c.model.springs, c.model.stiffness), c.model.length),
        weighed(expected, c.model.length), 1e-9));
  }
}

TEST(PublishedFormulas, SalisburyRefusesASingularJacobian) {
  Matrix6 singular = Matrix6::Identity();
  singular(5, 5) = 0;
  EXPECT_THROW(salisbury_stiffness(singular, Matrix6::Identity()), std::domain_error);
}

// Legs between universal and spherical joints: a row of J^-1 is [u, arm x u].
class GosselinAndLegs : public ::testing::TestWithParam<const char*> {};

TEST_P(GosselinAndLegs, Agree) {
  const Robot robot = read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/" + GetParam());
  const Pose pose(spatial::exp_rotation({0.05, -0.08, 0.1}), {0.02, 0.03, 0.6});
  const Posture posture = posture_at(robot.manipulator, pose).posture;
  Eigen::Matrix<double, 6, 6> rows;
  for (std::size_t c = 0; c < 6; ++c) {
    // The wrench that a leg transmits is along it: the only column of its stiffness.
    const Chain& chain = robot.manipulator.chains()[c];
    const Case leg = evaluated(chain, posture.coordinates[c]);
    const Vector6 slide = leg.kinematics.jacobian.col(chain.index_of("length"));
    const Vector3 u = slide.head<3>();
    // The spherical joint is where its two first rotations have no arm but its own.
    const Vector6 turn = leg.kinematics.jacobian.col(chain.index_of("spherical.Rx"));
    const Vector6 other = leg.kinematics.jacobian.col(chain.index_of("spherical.Ry"));
    // v = w x (ref - centre) for both; solve for the arm from the reference point to the centre.
    Eigen::Matrix<double, 6, 3> cross;
    cross << spatial::skew(turn.tail<3>()), spatial::skew(other.tail<3>());
    Vector6 velocity;
    velocity << turn.head<3>(), other.head<3>();
    const Vector3 arm = -cross.colPivHouseholderQr().solve(velocity);
    rows.row(static_cast<Eigen::Index>(c)) << u.transpose(), arm.cross(u).transpose();
  }
  const Matrix6 expected = unloaded_stiffness(robot.manipulator, posture).stiffness->matrix();
  const Matrix6 gosselin = gosselin_stiffness(rows, 1e8 * Matrix6::Identity());
  EXPECT_TRUE(matrix_near_relative(weighed(gosselin, 0.3), weighed(expected, 0.3), 1e-10));
}
INSTANTIATE_TEST_SUITE_P(Platforms, GosselinAndLegs,
                         ::testing::Values("stewart_gough_a.yaml", "stewart_gough_b.yaml"));

TEST(PublishedFormulas, TrivialJointsAreZerosAndSchurComplements) {
  RandomChains random(3);
  const Matrix6 link = random.compliance().inverse().matrix();
  ChainBuilder chain("link with a universal joint at its end");
  chain.link("l", Pose::translation({0.3, 0, 0}), random.compliance());
  const Case bare = evaluated(chain.build(), Eigen::VectorXd::Zero(6));
  chain.passive("y", Motion::ry).passive("z", Motion::rz);
  const Case jointed = evaluated(chain.build(), Eigen::VectorXd::Zero(8));
  const Matrix6 ruled = with_trivial_joint(with_trivial_joint(locked_stiffness(bare.model), 4), 5);
  EXPECT_TRUE(matrix_near_relative(ruled, recursive_stiffness(jointed.model), 1e-11));
  EXPECT_TRUE(ruled.row(4).isZero(0) && ruled.col(5).isZero(0));
  // IROS11 eq. 4, one entry by hand.
  const Matrix6 once = with_trivial_joint(link, 5);
  EXPECT_NEAR(once(0, 1), link(0, 1) - link(0, 5) * link(5, 1) / link(5, 5),
              1e-9 * std::abs(link(0, 1)));
}

TEST(PublishedFormulas, ChainsAtOtherPointsAddUpAtTheReferencePoint) {
  RandomChains random(11);
  const Vector3 reference(0.1, 0.2, -0.3);
  std::vector<ChainAtPoint> parts;
  Matrix6 expected = Matrix6::Zero();
  for (int i = 0; i < 3; ++i) {
    const Vector3 end = random.vector(0.5);
    const Matrix6 stiffness = random.compliance().inverse().matrix();
    parts.push_back({stiffness, end});
    expected += spatial::Stiffness6(stiffness, {end}).in({reference}).matrix();
  }
  EXPECT_TRUE(matrix_near_relative(aggregated_stiffness(parts, reference), expected, 1e-12));
}

TEST(PublishedFormulas, LoadedSerialFormulaIsTheTangentOfTheEquilibrium) {
  RandomChains random(5);
  const Chain chain = six_joints(random);
  const Manipulator arm("arm", {chain});
  const Posture posture = posture_from_joints(arm, {}).posture;
  const Load load{.force = {300, -200, 100}, .moment = {20, 10, -30}};
  const Equilibrium e = equilibrium_under_load(arm, posture, load);
  ASSERT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
  const Case c = evaluated(chain, e.chains[0].coordinates);
  Eigen::MatrixXd by_load = Eigen::MatrixXd::Zero(6, 6);
  Vector6 wrench;
  wrench << load.force, load.moment;
  add_wrench_hessian(chain, c.kinematics, {at_end(chain, c.kinematics, wrench)}, by_load);
  const Matrix6 formula = loaded_serial_stiffness(c.model.springs, c.model.stiffness, by_load);
  EXPECT_TRUE(matrix_near_relative(weighed(formula, c.model.length),
                                   weighed(e.stiffness->matrix(), c.model.length), 1e-9));
}

}  // namespace
}  // namespace kinetostat::vjm::routes_test

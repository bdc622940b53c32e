#include "kinetostat/vjm/statics/stiffness.h"

#include <cmath>
#include <fstream>
#include <string>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/batches/batches.h"
#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"

#include "vjm/random_chain.h"
#include "vjm/robot_text.h"

namespace kinetostat::vjm::stiffness_test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Matrix6;
using spatial::Pose;
using spatial::Vector3;

// The block inverse of IROS11 eq. 7, straight from the paper.
Matrix6 block_inverse(const Chain& chain, const ChainKinematics& kinematics) {
  std::vector<Eigen::Index> springs, passive;
  for (Eigen::Index k = 0; k < chain.size(); ++k)
    (chain.stiffness()(k, k) > 0 ? springs : passive).push_back(k);
  const MatrixXd js = kinematics.jacobian(Eigen::all, springs);
  const MatrixXd jq = kinematics.jacobian(Eigen::all, passive);
  const auto n = static_cast<Eigen::Index>(passive.size());
  MatrixXd block = MatrixXd::Zero(6 + n, 6 + n);
  block.topLeftCorner<6, 6>() = js * chain.stiffness()(springs, springs).inverse() * js.transpose();
  block.topRightCorner(6, n) = jq;
  block.bottomLeftCorner(n, 6) = jq.transpose();
  return block.fullPivLu().inverse().topLeftCorner<6, 6>();
}

// The weight acts on the loaded robot only, whatever way its stiffness is computed.
TEST(UnloadedStiffness, KnowsNoWeight) {
  for (const char* file : {"heavy_arm.yaml", "orthoglide.yaml", "parallelogram.yaml"}) {
    const Robot robot = read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/" + file);
    const auto stiffness_under = [&](const Vector3& gravity) {
      const Manipulator robot_there = robot.manipulator.with_gravity(gravity);
      const Posture posture = posture_from_joints(robot_there, {}).posture;
      return unloaded_stiffness(robot_there, posture);
    };
    const UnloadedStiffness weightless = stiffness_under(Vector3::Zero());
    const UnloadedStiffness heavy = stiffness_under({0, 0, -9.81});
    ASSERT_EQ(weightless.stiffness.has_value(), heavy.stiffness.has_value()) << file;
    if (heavy.stiffness) {
      EXPECT_EQ(heavy.stiffness->matrix(), weightless.stiffness->matrix());
    }
    EXPECT_EQ(heavy.free.sentences, weightless.free.sentences) << file;
  }
}

// An upright parallelogram of rigid bars with masses: nothing but its weight acts on its swing.
TEST(UnloadedStiffness, AnUprightParallelogramWithMassesSwingsFreely) {
  const auto bar = [](const char* name, double x) {
    ChainBuilder chain(name, Pose::translation({x, 0, 0}));
    chain.passive("lower", Motion::ry).mass("m", 5, {0, 0, 0.2});
    chain.offset(Pose::translation({0, 0, 0.4})).passive("upper", Motion::ry);
    chain.offset(Pose::translation({-x, 0, 0}));
    return chain.build();
  };
  const Chain leg = bar("a", -0.1), other = bar("b", 0.1);
  ChainBuilder column("column");
  column.actuator("z", Motion::tz, 1e6);
  const Manipulator parallelogram = Manipulator("parallelogram", {leg, other, column.build()},
                                                {{-1, 1}, {-1, 1}, {1, 0}}, {"crosspiece"})
                                        .with_gravity({0, 0, -9.81});
  const PostureResult posture = posture_from_joints(parallelogram, {});
  ASSERT_TRUE(posture.reached) << posture.reason;
  const UnloadedStiffness unloaded = unloaded_stiffness(parallelogram, posture.posture);
  if (unloaded.stiffness) {
    EXPECT_NEAR(unloaded.stiffness->matrix()(0, 0), 0, 1e-6);
  }
  EXPECT_EQ(unloaded.free.rank, 5);
}

TEST(UnloadedStiffness, EqualsTheBlockInverseOnRandomChains) {
  samples::RandomChains random(11);
  ChainKinematics kinematics;
  for (int trial = 0; trial < 100; ++trial) {
    const Chain chain = random.chain(trial % 5);
    VectorXd x = random.state(chain, 1.0);
    evaluate(chain, x, kinematics);
    const Matrix6 ours = unloaded_stiffness(chain, kinematics).value().matrix();
    const Matrix6 papers = block_inverse(chain, kinematics);
    EXPECT_LT((ours - papers).norm(), 1e-9 * papers.norm()) << "trial " << trial;
  }
}

TEST(UnloadedStiffness, RedundantPassiveJointsChangeNothing) {
  samples::RandomChains random(12);
  const spatial::Compliance6 compliance = random.compliance();
  const auto build = [&](int copies) {
    ChainBuilder chain("c");
    chain.link("l", Pose::translation({0.3, 0, 0}), compliance);
    for (int i = 0; i < copies; ++i)
      chain.passive("p" + std::to_string(i), Motion::rx).offset(Pose::translation({0.1, 0, 0}));
    return chain.build();
  };
  ChainKinematics once, thrice;
  const Chain a = build(1), b = build(3);
  // The second and third joint turn about the same line as the first.
  evaluate(a, VectorXd::Zero(a.size()), once);
  const Chain c = ChainBuilder(build(1)).offset(Pose::translation({0.2, 0, 0})).build();
  evaluate(c, VectorXd::Zero(c.size()), once);
  evaluate(b, VectorXd::Zero(b.size()), thrice);
  const Matrix6 single = unloaded_stiffness(c, once).value().matrix();
  const Matrix6 redundant = unloaded_stiffness(b, thrice).value().matrix();
  EXPECT_LT((single - redundant).norm(), 1e-11 * single.norm());
}

TEST(UnloadedStiffness, SpringsOfASerialArmAddInCompliance) {
  // MMT11 Table 1: K_c = (sum J_i K_i^-1 J_i')^-1.
  samples::RandomChains random(13);
  const Chain chain = random.chain(0);
  const VectorXd x = random.state(chain, 1.0);
  ChainKinematics kinematics;
  evaluate(chain, x, kinematics);
  const Matrix6 compliance =
      kinematics.jacobian * chain.stiffness().inverse() * kinematics.jacobian.transpose();
  const Matrix6 stiffness = unloaded_stiffness(chain, kinematics).value().matrix();
  EXPECT_LT((stiffness * compliance - Matrix6::Identity()).norm(), 1e-9);
}

struct Platform {
  const char* file;
  bool paired;  // case B of IROS11 section VI
};

// IROS11 eq. 27 and 28 with the arm from the reference point to the leg end.
Matrix6 closed_form(bool paired, double big_r, double r, double h, double k) {
  const double da = big_r - r, db = big_r / 2 - r;
  const double l2 = paired ? da * da + big_r * r + h * h : da * da + h * h;
  const double d = paired ? db : da;
  Matrix6 m = Matrix6::Zero();
  m(0, 0) = m(1, 1) = paired ? da * da + big_r * r : da * da;
  m(2, 2) = 2 * h * h;
  m(3, 3) = m(4, 4) = r * r * h * h;
  m(0, 4) = m(4, 0) = r * h * d;
  m(1, 3) = m(3, 1) = -r * h * d;
  if (paired) m(5, 5) = 1.5 * r * r * big_r * big_r;
  return 3 * k / l2 * m;
}

UnloadedStiffness stewart(const char* file) {
  const Robot robot = read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/" + file);
  const PostureResult posture = posture_at(robot.manipulator, Pose::translation({0, 0, 0.6}));
  EXPECT_TRUE(posture.reached) << posture.reason;
  return unloaded_stiffness(robot.manipulator, posture.posture);
}

TEST(UnloadedStiffness, StewartGoughAEqualsTheClosedForm) {
  const UnloadedStiffness result = stewart("stewart_gough_a.yaml");
  const Matrix6 expected = closed_form(false, 0.5, 0.3, 0.6, 1e8);
  EXPECT_LT((result.stiffness->matrix() - expected).cwiseAbs().maxCoeff(),
            1e-10 * expected.cwiseAbs().maxCoeff());
  EXPECT_EQ(result.free.rank, 3);
  ASSERT_EQ(result.free.motions.size(), 3u);
  // The leg lines meet at height h R / (R - r).
  for (const ScrewMotion& motion : result.free.motions) {
    EXPECT_FALSE(motion.is_translation);
    EXPECT_NEAR(motion.pitch, 0, 1e-9);
    EXPECT_LT((motion.point - Vector3(0, 0, 1.5)).norm(), 1e-9);
  }
  ASSERT_EQ(result.free.sentences.size(), 1u);
  EXPECT_EQ(result.free.sentences[0], "every rotation about the point (0, 0, 1500) mm is free");
  EXPECT_FALSE(result.compliance);
}

TEST(UnloadedStiffness, StewartGoughBEqualsTheClosedForm) {
  const UnloadedStiffness result = stewart("stewart_gough_b.yaml");
  const Matrix6 expected = closed_form(true, 0.5, 0.3, 0.6, 1e8);
  EXPECT_LT((result.stiffness->matrix() - expected).cwiseAbs().maxCoeff(),
            1e-10 * expected.cwiseAbs().maxCoeff());
  EXPECT_EQ(result.free.rank, 6);
  EXPECT_TRUE(result.free.sentences.empty());
}

TEST(UnloadedStiffness, AnArmWithThreeSpringsIsRigidInThreeDirections) {
  // A planar 3R arm with joint springs: C = J k J' (Salisbury), nothing yields out of its plane.
  const double l = 0.4, k = 1e4;
  ChainBuilder chain("arm");
  for (const char* name : {"q1", "q2", "q3"})
    chain.actuator(name, Motion::rz, k).offset(Pose::translation({l, 0, 0}));
  const Manipulator arm("3R", {chain.build()});
  const PostureResult posture = posture_from_joints(arm, {{"q1", 0.3}, {"q2", 0.6}, {"q3", -0.9}});
  const UnloadedStiffness result = unloaded_stiffness(arm, posture.posture);
  ChainKinematics kinematics;
  evaluate(chain.build(), posture.posture.coordinates[0], kinematics);
  const Matrix6 expected = kinematics.jacobian * kinematics.jacobian.transpose() / k;
  EXPECT_FALSE(result.stiffness);
  ASSERT_TRUE(result.compliance);
  EXPECT_LT((result.compliance->matrix() - expected).norm(), 1e-12 * expected.norm());
  EXPECT_EQ(result.rigid.rank, 3);
  EXPECT_EQ(result.rigid.sentences.size(), 3u);
  EXPECT_EQ(result.free.rank, 6);
}

TEST(UnloadedStiffness, PlanarParallelRobotWithElasticActuatorsIsGosselins) {
  // 3-RRR with rigid links: K = J^-T K_a J^-1 in the plane, no compliance out of it.
  std::vector<Chain> chains;
  for (int i = 0; i < 3; ++i) {
    const double angle = 2 * M_PI * i / 3;
    const spatial::Matrix3 turn = spatial::exp_rotation({0, 0, angle});
    ChainBuilder chain("leg" + std::to_string(i), Pose(turn, turn * Vector3(-0.5, 0, 0)));
    chain.actuator("a", Motion::rz, 1e4, 0.7).offset(Pose::translation({0.35, 0, 0}));
    chain.passive("b", Motion::rz, -1.2).offset(Pose::translation({0.35, 0, 0}));
    chain.passive("c", Motion::rz, 0.5);
    chain.offset(Pose(turn, turn * Vector3(-0.1, 0, 0)).inverse());
    chains.push_back(chain.build());
  }
  const Manipulator robot("3-RRR", chains);
  const PostureResult posture = posture_at(robot, Pose::translation({0.02, -0.01, 0}));
  ASSERT_TRUE(posture.reached) << posture.reason;
  const UnloadedStiffness result = unloaded_stiffness(robot, posture.posture);
  ASSERT_TRUE(result.compliance);
  // Velocity of each actuator for a planar platform twist: the wrench along the distal link does no
  // work on the passive joints.
  Eigen::Matrix3d planar_stiffness = Eigen::Matrix3d::Zero();
  ChainKinematics kinematics;
  for (std::size_t c = 0; c < 3; ++c) {
    evaluate(robot.chains()[c], posture.posture.coordinates[c], kinematics);
    const Eigen::Matrix3d j = kinematics.jacobian({0, 1, 5}, Eigen::all);
    const Eigen::RowVector3d actuator = j.inverse().row(0);
    planar_stiffness += 1e4 * actuator.transpose() * actuator;
  }
  const Eigen::Matrix3d planar = result.compliance->matrix()({0, 1, 5}, {0, 1, 5});
  EXPECT_LT((planar * planar_stiffness - Eigen::Matrix3d::Identity()).norm(), 1e-8);
  EXPECT_EQ(result.rigid.rank, 3);
}

TEST(UnloadedStiffness, DoesNotDependOnWhereTheBaseFrameIs) {
  samples::RandomChains random(14);
  const spatial::Compliance6 compliance = random.compliance();
  const auto build = [&](const Pose& base) {
    ChainBuilder chain("c", base);
    chain.link("l1", Pose::translation({0.3, 0, 0}), compliance).passive("p", Motion::ry);
    chain.link("l2", Pose::translation({0, 0.2, 0.1}), compliance);
    return chain.build();
  };
  const Pose moved = random.pose(2.0);
  const Chain here = build(Pose()), there = build(moved);
  VectorXd x = VectorXd::Zero(here.size());
  x[here.index_of("p")] = 0.7;
  ChainKinematics a, b;
  evaluate(here, x, a);
  evaluate(there, x, b);
  const spatial::Stiffness6 ka = unloaded_stiffness(here, a).value();
  const spatial::Stiffness6 kb = unloaded_stiffness(there, b).value();
  // The same spring seen in axes that moved with the base.
  const Matrix6 turned = kb.in({kb.frame().point, moved.rotation()}).matrix();
  EXPECT_LT((turned - ka.matrix()).norm(), 1e-11 * ka.matrix().norm());
}

// A screw whose compliance doubles over 400 mm: in a chain with as many springs as it needs, and in
// one with fewer.
TEST(UnloadedStiffness, LawsOfJointsCountAsTheyStand) {
  const std::string chain = R"(
    - actuator: {name: y, axis: Ty, stiffness: {at: [0, 400], is: [90 N/um, 45 N/um]}}
    - actuator: {name: x, axis: Tx, stiffness: 8 N/um}
)";
  const std::string links = R"(links: {rod: {beam: {length: 200, section: {circle: {diameter: 40}},
  material: {E: 210 GPa, G: 80 GPa}}}}
)";
  for (const bool has_link : {false, true}) {
    const Robot robot =
        robot_from("kinetostat: 1\nname: slide\nunits: {length: mm, force: N, angle: deg}\n" +
                   (has_link ? links : "") + "chain_types:\n  c:" + chain +
                   (has_link ? "    - link: rod\n" : "") + "manipulator: {chain: c}\n");
    const auto compliance_along_y = [&](double y) {
      const Posture at = posture_from_joints(robot.manipulator, {{"y", y}}).posture;
      const UnloadedStiffness unloaded = unloaded_stiffness(robot.manipulator, at);
      const double alone = unloaded.compliance->matrix()(1, 1);
      if (!has_link) return alone;
      const auto many = unloaded_stiffness_matrices(robot.manipulator, {at});
      EXPECT_NEAR(many[0]->inverse().matrix()(1, 1), alone, 1e-9 * alone);
      return alone;
    };
    for (const double y : {0.1, 0.4})
      EXPECT_NEAR(compliance_along_y(y) - compliance_along_y(0), y / 0.4 * (1 / 45e6 - 1 / 90e6),
                  1e-15);
  }
}

// The tangent of the equilibrium under next to no load.
TEST(UnloadedStiffness, IsWhereLoadsStart) {
  for (const char* effect : {"{effect: clearance, at: c.y, gap: 20 um}",
                             "{effect: hardening, at: c.y, k3: 1e17 N/m^3}"}) {
    const Robot robot = robot_from(
        std::string("kinetostat: 1\nname: slide\nunits: {length: mm, force: N, angle: deg}\n"
                    "links: {rod: {beam: {length: 200, section: {circle: {diameter: 40}}, "
                    "material: {E: 210 GPa, G: 80 GPa}}}}\nchain_types:\n  c:\n"
                    "    - actuator: {name: y, axis: Ty, stiffness: 50 N/um}\n    - link: rod\n"
                    "manipulator: {chain: c}\neffects: [") +
        effect + "]\n");
    const Posture home = posture_from_joints(robot.manipulator, {}).posture;
    const Equilibrium loaded =
        equilibrium_under_load(robot.manipulator, home, {.force = {0, 1e-9, 0}});
    const Matrix6 expected = loaded.stiffness->matrix();
    EXPECT_LT((unloaded_stiffness(robot.manipulator, home).stiffness->matrix() - expected).norm(),
              1e-6 * expected.norm())
        << effect;
    EXPECT_LT(
        (unloaded_stiffness_matrices(robot.manipulator, {home})[0]->matrix() - expected).norm(),
        1e-6 * expected.norm())
        << effect;
  }
}

// Arms that are rigid but for their drives, rods that yield: nothing of the platform is rigid.
TEST(UnloadedStiffness, RigidArmsLeaveAStiffness) {
  std::ifstream file(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/delta.yaml");
  std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::size_t arm = text.find("\n  arm: {beam");
  ASSERT_NE(arm, std::string::npos);
  text.replace(arm, text.find('\n', arm + 1) - arm, "\n  arm: {rigid: [300, 0, 0]}");
  const Robot delta = robot_from(text);
  const Posture home = posture_from_joints(delta.manipulator, {}).posture;
  const UnloadedStiffness unloaded = unloaded_stiffness(delta.manipulator, home);
  ASSERT_TRUE(unloaded.stiffness && unloaded.compliance);
  EXPECT_EQ(unloaded.rigid.rank, 6);
  EXPECT_LT(
      (unloaded.stiffness->matrix() * unloaded.compliance->matrix() - Matrix6::Identity()).norm(),
      1e-6);
  EXPECT_EQ(unloaded_stiffness_matrix(delta.manipulator, home)->matrix(),
            unloaded.stiffness->matrix());
}

}  // namespace
}  // namespace kinetostat::vjm::stiffness_test

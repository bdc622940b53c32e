// Robots of data/robots against symmetry and closed forms.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/kinematics.h"
#include "kinetostat/vjm/exchange/robot_import.h"
#include "kinetostat/vjm/exchange/urdf_import.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/stiffness.h"

#include "support/matrix_near.h"
#include "support/temporary_folder.h"

namespace kinetostat::vjm::shipped_robots_test {
namespace {

using spatial::Matrix3;
using spatial::Matrix6;
using spatial::Pose;
using spatial::Vector3;

const std::filesystem::path robots =
    std::filesystem::path(KINETOSTAT_SOURCE_DIR) / "data" / "robots";

// A shipped robot with its flexible links made rigid, keeping the actuators' springs.
Robot with_rigid_links(const std::string& name, const std::map<std::string, std::string>& links) {
  std::string text = io::read_text(robots / name);
  for (const auto& [link, length] : links) {
    const std::string key = "  " + link + ": {beam:";
    const std::size_t at = text.find(key);
    EXPECT_NE(at, std::string::npos) << link;
    text.replace(at, text.find('\n', at) - at, "  " + link + ": {rigid: [" + length + ", 0, 0]}");
  }
  const test::TemporaryFolder folder;
  std::ofstream(folder.path() / name) << text;
  return read_robot(folder.path() / name);
}

Posture posture_of(const Robot& robot, const Vector3& point) {
  const PostureResult result = posture_at(robot.manipulator, Pose::translation(point));
  EXPECT_TRUE(result.reached) << result.reason;
  return result.posture;
}

// The 6x6 seen after a third of a turn about z.
Matrix6 turned(const Matrix6& matrix) {
  const Matrix3 r = spatial::exp_rotation({0, 0, 2 * M_PI / 3});
  Matrix6 both = Matrix6::Zero();
  both.topLeftCorner<3, 3>() = both.bottomRightCorner<3, 3>() = r;
  return both * matrix * both.transpose();
}

// Stiffness of three drives with rigid legs and a platform that cannot turn: with leg direction s
// and the velocity b of the leg's upper end per unit of drive, each gives k s s' / (s . b)^2.
Matrix3 three_drives(double stiffness, const Vector3& leg, const Vector3& drive) {
  Matrix3 sum = Matrix3::Zero();
  for (int i = 0; i < 3; ++i) {
    const Matrix3 r = spatial::exp_rotation({0, 0, i * 2 * M_PI / 3});
    const Vector3 s = r * leg.normalized(), b = r * drive;
    sum += stiffness * s * s.transpose() / std::pow(s.dot(b), 2);
  }
  return sum;
}

TEST(Delta, HasTheSymmetryOfThreeEqualLegs) {
  const Robot robot = read_robot(robots / "delta.yaml");
  const UnloadedStiffness result =
      unloaded_stiffness(robot.manipulator, posture_of(robot, {0, 0, -0.55}));
  ASSERT_TRUE(result.stiffness);
  const Matrix6 k = result.stiffness->matrix();
  EXPECT_TRUE(test::matrix_near_relative(turned(k), k, 1e-7));
}

TEST(Delta, WithRigidLinksIsThatOfItsThreeDrives) {
  const Robot robot = with_rigid_links("delta.yaml", {{"arm", "300"}, {"rod", "600"}});
  const double z = -0.55;
  const Posture posture = posture_of(robot, {0, 0, z});
  const UnloadedStiffness result = unloaded_stiffness(robot.manipulator, posture);
  ASSERT_TRUE(result.compliance);
  const double q = posture.coordinates[0][0];
  const Vector3 elbow(0.2 + 0.3 * std::cos(q), 0, -0.3 * std::sin(q));
  const Matrix3 expected =
      three_drives(2e4, Vector3(0.05, 0, z) - elbow, 0.3 * Vector3(-std::sin(q), 0, -std::cos(q)));
  const Matrix3 compliance = result.compliance->matrix().topLeftCorner<3, 3>();
  EXPECT_TRUE(test::matrix_near_relative(compliance, expected.inverse(), 1e-8));
  // The parallelograms hold the orientation without any spring.
  EXPECT_LT((result.compliance->matrix().bottomRightCorner<3, 3>().norm()), 1e-12);
}

TEST(Delta, FlexibleRodsMakeItSofterThanItsDrivesAlone) {
  const Robot robot = read_robot(robots / "delta.yaml");
  const Robot rigid = with_rigid_links("delta.yaml", {{"arm", "300"}, {"rod", "600"}});
  const auto vertical = [](const Robot& r) {
    return unloaded_stiffness(r.manipulator, posture_of(r, {0, 0, -0.55}))
        .compliance->matrix()(2, 2);
  };
  // Six rods, stretched: an extra compliance of about L/(6 EA sin^2), and the bending of the arms.
  EXPECT_GT(vertical(robot), vertical(rigid));
  EXPECT_LT(vertical(robot), 3 * vertical(rigid));
}

TEST(TranslationalPuu, HasTheSymmetryOfThreeEqualLegs) {
  const Robot robot = read_robot(robots / "translational_3puu.yaml");
  const Matrix6 k =
      unloaded_stiffness(robot.manipulator, posture_of(robot, {0, 0, 0.05})).stiffness->matrix();
  EXPECT_TRUE(test::matrix_near_relative(turned(k), k, 1e-8));
}

TEST(TranslationalPuu, WithRigidLegsIsThatOfItsThreeDrives) {
  const Robot robot = with_rigid_links("translational_3puu.yaml", {{"leg", "500"}});
  const UnloadedStiffness result =
      unloaded_stiffness(robot.manipulator, posture_of(robot, {0, 0, 0}));
  ASSERT_TRUE(result.compliance);
  const double drop = std::sqrt(0.5 * 0.5 - 0.22 * 0.22);
  const Matrix3 expected = three_drives(8e7, {-0.22, 0, -drop}, Vector3::UnitZ());
  EXPECT_TRUE(test::matrix_near_relative(Matrix3(result.compliance->matrix().topLeftCorner<3, 3>()),
                                         Matrix3(expected.inverse()), 1e-8));
}

// One linear structure: the flexibility of the frame on its feet, and the legs of the robot on a
// rigid base between its guides and the platform.
TEST(OrthoglideOnAFrame, IsTheFrameBehindTheLegsToFirstOrder) {
  const Robot rigid = read_robot(robots / "orthoglide_fea.yaml");
  const Robot framed = read_robot(robots / "orthoglide_frame.yaml");
  const io::Json link = io::read_json(robots.parent_path() / "links" / "corner_frame.link.json");
  const io::Json &rows = link["reduced"]["flexibility"],
                 &freedoms = link["reduced"]["degrees_of_freedom"];
  Eigen::MatrixXd flexibility(18, 18);
  for (std::size_t i = 0; i < 18; ++i)
    for (std::size_t j = 0; j < 18; ++j)
      flexibility(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = rows[i][j];
  const Pose pose = Pose::translation({0.05, -0.03, 0.02});
  const Posture posture = posture_at(rigid.manipulator, pose).posture;
  Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(24, 24);
  whole.topLeftCorner<18, 18>() = flexibility.inverse();
  ChainKinematics kinematics;
  for (std::size_t c = 0; c < 3; ++c) {
    evaluate(rigid.manipulator.chains()[c], posture.coordinates[c], kinematics);
    const io::Json& p = freedoms[6 * (c + 1)]["point"];
    Eigen::MatrixXd apart = Eigen::MatrixXd::Zero(6, 24);
    auto interface = apart.middleCols<6>(static_cast<Eigen::Index>(6 * c));
    interface = -Matrix6::Identity();
    interface.topRightCorner<3, 3>() = spatial::skew(
        pose.position() - Vector3(p[0].get<double>(), p[1].get<double>(), p[2].get<double>()));
    apart.rightCols<6>().setIdentity();
    whole += apart.transpose() *
             unloaded_stiffness(rigid.manipulator.chains()[c], kinematics).value().matrix() * apart;
  }
  const Matrix6 expected = whole.inverse().bottomRightCorner<6, 6>();
  const Matrix6 found =
      unloaded_stiffness(framed.manipulator, posture_at(framed.manipulator, pose).posture)
          .compliance.value()
          .matrix();
  EXPECT_LT((found - expected).norm(), 1e-8 * expected.norm());
  EXPECT_NEAR(framed.manipulator.elastic_bodies().at(0).mass, link["mass"].get<double>(),
              1e-6 * 138);
  const Vector3 center(link["center_of_mass"][0].get<double>(),
                       link["center_of_mass"][1].get<double>(),
                       link["center_of_mass"][2].get<double>());
  EXPECT_LT((framed.manipulator.elastic_bodies()[0].center - center).norm(), 1e-6);
}

// Torque of the shoulder by hand, from where the masses and pivots stand in equilibrium.
TEST(HeavyArm, CompensatorTakesItsShareOfTheShoulder) {
  const Robot robot = read_robot(robots / "heavy_arm.yaml");
  const Manipulator& arm = robot.manipulator;
  const Posture posture = posture_from_joints(arm, {}).posture;
  const Equilibrium e = equilibrium_under_load(arm, posture, {});
  ASSERT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
  const Pose carousel = e.inner_bodies[0], upper_arm = e.inner_bodies[1];
  const Vector3 shoulder = carousel.position();
  double torque = 0;  // about y of the carousel
  ChainKinematics kinematics;
  const Chain& distal = arm.chains()[3];
  evaluate(distal, e.chains[3].coordinates, kinematics, upper_arm);
  for (const PointMass& mass : distal.masses())
    torque += (kinematics.nodes[mass.node] - shoulder).cross(mass.mass * arm.gravity()).y();
  const Vector3 pivot1 = carousel * Vector3(-0.4, 0, 0.1), pivot2 = upper_arm * Vector3(0, 0, 0.15);
  const Vector3 rod = pivot1 - pivot2;
  const Vector3 pull = 60e3 * (rod.norm() - 0.25) * rod.normalized();
  const double by_rod = (pivot2 - shoulder).cross(pull).y();
  EXPECT_LT(by_rod, -0.2 * torque);
  const double deflection = e.chains[1].coordinates[0] - 20 * M_PI / 180;
  EXPECT_NEAR(3.3e6 * deflection, torque + by_rod, 1e-6 * torque);
}

TEST(HeavyArm, WeightOfTheBeamsIsTheirVolumeTimesDensity) {
  const Robot robot = read_robot(robots / "heavy_arm.yaml");
  double mass = 0;
  for (const Chain& chain : robot.manipulator.chains())
    for (const PointMass& point : chain.masses()) mass += point.mass;
  EXPECT_NEAR(mass, 450 + 160 + 60 + 150 + 7850 * (9600e-6 * 1.150 + 6400e-6 * 0.950), 1e-9);
}

TEST(SixAxisFromUrdf, ShippedRobotFileIsTheImportWithItsStiffnessFilledIn) {
  const RobotDescription model = read_urdf(robots.parent_path() / "urdf" / "six_axis.urdf");
  const test::TemporaryFolder folder;
  std::ofstream(folder.path() / "arm.yaml")
      << import_robot(model, find_chain(model, "", "flange")).text;
  const Robot imported = read_robot(folder.path() / "arm.yaml");
  const Robot shipped = read_robot(robots / "six_axis_urdf.yaml");
  const std::map<std::string, double> joints = {{"joint_1", 0.3},  {"joint_2", -0.5},
                                                {"joint_3", 1.2},  {"joint_4", 0.4},
                                                {"joint_5", -0.7}, {"joint_6", 1.0}};
  const Pose a = posture_from_joints(imported.manipulator, joints).posture.platform;
  const Pose b = posture_from_joints(shipped.manipulator, joints).posture.platform;
  EXPECT_LT(spatial::pose_difference(a, b).norm(), 1e-12);
  EXPECT_TRUE(unloaded_stiffness(shipped.manipulator,
                                 posture_from_joints(shipped.manipulator, joints).posture)
                  .compliance);
}

}  // namespace
}  // namespace kinetostat::vjm::shipped_robots_test

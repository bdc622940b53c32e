// What a reader of the format makes of an exported robot: frames, springs and inertia, by formulas
// of its own.
#include "kinetostat/vjm/io/mjcf_export.h"

#include <cmath>
#include <sstream>
#include <tinyxml2.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/text_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/stiffness.h"
#include "kinetostat/vjm/vibration/natural_modes.h"

namespace kinetostat::vjm::mjcf_export_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using spatial::Matrix3;
using spatial::Vector3;
using tinyxml2::XMLElement;

std::vector<double> numbers(const XMLElement& element, const char* name) {
  const char* text = element.Attribute(name);
  std::istringstream words(text == nullptr ? "" : text);
  std::vector<double> values;
  for (double value = 0; words >> value;) values.push_back(value);
  return values;
}

Vector3 vector(const XMLElement& element, const char* name) {
  const std::vector<double> v = numbers(element, name);
  return {v.at(0), v.at(1), v.at(2)};
}

Eigen::Isometry3d placed(const XMLElement& element) {
  const std::vector<double> q = numbers(element, "quat");
  return Eigen::Translation3d(vector(element, "pos")) *
         Eigen::Quaterniond(q.at(0), q.at(1), q.at(2), q.at(3));
}

// A body with the frames at its keyframe, in the world.
struct ReadBody {
  Eigen::Isometry3d frame;
  Vector3 axis;  // of its joint
  bool turns;
  double stiffness, mass;
  Vector3 center;
  Matrix3 inertia;
};

struct ReadModel {
  std::vector<ReadBody> bodies;
  Vector3 tool;

  explicit ReadModel(const std::string& text) {
    tinyxml2::XMLDocument document;
    EXPECT_EQ(document.Parse(text.c_str()), tinyxml2::XML_SUCCESS);
    const XMLElement& top = *document.FirstChildElement("mujoco");
    EXPECT_STREQ(top.FirstChildElement("compiler")->Attribute("angle"), "radian");
    const std::vector<double> qpos =
        numbers(*top.FirstChildElement("keyframe")->FirstChildElement("key"), "qpos");
    Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
    const XMLElement* element = top.FirstChildElement("worldbody");
    while (const XMLElement* inner = element->FirstChildElement("body")) {
      element = inner;
      frame = frame * placed(*element);
      add(*element, qpos.at(bodies.size()), frame);
    }
    tool = (frame * placed(*element->FirstChildElement("site"))).translation();
    EXPECT_EQ(bodies.size(), qpos.size());
  }

  // Velocity of a point on body `b`, and its angular velocity, by the joints.
  Eigen::Matrix<double, 6, Eigen::Dynamic> jacobian(std::size_t b, const Vector3& point) const {
    Eigen::Matrix<double, 6, Eigen::Dynamic> columns =
        Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, std::ssize(bodies));
    for (std::size_t j = 0; j <= b; ++j) {
      auto column = columns.col(static_cast<Index>(j));
      if (bodies[j].turns)
        column << bodies[j].axis.cross(point - bodies[j].frame.translation()), bodies[j].axis;
      else
        column.head<3>() = bodies[j].axis;
    }
    return columns;
  }

  MatrixXd mass() const {
    MatrixXd sum = MatrixXd::Zero(std::ssize(bodies), std::ssize(bodies));
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const auto j = jacobian(b, bodies[b].center);
      sum += bodies[b].mass * j.topRows<3>().transpose() * j.topRows<3>() +
             j.bottomRows<3>().transpose() * bodies[b].inertia * j.bottomRows<3>();
    }
    return sum;
  }

  MatrixXd stiffness() const {
    MatrixXd diagonal = MatrixXd::Zero(std::ssize(bodies), std::ssize(bodies));
    for (std::size_t b = 0; b < bodies.size(); ++b)
      diagonal(static_cast<Index>(b), static_cast<Index>(b)) = bodies[b].stiffness;
    return diagonal;
  }

 private:
  void add(const XMLElement& element, double q, Eigen::Isometry3d& frame) {
    const XMLElement& joint = *element.FirstChildElement("joint");
    const XMLElement& inertial = *element.FirstChildElement("inertial");
    const bool turns = std::string(joint.Attribute("type")) == "hinge";
    const Vector3 axis = vector(joint, "axis");
    frame = turns ? frame * Eigen::AngleAxisd(q, axis) : frame * Eigen::Translation3d(q * axis);
    if (joint.Attribute("stiffness") != nullptr) {
      EXPECT_NEAR(joint.DoubleAttribute("springref"), q, 1e-12);
    }
    const std::vector<double> i = numbers(inertial, "fullinertia");
    Matrix3 inertia;
    inertia << i.at(0), i.at(3), i.at(4), i.at(3), i.at(1), i.at(5), i.at(4), i.at(5), i.at(2);
    const Matrix3 rotation = frame.rotation();
    bodies.push_back({.frame = frame,
                      .axis = rotation * axis,
                      .turns = turns,
                      .stiffness = joint.DoubleAttribute("stiffness"),
                      .mass = inertial.DoubleAttribute("mass"),
                      .center = frame * vector(inertial, "pos"),
                      .inertia = rotation * inertia * rotation.transpose()});
  }
};

// The shipped six-axis arm, whose springs are in its joints, with masses.
Robot arm_with_masses() {
  const std::filesystem::path file =
      std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/six_axis.yaml";
  std::string text = io::read_text(file);
  const auto give = [&text](const std::string& link, const std::string& mass) {
    const std::size_t at = text.find("]}", text.find("  " + link + ": {rigid"));
    text.insert(at + 1, ", mass: " + mass);
  };
  give("column", "{mass: 300 kg, center: [100, 20, 300]}");
  give("upper_arm", "{mass: 150 kg, center: [0, 30, 575]}");
  give("forearm", "{mass: 90 kg, center: [400, 0, 10]}");
  const std::size_t tool = text.find("    - tool:");
  text.insert(tool, "    - mass: {name: gripper, mass: 40 kg, at: [50, 30, -100]}\n");
  return parse_robot(text, file);
}

Posture posture_of(const Robot& robot) {
  return posture_from_joints(
             robot.manipulator,
             {{"q1", 0.4}, {"q2", -0.3}, {"q3", 0.9}, {"q4", 0.5}, {"q5", -0.7}, {"q6", 1.1}})
      .posture;
}

TEST(MjcfExport, HasTheToolWhereTheRobotHasIt) {
  const Robot robot = arm_with_masses();
  const Posture posture = posture_of(robot);
  const ReadModel read(mjcf(robot, posture).text);
  ASSERT_EQ(read.bodies.size(), 6u);
  EXPECT_LT((read.tool - posture.platform.position()).norm(), 1e-12);
}

TEST(MjcfExport, GivesTheStaticAnswerOfTheRobot) {
  const Robot robot = arm_with_masses();
  const Posture posture = posture_of(robot);
  const ReadModel read(mjcf(robot, posture).text);
  const auto j = read.jacobian(5, read.tool);
  const spatial::Matrix6 compliance = j * read.stiffness().inverse() * j.transpose();
  const spatial::Matrix6 exact =
      unloaded_stiffness(robot.manipulator, posture).compliance->matrix();
  EXPECT_LT((compliance - exact).norm(), 1e-9 * exact.norm());
}

TEST(MjcfExport, GivesTheFrequenciesOfTheRobot) {
  const Robot robot = arm_with_masses();
  const Posture posture = posture_of(robot);
  const ReadModel read(mjcf(robot, posture).text);
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(read.stiffness(), read.mass());
  const NaturalModes exact = natural_modes(robot.manipulator, posture, 6);
  double mass = 0;
  for (const ReadBody& body : read.bodies) mass += body.mass;
  EXPECT_NEAR(mass, exact.mass, 1e-6);
  ASSERT_GE(exact.modes.size(), 5u);
  // The last axis has hardly any inertia behind it.
  for (std::size_t k = 0; k < 5; ++k)
    EXPECT_NEAR(std::sqrt(modes.eigenvalues()[static_cast<Index>(k)]) / (2 * M_PI),
                exact.modes[k].frequency, 1e-6 * exact.modes[k].frequency);
}

TEST(MjcfExport, SaysThatLinksAreRigid) {
  const Robot robot = parse_robot(
      "kinetostat: 1\nname: arm <1>\nunits: {length: m, force: N, angle: rad}\n"
      "materials: {steel: {E: 210 GPa, nu: 0.3, density: 7850 kg/m^3}}\n"
      "links:\n  upper: {beam: {length: 1, section: {circle: {diameter: 0.05}}, material: steel}}\n"
      "chain_types:\n  arm:\n    - actuator: {name: q1, axis: Rz, stiffness: 1e5}\n"
      "    - link: upper\n    - actuator: {name: q2, axis: Tz}\nmanipulator: {chain: arm}\n",
      "arm.yaml");
  const MjcfExport made = mjcf(robot, posture_from_joints(robot.manipulator, {}).posture);
  EXPECT_THAT(made.lost, testing::Contains(testing::HasSubstr("link upper is rigid")));
  EXPECT_THAT(made.text, testing::HasSubstr("arm &lt;1>"));
  EXPECT_EQ(ReadModel(made.text).bodies.size(), 1u);  // q2 holds its command
}

TEST(MjcfExport, RefusesWhatIsNoSerialRobot) {
  const Robot robot = read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/delta.yaml");
  EXPECT_THROW(mjcf(robot, posture_from_joints(robot.manipulator, {}).posture),
               std::invalid_argument);
}

}  // namespace
}  // namespace kinetostat::vjm::mjcf_export_test

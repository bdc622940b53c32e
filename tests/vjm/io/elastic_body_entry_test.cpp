// Elastic bodies in robot files: where they stand, and every wrong use.
#include "kinetostat/vjm/io/elastic_body_entry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/stiffness.h"

#include "vjm/elastic_sample.h"

namespace kinetostat::vjm::elastic_body_entry_test {
namespace {

using samples::BodyBetweenPoints;
using samples::robot_with_body;
using spatial::Matrix6;
using spatial::Vector3;
using ::testing::HasSubstr;

BodyBetweenPoints bracket() {
  return {{"foot", "left", "right"}, {{0, 0, 0}, {0.2, 0.1, 0.3}, {-0.2, 0.05, 0.3}}, 21};
}

// Chains and bodies in flow style, one line each.
std::string robot(const std::string& bodies, const std::string& chains) {
  return R"(kinetostat: 1
name: bracket
units: {length: mm, force: N, angle: deg}
links:
  rod: {stiffness: [[900, 0, 0, 0, 0, 0], [0, 800, 0, 0, 0, 0], [0, 0, 700, 0, 0, 0], [0, 0, 0, 6.0e6, 0, 0],
    [0, 0, 0, 0, 5.0e6, 0], [0, 0, 0, 0, 0, 4.0e6]], end: [0, 0, 100]}
chain_types: {rod: [{link: rod}]}
manipulator: {bodies: )" +
         bodies + ", chains: " + chains + "}\n";
}

const std::string on_base = "[{name: b, elastic: body.json, interfaces: {foot: base}}]";
const std::string from_left = "[{name: r, type: rod, from: b.left, base: [200, 100, 300]}]";

std::string refusal(const std::string& text, const io::Json& body) {
  try {
    (void)robot_with_body(text, body);
  } catch (const common::InputError& error) {
    return error.what();
  }
  return "none";
}

std::string message_of(const std::string& bodies, const std::string& chains) {
  return refusal(robot(bodies, chains), bracket().json());
}

Matrix6 compliance_of(const std::string& bodies, const std::string& chains) {
  const Robot found = robot_with_body(robot(bodies, chains), bracket().json());
  const PostureResult posture = posture_from_joints(found.manipulator, {});
  EXPECT_TRUE(posture.reached) << posture.reason;
  EXPECT_LT((posture.posture.platform.position() - Vector3(0.2, 0.1, 0.4)).norm(), 1e-12);
  return unloaded_stiffness(found.manipulator, posture.posture).compliance.value().matrix();
}

TEST(ElasticBodyEntry, CanStandAnywhere) {
  const Matrix6 plain = compliance_of(on_base, from_left);
  // The pose of an interface goes before that of the body.
  const Matrix6 same = compliance_of(
      "[{name: b, elastic: body.json, interfaces: {foot: {to: base, pose: {rotation_vector: [0, 0, "
      "0]}}}, pose: [9, 9, 9]}]",
      from_left);
  EXPECT_LT((same - plain).norm(), 1e-12 * plain.norm());
  // Held on the other side as well.
  const Matrix6 held = compliance_of(
      "[{name: b, elastic: body.json, interfaces: {foot: base, right: base}}]", from_left);
  EXPECT_LT(held(0, 0), 0.999 * plain(0, 0));
  // An interface on which nothing hangs changes nothing.
  const BodyBetweenPoints body = bracket();
  Matrix6 expected = body.stiffness.bottomRightCorner<12, 12>().inverse().topLeftCorner<6, 6>();
  Matrix6 up = Matrix6::Identity();
  up.topRightCorner<3, 3>() = -spatial::skew(Vector3(0, 0, 0.1));
  expected = up * expected * up.transpose();
  spatial::Vector6 rod;
  rod << 1 / 900e3, 1 / 800e3, 1 / 700e3, 1 / 6e3, 1 / 5e3, 1 / 4e3;
  expected += rod.asDiagonal();
  EXPECT_LT((plain - expected).norm(), 1e-10 * expected.norm());
}

// Two brackets, the foot of the second on the left of the first.
TEST(ElasticBodyEntry, CanStandOnAnother) {
  const Robot found = robot_with_body(
      robot(
          "[{name: b, elastic: body.json, interfaces: {foot: base}}, {name: c, elastic: body.json, "
          "interfaces: {foot: b.left}, pose: [200, 100, 300]}]",
          "[{name: r, type: rod, from: c.right, base: [-200, 50, 300]}]"),
      bracket().json());
  const PostureResult posture = posture_from_joints(found.manipulator, {});
  ASSERT_TRUE(posture.reached) << posture.reason;
  EXPECT_LT((posture.posture.platform.position() - Vector3(0, 0.15, 0.7)).norm(), 1e-12);
  const Matrix6 both =
      unloaded_stiffness(found.manipulator, posture.posture).compliance.value().matrix();
  const Matrix6 one =
      bracket().stiffness.bottomRightCorner<12, 12>().inverse().topLeftCorner<6, 6>();
  Matrix6 up = Matrix6::Identity();
  up.topRightCorner<3, 3>() = -spatial::skew(Vector3(-0.2, 0.05, 0.4));
  EXPECT_GT(both(0, 0), (up * one * up.transpose())(0, 0));
}

TEST(ElasticBodyEntry, ItsInterfacesMustBeThere) {
  const std::string wrong =
      message_of("[{name: b, elastic: body.json, interfaces: {food: base}}]", from_left);
  EXPECT_THAT(wrong, HasSubstr("manipulator.bodies[0].interfaces"));
  EXPECT_THAT(wrong, HasSubstr("foot"));
  EXPECT_THAT(message_of(on_base, "[{name: r, type: rod, from: b.lift}]"), HasSubstr("b.left"));
  EXPECT_THAT(message_of("[{name: b, elastic: body.json, interfaces: {foot: bass}}]", from_left),
              HasSubstr("base"));
}

TEST(ElasticBodyEntry, AnInterfaceIsFastenedOnce) {
  EXPECT_THAT(
      message_of("[{name: b, elastic: body.json, interfaces: {foot: base, foot: platform}}]",
                 from_left),
      HasSubstr("twice"));
  EXPECT_THAT(message_of(on_base, "[{name: r, type: rod, from: b.foot}]"),
              HasSubstr("the interface 'foot' of 'b' is fastened to 'base' already. Write 'from: "
                        "base'"));
  EXPECT_THAT(message_of("[{name: b, elastic: body.json, interfaces: {foot: base, left: {to: base, "
                         "pose: [1, 0, 0]}}}]",
                         "[{name: r, type: rod, from: b.right}]"),
              HasSubstr("two poses"));
  EXPECT_THAT(message_of("[b, {name: b, elastic: body.json, interfaces: {foot: base}}, {name: b, "
                         "elastic: body.json, interfaces: {foot: base}}]",
                         from_left),
              HasSubstr("two bodies are named 'b.left'"));
}

TEST(ElasticBodyEntry, MustBeHeldAndYield) {
  EXPECT_THAT(message_of("[{name: b, elastic: body.json}]", from_left),
              HasSubstr("'b' is free to move"));
  EXPECT_THAT(message_of("[{name: b, elastic: body.json, interfaces: {foot: base, left: base, "
                         "right: base}}]",
                         "[{name: r, type: rod}]"),
              HasSubstr("it cannot yield"));
}

class BrokenMatrix : public testing::Test {
 protected:
  BodyBetweenPoints body_ = bracket();
  io::Json json_ = body_.json();
  std::string message() const { return refusal(robot(on_base, from_left), json_); }
  io::Json& reduced() { return json_["reduced"]; }
  // Springs from the foot to either side, those along x coupled by a share of themselves.
  void take_springs(double coupling) {
    Eigen::MatrixXd apart = Eigen::MatrixXd::Zero(12, 18);
    for (Eigen::Index i = 0; i < 2; ++i) {
      apart.block<6, 6>(6 * i, 0) = -Matrix6::Identity();
      apart.block<3, 3>(6 * i, 3) =
          spatial::skew(body_.points[static_cast<std::size_t>(i) + 1] - body_.points[0]);
      apart.block<6, 6>(6 * i, 6 + 6 * i).setIdentity();
    }
    Eigen::MatrixXd springs = 1e5 * Eigen::MatrixXd::Identity(12, 12);
    springs(0, 6) = springs(6, 0) = coupling * 1e5;
    body_.stiffness = apart.transpose() * springs * apart;
    json_ = body_.json();
  }
};

TEST_F(BrokenMatrix, OfAnotherSizeOrUnit) {
  reduced()["stiffness"].erase(0);
  EXPECT_THAT(message(), HasSubstr("reduced.stiffness: 18 rows of 18 numbers"));
  json_ = body_.json();
  reduced()["degrees_of_freedom"][1]["motion_unit"] = "mm";
  EXPECT_THAT(message(), HasSubstr("the units m, rad, N and N m are expected"));
  json_ = body_.json();
  reduced()["degrees_of_freedom"][1]["motion"] = "tz";
  EXPECT_THAT(message(), HasSubstr("row 2 must be the motion 'ty'"));
  json_ = body_.json();
  reduced()["degrees_of_freedom"][0]["interface"] = "\x1b[31m";
  EXPECT_THAT(message(), HasSubstr("one line of text"));
  json_ = io::Json{{"link", "bar"}};
  EXPECT_THAT(message(), HasSubstr("no stiffness between all interfaces"));
}

TEST_F(BrokenMatrix, ThatIsNotSymmetric) {
  reduced()["stiffness"][0][1] = reduced()["stiffness"][0][1].get<double>() + 1e5;
  EXPECT_THAT(message(), HasSubstr("reduced.stiffness: the matrix is not symmetric"));
}

TEST_F(BrokenMatrix, ThatResistsRigidMotions) {
  reduced()["stiffness"][0][0] = 1.001 * reduced()["stiffness"][0][0].get<double>();
  EXPECT_THAT(message(), HasSubstr("resists rigid motions"));
}

TEST_F(BrokenMatrix, ThatIsNotPositive) {
  take_springs(2);
  EXPECT_THAT(message(), HasSubstr("reduced.stiffness: the matrix is not positive semi-definite"));
  body_.stiffness *= -1;
  json_ = body_.json();
  EXPECT_THAT(message(), HasSubstr("not positive semi-definite"));
}

TEST_F(BrokenMatrix, ThatLeavesAMotionFree) {
  take_springs(1);
  EXPECT_THAT(message(), HasSubstr("leaves a motion free beside the six rigid ones"));
}

TEST_F(BrokenMatrix, OfAMassThatIsNegative) {
  body_.inertia *= -1;
  json_ = body_.json();
  EXPECT_THAT(message(), HasSubstr("reduced.mass: the matrix is not positive semi-definite"));
}

// Error bars and a bracket of the flexibility are sources of uncertainty, and the stiffness for
// other values is that of another flexibility.
TEST(ElasticBodyEntry, TakesErrorBarsAndBracketOfItsFlexibility) {
  const BodyBetweenPoints body = bracket();
  const Eigen::MatrixXd flexibility = body.stiffness.bottomRightCorner<12, 12>().inverse();
  io::Json json = body.json();
  json["reduced"]["fixed"] = "foot";
  json["reduced"]["flexibility"] = io::rows(flexibility);
  json["bracket"] = {{"rigid", io::rows(flexibility)},
                     {"distributing", io::rows(Eigen::MatrixXd(1.2 * flexibility))}};
  const test::TemporaryFolder folder;
  io::write_json(folder.path() / "body.json", json);
  std::ofstream(folder.path() / "robot.yaml") << robot(on_base, from_left);
  const Robot robot = read_robot(folder.path() / "robot.yaml");
  ASSERT_EQ(robot.sources.size(), 1u);
  EXPECT_EQ(robot.sources[0].name, "clamping of body");
  const Eigen::MatrixXd& nominal = robot.manipulator.elastic_bodies().at(0).stiffness;
  const Robot softest = with_values(robot, Eigen::VectorXd::Constant(1, 1));
  const Eigen::MatrixXd& soft = softest.manipulator.elastic_bodies().at(0).stiffness;
  EXPECT_LT((1.2 * soft - nominal).norm(), 1e-10 * nominal.norm());
}

}  // namespace
}  // namespace kinetostat::vjm::elastic_body_entry_test

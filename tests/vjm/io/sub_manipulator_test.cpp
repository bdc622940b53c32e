#include "kinetostat/vjm/io/sub_manipulator.h"

#include <filesystem>
#include <fstream>
#include <random>
#include <stdexcept>

#include <Eigen/Cholesky>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/stiffness.h"

#include "vjm/robot_text.h"

namespace kinetostat::vjm::sub_manipulator_test {
namespace {

using spatial::Matrix6;
using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;

const std::string robots = std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/";

std::string leg_of(const std::string& name) {
  return "  - {name: " + name + ", type: prpar, base: {point: " +
         (name == "x" ? "[0, -109.53084041, 0], x: [1, 0, 0], y: [0, 1, 0]}, platform: {x: [1, 0, "
                        "0], y: [0, 1, 0]}}\n"
          : name == "y" ? "[0, 0, -109.53084041], x: [0, 1, 0], y: [0, 0, 1]}, platform: {x: [0, "
                          "1, 0], y: [0, 0, 1]}}\n"
                        : "[-109.53084041, 0, 0], x: [0, 0, 1], y: [1, 0, 0]}, platform: {x: [0, "
                          "0, 1], y: [1, 0, 0]}}\n");
}

const std::string orthoglide =
    "kinetostat: 1\n"
    "name: orthoglide of three-part chains\n"
    "units: {length: mm, force: N, angle: deg}\n"
    "materials: {aluminium: {E: 70 GPa, G: 25.5 GPa}}\n"
    "links:\n"
    "  foot: {beam: {length: 154.9, direction: [1, 1, 0], section: {rectangle: {y: 29.4, z: "
    "16.4}}, "
    "material: aluminium, theory: euler-bernoulli}}\n"
    "  leg: {manipulator: parallelogram.yaml, at: [310, 0, 0]}\n"
    "chain_types:\n"
    "  prpar:\n"
    "  - actuator: {name: rho, axis: Tx, stiffness: 1.0e5, home: -449.53}\n"
    "  - link: foot\n"
    "  - passive: {name: q1, axis: Rz}\n"
    "  - link: leg\n"
    "  - passive: {name: q4, axis: Rz}\n"
    "  - tool: [30, 0, 0]\n"
    "manipulator:\n"
    "  chains:\n" +
    leg_of("x") + leg_of("y") + leg_of("z");

// A robot of twelve chains and six inner bodies, and the same of three chains with reduced legs.
TEST(SubManipulator, ReducedLegsGiveTheStiffnessOfTheWholeMechanism) {
  const Robot whole = read_robot(robots + "orthoglide_prpar.yaml");
  const Robot reduced = robot_from(orthoglide);
  EXPECT_EQ(reduced.manipulator.size(), 3U);
  const auto compliance = [](const Robot& robot) {
    const PostureResult at = posture_at(robot.manipulator, Pose());
    EXPECT_TRUE(at.reached) << at.reason;
    return unloaded_stiffness(robot.manipulator, at.posture).compliance.value().matrix();
  };
  const Matrix6 expected = compliance(whole);
  EXPECT_LT((compliance(reduced) - expected).norm(), 1e-7 * expected.norm());
}

TEST(SubManipulator, AParallelogramIsFreeToSwingOnly) {
  const Robot robot = read_robot(robots + "parallelogram.yaml");
  const PostureResult at = posture_at(robot.manipulator, Pose::translation({0.31, 0, 0}));
  ASSERT_TRUE(at.reached);
  const UnloadedStiffness s = unloaded_stiffness(robot.manipulator, at.posture);
  EXPECT_EQ(s.free.rank, 5);
  EXPECT_THAT(s.free.sentences, testing::ElementsAre(testing::HasSubstr("translation along z")));
}

// A random stiffness with a free rotation and a free translation: the chain has it back.
TEST(SubManipulator, AnyRankComesBackFromTheChain) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 20; ++trial) {
    const auto unit = [&] {
      return Vector3(normal(random), normal(random), normal(random)).normalized().eval();
    };
    Eigen::Matrix<double, 6, 2> free;
    const Vector3 axis = unit(), point = 0.3 * unit();
    free.col(0) << -axis.cross(point), axis;  // velocity of the origin
    free.col(1) << unit(), Vector3::Zero();
    const Matrix6 random_matrix =
        Matrix6::NullaryExpr([&](Eigen::Index, Eigen::Index) { return normal(random); });
    const Matrix6 full = 1e6 * random_matrix * random_matrix.transpose();
    const auto image = (full * free).eval();
    const Matrix6 stiffness =
        full - image * (free.transpose() * image).ldlt().solve(image.transpose());

    const Pose offset(spatial::Matrix3::Identity(), unit());
    LinkModel link{.parts = {part_with_free_motions(offset, stiffness, 0.5)}};
    ASSERT_EQ(link.parts[0].free_motions.size(), 2U);
    ChainBuilder chain("chain");
    link.append_to(chain, "link");
    const Manipulator manipulator("m", {chain.build()});
    const Posture posture = posture_from_joints(manipulator, {}).posture;
    const Matrix6 back = unloaded_stiffness(manipulator, posture).stiffness.value().matrix();
    EXPECT_LT((back - stiffness).norm(), 1e-8 * stiffness.norm());
  }
}

TEST(SubManipulator, WhatIsNoStiffnessIsRefused) {
  EXPECT_THROW(part_with_free_motions(Pose(), -Matrix6::Identity(), 1), std::invalid_argument);
}

TEST(SubManipulator, AFileThatIsPartOfItselfIsRefused) {
  const auto file = std::filesystem::path(::testing::TempDir()) / "itself.yaml";
  std::ofstream(file) << "kinetostat: 1\nname: loop\nunits: {length: mm, force: N}\n"
                         "links: {a: {manipulator: itself.yaml}}\n"
                         "chain_types: {c: [{link: a}]}\nmanipulator: {chain: c}\n";
  try {
    read_robot(file);
    FAIL() << "was read";
  } catch (const common::InputError& error) {
    EXPECT_THAT(std::string(error.what()), testing::HasSubstr("part of itself"));
  }
}

}  // namespace
}  // namespace kinetostat::vjm::sub_manipulator_test

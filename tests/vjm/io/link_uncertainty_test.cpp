#include "kinetostat/vjm/io/link_uncertainty.h"

#include <cmath>
#include <fstream>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/vjm/io/robot_file.h"

#include "support/matrix_near.h"
#include "support/random.h"
#include "support/temporary_folder.h"

namespace kinetostat::vjm::link_uncertainty_test {
namespace {

using spatial::Compliance6;
using spatial::Matrix6;

const std::filesystem::path file = "foot.link.json";

// A link with a bracket and error bars of 2 %, correlated as some error energy is.
io::IdentifiedLink link() {
  test::Random random(3);
  const Matrix6 rigid = 1e-6 * random.positive_definite();
  const Matrix6 softer = rigid + 2e-7 * random.positive_definite();
  const Matrix6 recovery = 1e-9 * random.positive_definite();
  Matrix6 bar = Matrix6::Zero();
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) bar(i, j) = 0.02 * std::sqrt(rigid(i, i) * rigid(j, j));
  return {.compliance = Compliance6(rigid),
          .mass = {},
          .error = io::LinkErrorBars{bar, recovery},
          .bracket = io::LinkBracket{rigid, softer}};
}

Matrix6 at(const io::IdentifiedLink& of, const std::vector<double>& values) {
  SourceList listed;
  (void)uncertain_compliance(of, file, listed);
  EXPECT_EQ(listed.sources().size(), values.size());
  SourceList replaced(
      listed.sources(),
      Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
  return uncertain_compliance(of, file, replaced).matrix();
}

TEST(LinkUncertainty, HasTwoSourcesAndIsItselfWhileTheyAreListed) {
  SourceList sources;
  EXPECT_EQ(uncertain_compliance(link(), file, sources).matrix(), link().compliance.matrix());
  ASSERT_EQ(sources.sources().size(), 2u);
  EXPECT_EQ(sources.sources()[0].name, "clamping of foot");
  EXPECT_EQ(sources.sources()[1].name, "mesh of foot");
  EXPECT_DOUBLE_EQ(sources.sources()[0].estimate, 0.5);
  EXPECT_DOUBLE_EQ(sources.sources()[0].deviation, 1 / std::sqrt(12.0));
  EXPECT_DOUBLE_EQ(sources.sources()[1].estimate, 0);
  EXPECT_DOUBLE_EQ(sources.sources()[1].deviation, 1 / std::sqrt(3.0));
}

TEST(LinkUncertainty, TheClampingLeadsFromOneBoundToTheOther) {
  const io::IdentifiedLink of = link();
  EXPECT_TRUE(test::matrix_near_relative(at(of, {0, 0}), of.bracket->rigid, 1e-14));
  EXPECT_TRUE(test::matrix_near_relative(at(of, {1, 0}), of.bracket->distributing, 1e-14));
  EXPECT_TRUE(test::matrix_near_relative(
      at(of, {0.5, 0}), Matrix6(0.5 * (of.bracket->rigid + of.bracket->distributing)), 1e-14));
}

TEST(LinkUncertainty, TheErrorOfTheMeshIsAsLargeAsItsBars) {
  const io::IdentifiedLink of = link();
  const Matrix6 error = at(of, {0, 1}) - of.bracket->rigid;
  EXPECT_TRUE(
      test::matrix_near_relative(error.diagonal().eval(), of.error->bar.diagonal().eval(), 1e-10));
  EXPECT_GE(Eigen::SelfAdjointEigenSolver<Matrix6>(error).eigenvalues()[0],
            -1e-12 * error.diagonal().maxCoeff());
  EXPECT_TRUE(
      test::matrix_near_relative(at(of, {0, -1}), Matrix6(of.bracket->rigid - error), 1e-12));
  // Correlated as the recovered error is.
  const Matrix6& e = of.error->recovery;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      EXPECT_NEAR(error(i, j) / std::sqrt(error(i, i) * error(j, j)),
                  e(i, j) / std::sqrt(e(i, i) * e(j, j)), 1e-6);
}

TEST(LinkUncertainty, BarsAboveTheComplianceLeaveItPositive) {
  io::IdentifiedLink of = link();
  of.error->bar *= 200;
  EXPECT_EQ(Eigen::LLT<Matrix6>(at(of, {0, -1})).info(), Eigen::Success);
}

TEST(LinkUncertainty, ALinkOfWhichNothingIsSaidHasNone) {
  io::IdentifiedLink of = link();
  of.error.reset();
  of.bracket.reset();
  SourceList sources;
  EXPECT_EQ(uncertain_compliance(of, file, sources).matrix(), of.compliance.matrix());
  EXPECT_TRUE(sources.sources().empty());
}

// All of the compliance goes with one over the modulus, whatever else is not known.
TEST(LinkUncertainty, AModulusOfItsMaterialIsAThirdSource) {
  io::IdentifiedLink of = link();
  of.young_deviation = 0.03;
  SourceList sources;
  (void)uncertain_compliance(of, file, sources);
  ASSERT_EQ(sources.sources().size(), 3u);
  const UncertaintySource& young = sources.sources()[2];
  EXPECT_EQ(young.name, "E of foot");
  EXPECT_EQ(young.kind, SourceKind::material);
  EXPECT_EQ(young.spread, Spread::log_normal);
  EXPECT_DOUBLE_EQ(young.deviation, 0.03);
  EXPECT_TRUE(test::matrix_near_relative(at(of, {0.3, 0.2, 1.25}),
                                         Matrix6(at(of, {0.3, 0.2, 1}) / 1.25), 1e-12));
}

const std::string robot_text = R"(kinetostat: 1
name: two feet
units: {length: mm, force: N}
links:
  foot: {compliance: foot.link.json}
  pair: {compliance: foot.link.json, copies: 2}
chain_types:
  arm:
    - link: foot
    - link: pair
manipulator: {chain: arm}
)";

// One file is one link, wherever it is used.
TEST(LinkUncertainty, OfAFileIsTheSameInAllThatUseIt) {
  const test::TemporaryFolder folder;
  const io::IdentifiedLink of = link();
  io::Json json = io::to_json(of.compliance);
  json["error"] = {{"bar", io::rows(of.error->bar)}, {"recovery", io::rows(of.error->recovery)}};
  json["bracket"] = {{"rigid", io::rows(of.bracket->rigid)},
                     {"distributing", io::rows(of.bracket->distributing)}};
  folder.file("foot.link.json", json.dump());
  const Robot robot = read_robot(folder.file("robot.yaml", robot_text));
  ASSERT_EQ(robot.sources.size(), 2u);
  const Robot softest = with_values(robot, Eigen::Vector2d(1, 0));
  const auto& springs = softest.manipulator.chains()[0].springs();
  const Matrix6 one = springs[0].stiffness, two = springs[1].stiffness;
  EXPECT_TRUE(test::matrix_near_relative(one, Matrix6(of.bracket->distributing.inverse()), 1e-9));
  EXPECT_TRUE(test::matrix_near_relative(two, Matrix6(2 * one), 1e-9));
}

}  // namespace
}  // namespace kinetostat::vjm::link_uncertainty_test

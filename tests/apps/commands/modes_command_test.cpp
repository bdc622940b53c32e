// Natural frequencies of a link, as its user asks for them.
#include <cmath>
#include <fstream>
#include <sstream>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::modes_command_test {
namespace {

using test::kinetostat;
using test::working_folder;
using testing::HasSubstr;

class ModesCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string text = io::read_text(working_folder() / "meshes/test_bar.yaml");
    text.replace(text.find("size: 3"), 7, "size: 8");
    text.replace(text.find("test_bar.stl"), 12, "meshes/test_bar.stl");
    std::ofstream(working_folder() / "rod.yaml") << text;
    text.replace(text.find(", density: 7850 kg/m^3"), 22, "");
    std::ofstream(working_folder() / "weightless.yaml") << text;
  }
  static io::Json result(const std::string& options) {
    const test::Outcome outcome = kinetostat("modes rod.yaml -q --json modes.json " + options);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return io::read_json(working_folder() / "modes.json");
  }
};

TEST_F(ModesCommand, SaysFirstWhatItIsAskedFor) {
  const test::Outcome outcome = kinetostat("modes rod.yaml --modes 40");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, testing::StartsWith("test bar, clamped at fixed: first natural"));
  EXPECT_THAT(outcome.out, HasSubstr("Next: kinetostat identify rod.yaml"));
  std::istringstream lines(outcome.out);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) EXPECT_LE(line.size(), 100u) << line;
  EXPECT_LE(count, 25);
}

// The bar with a rigid face at its end: nearly Euler's and Bernoulli's, 310 x 20 x 12 mm of steel.
TEST_F(ModesCommand, GivesTheFrequenciesOfTheBar) {
  const io::Json clamped = result("-o modes.file.json");
  EXPECT_EQ(clamped["support"], "clamped");
  ASSERT_EQ(clamped["modes"].size(), 6u);
  const double c = 5172.2, radius = 0.012 / std::sqrt(12.0), length = 0.31;  // sqrt(E / rho) [m/s]
  const double first = 1.8751 * 1.8751 * c * radius / (2 * M_PI * length * length);
  EXPECT_NEAR(clamped["modes"][0]["frequency"].get<double>(), first, 0.01 * first);
  const io::Json kept = io::read_json(working_folder() / "modes.file.json");
  EXPECT_EQ(kept["modes"], clamped["modes"]);
  const double free = result("--free")["modes"][0]["frequency"].get<double>();
  EXPECT_NEAR(free / first, 4.7300 * 4.7300 / (1.8751 * 1.8751), 0.1);
  EXPECT_GT(result("--held")["modes"][0]["frequency"].get<double>(), free);
}

TEST_F(ModesCommand, IsTheSameOnAnyNumberOfThreads) {
  EXPECT_EQ(result("--threads 1")["modes"], result("--threads 3")["modes"]);
}

TEST_F(ModesCommand, WritesTheShapes) {
  result("--modes 2 --vtu modes.vtu");
  const std::string grid = io::read_text(working_folder() / "modes.vtu");
  EXPECT_THAT(grid, HasSubstr("Name=\"mode 2\""));
  EXPECT_THAT(grid, HasSubstr("error_indicator"));
}

TEST_F(ModesCommand, NamesMistakesAndTheirCure) {
  const test::Outcome weightless = kinetostat("modes weightless.yaml");
  EXPECT_EQ(weightless.code, 3);
  EXPECT_THAT(weightless.err, HasSubstr("weightless.yaml:"));
  EXPECT_THAT(weightless.err, HasSubstr("density"));
  const test::Outcome both = kinetostat("modes rod.yaml --free --held");
  EXPECT_EQ(both.code, 2);
  const test::Outcome robot = kinetostat("modes data/robots/six_axis.yaml");
  EXPECT_EQ(robot.code, 3);
  EXPECT_THAT(robot.err, HasSubstr("nothing in this robot has a mass"));
  EXPECT_EQ(kinetostat("modes data/robots/heavy_arm.yaml --free").code, 2);
  EXPECT_EQ(kinetostat("modes rod.yaml --joints q1=0").code, 2);
  EXPECT_EQ(kinetostat("modes data/urdf/none.urdf").code, 3);
}

TEST_F(ModesCommand, TakesARobotInAPosture) {
  const test::Outcome outcome = kinetostat(
      "modes data/robots/heavy_arm.yaml --joints q2=20,q3=-20 --modes 4 --json robot.json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, testing::StartsWith("First natural frequency"));
  const io::Json result = io::read_json(working_folder() / "robot.json");
  ASSERT_EQ(result["modes"].size(), 4u);
  EXPECT_GT(result["mass"].get<double>(), 450 + 160 + 60 + 150);  // and two beams
  EXPECT_LT(result["lumping_error"].get<double>(), 0.1);
  double energy = 0;
  for (const io::Json& spring : result["modes"][0]["yields"])
    energy += spring["share"].get<double>();
  EXPECT_NEAR(energy, 1, 1e-5);
  // A stretched arm is slower.
  ASSERT_EQ(
      kinetostat("modes data/robots/heavy_arm.yaml --joints q2=80,q3=-80 -q --json out.json").code,
      0);
  EXPECT_LT(io::read_json(working_folder() / "out.json")["modes"][0]["frequency"].get<double>(),
            result["modes"][0]["frequency"].get<double>());
}

// The matrix "NAME = [ ... ];" of a script.
Eigen::MatrixXd matrix_of(const std::string& script, const std::string& name) {
  const std::size_t at = script.find("\n" + name + " = [\n") + name.size() + 6;
  std::istringstream words(script.substr(at, script.find(']', at) - at));
  std::vector<double> values;
  for (double value = 0; words >> value;) values.push_back(value);
  const auto size = static_cast<Eigen::Index>(std::lround(std::sqrt(double(values.size()))));
  return Eigen::Map<const Eigen::MatrixXd>(values.data(), size, size);
}

double clamped_frequency(const Eigen::MatrixXd& stiffness, const Eigen::MatrixXd& mass) {
  const Eigen::Index rest = stiffness.rows() - 6;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(
      stiffness.bottomRightCorner(rest, rest), mass.bottomRightCorner(rest, rest));
  return std::sqrt(modes.eigenvalues()[0]) / (2 * M_PI);
}

// What a simulator that reads the file finds: static answer, mass and frequencies of the link.
TEST_F(ModesCommand, WritesAReducedModelThatAnswersAsTheLink) {
  const double clamped =
      result("--modes 12 --reduced reduced.m")["modes"][0]["frequency"].get<double>();
  const std::string script = io::read_text(working_folder() / "reduced.m");
  EXPECT_THAT(script, HasSubstr("'fixed.tx', "));
  EXPECT_THAT(script, HasSubstr("'loaded.rz', 'mode 1', "));
  EXPECT_THAT(script, HasSubstr("; 0.31 0 0];"));
  const Eigen::MatrixXd stiffness = matrix_of(script, "K"), mass = matrix_of(script, "M");
  ASSERT_EQ(stiffness.rows(), 24);
  EXPECT_NEAR(clamped_frequency(stiffness, mass), clamped, 1e-4 * clamped);
  // The frequencies with both ends held are those of the modes themselves.
  const io::Json held = result("--held --modes 12");
  for (Eigen::Index k = 0; k < 12; ++k) {
    const double omega_squared =
        held["modes"][static_cast<std::size_t>(k)]["omega_squared"].get<double>();
    EXPECT_NEAR(stiffness(12 + k, 12 + k), omega_squared, 1e-6 * omega_squared) << k;
  }
  ASSERT_EQ(kinetostat("identify rod.yaml -q -o rod.json").code, 0);
  const io::Json link = io::read_json(working_folder() / "rod.json");
  const Eigen::MatrixXd loaded = stiffness.block(6, 6, 6, 6);
  const Eigen::MatrixXd compliance = loaded.inverse();
  for (Eigen::Index i = 0; i < 6; ++i)
    EXPECT_NEAR(
        compliance(i, i),
        link["compliance"][static_cast<std::size_t>(i)][static_cast<std::size_t>(i)].get<double>(),
        1e-6 * compliance(i, i));
  EXPECT_NEAR(mass(0, 0) + mass(6, 6) + 2 * mass(0, 6), link["mass"].get<double>(), 1e-8);
}

// Rigid motions of the reduced mass have the mass of the link.
TEST_F(ModesCommand, IdentifyWritesTheMassBetweenTheInterfaces) {
  ASSERT_EQ(kinetostat("identify rod.yaml -q -o rod.json").code, 0);
  const io::Json link = io::read_json(working_folder() / "rod.json");
  double along_x = 0;
  for (const std::size_t i : {0, 6})
    for (const std::size_t j : {0, 6}) along_x += link["reduced"]["mass"][i][j].get<double>();
  EXPECT_NEAR(along_x, link["mass"].get<double>(), 1e-9);
  ASSERT_EQ(kinetostat("identify weightless.yaml -q -o weightless.json").code, 0);
  EXPECT_TRUE(io::read_json(working_folder() / "weightless.json")["reduced"]["mass"].is_null());
}

}  // namespace
}  // namespace kinetostat::modes_command_test

// Natural frequencies of a link, as its user asks for them.
#include <cmath>
#include <fstream>
#include <sstream>

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
  EXPECT_THAT(robot.err, HasSubstr("robot file"));
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

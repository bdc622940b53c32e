// Natural frequencies of a link, as its user asks for them.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"
#include "support/program.h"

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

// A weight on a spring: omega^2 = k / m, and so 2 u(f) / f is that of k and m together.
TEST_F(ModesCommand, SaysHowWellARobotsFrequenciesAreKnown) {
  std::ofstream(working_folder() / "weight_on_a_spring.yaml") << R"(kinetostat: 1
name: weight on a spring
units: {length: mm, force: N, angle: deg, mass: kg}
chain_types:
  slide:
    - actuator: {name: x, axis: Tx, stiffness: {value: 40, sd: 4 %}}
    - mass: {name: weight, mass: {value: 5, sd: 3 %}}
manipulator: {chain: slide}
)";
  const test::Outcome outcome =
      kinetostat("modes weight_on_a_spring.yaml --joints x=0 --draws 400 --json spring.json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, testing::StartsWith("First natural frequency 14.2 Hz +- 5 %"));
  EXPECT_THAT(outcome.out, HasSubstr("64 % is stiffness of x and 36 % mass of weight."));
  const io::Json result = io::read_json(working_folder() / "spring.json");
  const io::Json& known = result["uncertainty"]["frequencies"][0];
  const double frequency = std::sqrt(40000.0 / 5) / (2 * M_PI);
  EXPECT_NEAR(known["value"].get<double>(), frequency, 1e-9 * frequency);
  EXPECT_NEAR(known["expanded_uncertainty"].get<double>(), 0.05 * frequency, 2e-4 * frequency);
  EXPECT_NEAR(known["draws"]["standard_deviation"].get<double>(), 0.025 * frequency,
              0.0025 * frequency);
  EXPECT_NEAR(result["uncertainty"]["budget"][0]["share"].get<double>(), 0.64, 1e-3);
  EXPECT_EQ(kinetostat("modes rod.yaml --draws 5").code, 2);
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

// The same matrices in the other formats: as MAT-file of level 4, as NumPy arrays.
TEST_F(ModesCommand, WritesTheReducedModelInOtherFormats) {
  result("--modes 20 --reduced reduced.m");
  const Eigen::MatrixXd k = matrix_of(io::read_text(working_folder() / "reduced.m"), "K");
  ASSERT_EQ(k.rows(), 32);
  result("--modes 20 --reduced reduced.mat");
  const std::string bytes = io::read_text(working_folder() / "reduced.mat");
  std::int32_t header[5];  // type, rows, columns, imaginary, length of the name
  std::memcpy(header, bytes.data(), sizeof header);
  EXPECT_EQ(std::vector<std::int32_t>(header, header + 5),
            (std::vector<std::int32_t>{0, 32, 32, 0, 2}));
  EXPECT_STREQ(bytes.c_str() + 20, "K");
  Eigen::MatrixXd read(32, 32);
  std::memcpy(read.data(), bytes.data() + 22, sizeof(double) * 32 * 32);
  EXPECT_LT((read - k).norm(), 1e-14 * k.norm());
  EXPECT_EQ(bytes.size(), 2 * (22 + 8 * 32 * 32) + 28 + 8 * 2 * 3u);
  result("--modes 20 --reduced reduced.py");
  std::string script = io::read_text(working_folder() / "reduced.py");
  EXPECT_THAT(script, HasSubstr("\"loaded.rz\",\n    \"mode 1\","));
  std::istringstream row(script.substr(script.find("\nK = np.array([\n    [") + 21));
  for (Eigen::Index j = 0; j < 32; ++j) {
    double value = 0;
    char comma = 0;
    row >> value >> comma;
    EXPECT_NEAR(value, k(0, j), 1e-14 * k.norm());
  }
  EXPECT_EQ(kinetostat("modes rod.yaml --reduced reduced.txt").code, 2);
}

// Of the output of CalculiX: what stands after a heading, line by line.
std::vector<std::vector<double>> table_after(const std::string& text, const std::string& heading,
                                             std::size_t count) {
  std::istringstream lines(text.substr(std::min(text.find(heading), text.size())));
  std::vector<std::vector<double>> rows;
  std::string line;
  std::getline(lines, line);
  while (rows.size() < count && std::getline(lines, line)) {
    std::istringstream words(line);
    std::vector<double> row;
    for (double value = 0; words >> value;) row.push_back(value);
    if (row.size() > 1) rows.push_back(row);
  }
  return rows;
}

constexpr char calculix_steps[] = R"(*INCLUDE, INPUT=reduced.inp
*BOUNDARY
N_fixed_translation, 1, 3
N_fixed_rotation, 1, 3
*STEP
*STATIC
*CLOAD
N_loaded_translation, 2, 100.
N_loaded_rotation, 2, 3.
*NODE PRINT, NSET=N_loaded_translation
U
*NODE PRINT, NSET=N_loaded_rotation
U
*END STEP
*STEP
*FREQUENCY
6
*END STEP
)";

// Springs and masses of modes, solved by an independent program: displacements and frequencies of
// the clamped link are those of K and M.
TEST_F(ModesCommand, WritesAReducedModelThatCalculixSolves) {
  ASSERT_TRUE(test::is_installed("ccx"));
  result("--modes 24 --reduced reduced.m");
  result("--modes 24 --reduced reduced.inp");
  io::write_atomically(working_folder() / "steps.inp", calculix_steps);
  const std::string call = "cd '" + working_folder().string() + "' && ccx steps > steps.log 2>&1";
  ASSERT_EQ(std::system(call.c_str()), 0) << io::read_text(working_folder() / "steps.log");
  const std::string found = io::read_text(working_folder() / "steps.dat");
  const std::string script = io::read_text(working_folder() / "reduced.m");
  const Eigen::MatrixXd k = matrix_of(script, "K").bottomRightCorner(30, 30),
                        m = matrix_of(script, "M").bottomRightCorner(30, 30);
  Eigen::VectorXd load = Eigen::VectorXd::Zero(30);
  load[1] = 100;
  load[4] = 3;
  const Eigen::VectorXd moved = k.ldlt().solve(load);
  const auto translation = table_after(found, "for set N_LOADED_TRANSLATION", 1);
  const auto rotation = table_after(found, "for set N_LOADED_ROTATION", 1);
  ASSERT_EQ(translation.size() + rotation.size(), 2u) << found;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    EXPECT_NEAR(translation[0].at(i + 1), moved[at], 1e-6 * moved.head<3>().norm());
    EXPECT_NEAR(rotation[0].at(i + 1), moved[3 + at], 1e-6 * moved.segment<3>(3).norm());
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(k, m);
  const auto frequencies = table_after(found, "E I G E N V A L U E   O U T P U T", 6);
  ASSERT_EQ(frequencies.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    const double exact = std::sqrt(modes.eigenvalues()[static_cast<Eigen::Index>(i)]) / (2 * M_PI);
    EXPECT_NEAR(frequencies[i].at(3), exact, 1e-6 * exact);
  }
}

// The record groups of MBDyn's modal joint, by number, as its manual describes them: comments are
// lines that start with "**", numbers stand in any lines.
std::map<int, std::vector<double>> record_groups(const std::string& text) {
  std::map<int, std::vector<double>> groups;
  std::istringstream lines(text);
  int group = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("**")) {
      (void)std::sscanf(line.c_str(), "** RECORD GROUP %d", &group);
      continue;
    }
    std::istringstream words(line);
    for (std::string word; words >> word;)
      if (word != "REV0") groups[group].push_back(std::stod(word));
  }
  return groups;
}

Eigen::MatrixXd shaped(const std::vector<double>& values, Eigen::Index rows) {
  return Eigen::Map<const Eigen::MatrixXd>(values.data(), rows, std::ssize(values) / rows);
}

// Rigid motions of all nodes about the origin.
Eigen::MatrixXd rigid_motions(const std::map<int, std::vector<double>>& groups) {
  const std::size_t nodes = groups.at(2).size();
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(6 * std::ssize(groups.at(2)), 6);
  for (std::size_t i = 0; i < nodes; ++i) {
    const Eigen::Vector3d at(groups.at(5)[i], groups.at(6)[i], groups.at(7)[i]);
    auto here = motions.middleRows<6>(6 * static_cast<Eigen::Index>(i));
    here.setIdentity();
    for (Eigen::Index k = 0; k < 3; ++k)
      here.col(3 + k).head<3>() = Eigen::Vector3d::Unit(k).cross(at);
  }
  return motions;
}

// Of [mass, centre of mass, inertia about it], about the origin.
Eigen::MatrixXd rigid_mass(const std::vector<double>& group) {
  const Eigen::Vector3d c(group[1], group[2], group[3]);
  Eigen::Matrix3d cross;
  cross << 0, -c.z(), c.y(), c.z(), 0, -c.x(), -c.y(), c.x(), 0;
  Eigen::MatrixXd mass(6, 6);
  mass << group[0] * Eigen::Matrix3d::Identity(), -group[0] * cross, group[0] * cross,
      Eigen::Map<const Eigen::Matrix3d>(group.data() + 4) - group[0] * cross * cross;
  return mass;
}

// A floating link of these modes, clamped at its first node: y moves the modes, and the rigid
// motion that takes the node back.
TEST_F(ModesCommand, WritesAReducedModelForMbdyn) {
  result("--modes 12 --reduced reduced.m --reduced reduced.fem");
  const std::string script = io::read_text(working_folder() / "reduced.m");
  const Eigen::MatrixXd k = matrix_of(script, "K").bottomRightCorner(18, 18),
                        m = matrix_of(script, "M").bottomRightCorner(18, 18);
  const auto groups = record_groups(io::read_text(working_folder() / "reduced.fem"));
  EXPECT_EQ(groups.at(1), (std::vector<double>{2, 18, 0, 0, 0}));
  EXPECT_EQ(groups.at(3), std::vector<double>(18));
  EXPECT_EQ(groups.at(4), std::vector<double>(18));
  ASSERT_EQ(groups.at(12).size(), 13u);
  const Eigen::MatrixXd shapes = shaped(groups.at(8), 12), rigid = rigid_motions(groups);
  ASSERT_EQ(shapes.cols(), 18);
  const Eigen::MatrixXd back = -rigid.topRows<6>().partialPivLu().solve(shapes.topRows<6>());
  const Eigen::MatrixXd stiffness = shaped(groups.at(10), 18);
  const Eigen::MatrixXd mass =
      shaped(groups.at(9), 18) + back.transpose() * rigid_mass(groups.at(12)) * back;
  const Eigen::MatrixXd moved = shapes.bottomRows<6>() + rigid.bottomRows<6>() * back;
  const Eigen::MatrixXd compliance = moved * stiffness.ldlt().solve(moved.transpose());
  const Eigen::MatrixXd exact = k.inverse().topLeftCorner<6, 6>();
  for (Eigen::Index i = 0; i < 6; ++i)
    for (Eigen::Index j = 0; j < 6; ++j)
      EXPECT_NEAR(compliance(i, j), exact(i, j), 1e-6 * std::sqrt(exact(i, i) * exact(j, j)));
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> found(stiffness, mass),
      expected(k, m);
  for (Eigen::Index i = 0; i < 6; ++i)
    EXPECT_NEAR(std::sqrt(found.eigenvalues()[i] / expected.eigenvalues()[i]), 1, 1e-6) << i;
}

// The matrix "constexpr Entry NAME[] = {{row, column, value}, ..};" of a header.
Eigen::MatrixXd entries_of(const std::string& header, const std::string& name) {
  int size = 0;
  (void)std::sscanf(header.c_str() + header.find("constexpr int size"), "constexpr int size = %d",
                    &size);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
  std::istringstream lines(header.substr(header.find("constexpr Entry " + name + "[] = {\n")));
  std::string line;
  std::getline(lines, line);
  int row = 0, column = 0;
  double value = 0;
  while (std::getline(lines, line) &&
         std::sscanf(line.c_str(), " {%d, %d, %lf}", &row, &column, &value) == 3)
    matrix(row, column) = value;
  return matrix;
}

// What ChModalAssembly makes of K and M, as its sources say: modes with the nodes outside held, of
// which it keeps the lowest, beside the answers to motions of these nodes.
Eigen::MatrixXd chrono_basis(const Eigen::MatrixXd& k, const Eigen::MatrixXd& m,
                             Eigen::Index outside, Eigen::Index modes) {
  const Eigen::Index inside = k.rows() - outside;
  const auto k_ii = k.bottomRightCorner(inside, inside), m_ii = m.bottomRightCorner(inside, inside);
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> held(k_ii, m_ii);
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(k.rows(), outside + modes);
  basis.topLeftCorner(outside, outside).setIdentity();
  basis.bottomLeftCorner(inside, outside) = -k_ii.ldlt().solve(k.bottomLeftCorner(inside, outside));
  basis.bottomRightCorner(inside, modes) =
      -k_ii.ldlt().solve(m_ii * held.eigenvectors().leftCols(modes));
  for (Eigen::Index i = outside; i < basis.cols(); ++i)
    basis.col(i) /= std::sqrt(basis.col(i).dot(m * basis.col(i)));
  return basis;
}

// Of a clamped link: the first node at rest.
TEST_F(ModesCommand, WritesAReducedModelForChrono) {
  const io::Json given = result("--modes 10 --reduced reduced.m --reduced reduced.hpp");
  const std::string script = io::read_text(working_folder() / "reduced.m"),
                    header = io::read_text(working_folder() / "reduced.hpp");
  EXPECT_THAT(header, HasSubstr("\nnamespace link_test_bar {\n\nconstexpr int modes = 10;\n"));
  EXPECT_THAT(header, HasSubstr("// Not in this file: damping, gravity, "));
  EXPECT_THAT(header, HasSubstr("    {\"loaded\", {0.31, 0, 0}},\n"));
  const Eigen::MatrixXd all_k = entries_of(header, "K"), all_m = entries_of(header, "M");
  ASSERT_EQ(all_k.rows() % 6, 0);
  ASSERT_GE(all_k.rows(), 12 + 2 * 10 + 3);  // Chrono searches among twice as many
  const Eigen::MatrixXd basis = chrono_basis(all_k, all_m, 12, 10);
  const Eigen::MatrixXd k = (basis.transpose() * all_k * basis).bottomRightCorner(16, 16),
                        m = (basis.transpose() * all_m * basis).bottomRightCorner(16, 16);
  const Eigen::MatrixXd exact_k = matrix_of(script, "K").bottomRightCorner(16, 16),
                        exact_m = matrix_of(script, "M").bottomRightCorner(16, 16);
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> found(k, m),
      expected(exact_k, exact_m);
  for (Eigen::Index i = 0; i < 16; ++i)
    EXPECT_NEAR(std::sqrt(found.eigenvalues()[i] / expected.eigenvalues()[i]), 1, 1e-6) << i;
  const double first = given["modes"][0]["frequency"].get<double>();
  EXPECT_NEAR(std::sqrt(found.eigenvalues()[0]) / (2 * M_PI), first, 1e-5 * first);
  ASSERT_EQ(kinetostat("identify rod.yaml -q -o rod.json").code, 0);
  const io::Json link = io::read_json(working_folder() / "rod.json");
  const Eigen::MatrixXd compliance = k.inverse().topLeftCorner<6, 6>();
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j) {
      const auto at = [](std::size_t n) { return static_cast<Eigen::Index>(n); };
      EXPECT_NEAR(compliance(at(i), at(j)), link["compliance"][i][j].get<double>(),
                  1e-6 * std::sqrt(compliance(at(i), at(i)) * compliance(at(j), at(j))));
    }
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

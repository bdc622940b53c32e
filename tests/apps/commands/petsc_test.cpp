// The solver in PETSc, on one process and several, beside the factors of the matrix.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::petsc_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

class Petsc : public testing::Test {
 protected:
  void SetUp() override {
#ifndef KINETOSTAT_HAS_PETSC
    GTEST_SKIP() << "PETSc is not installed (Debian: libpetsc-real-dev)";
#endif
    setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 1);  // in a container
    setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 1);
    setenv("OMPI_MCA_rmaps_base_oversubscribe", "1", 1);  // on one processor
    setenv("OMPI_MCA_mpi_yield_when_idle", "1", 1);       // which has other work
  }

  // A bar whose ends both have this coupling, of elements so large [mm].
  static void write_link(const std::string& coupling, int size = 24) {
    std::string text = io::read_text(working_folder() / "meshes/test_bar.yaml");
    text.replace(text.find("size: 3"), 7, "size: " + std::to_string(size));
    text.replace(text.find("test_bar.stl"), 12, "meshes/test_bar.stl");
    text.replace(text.find("coupling: rigid"), 15, "coupling: " + coupling);
    if (const std::size_t fixed = text.find("fixed:"); fixed != std::string::npos)
      text.insert(text.find('{', fixed) + 1, "coupling: " + coupling + ", ");
    std::ofstream(working_folder() / "petsc.yaml") << text;
  }

  // A square plate as ASCII STL [mm].
  static std::string plate(double side, double thickness) {
    constexpr int corners[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                    {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                    {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    std::ostringstream stl;
    stl << "solid plate\n";
    for (const auto& triangle : corners) {
      stl << "facet normal 0 0 0\nouter loop\n";
      for (const int c : triangle)
        stl << "vertex " << side * (c & 1) << ' ' << side * (c >> 1 & 1) << ' '
            << thickness * (c >> 2) << '\n';
      stl << "endloop\nendfacet\n";
    }
    stl << "endsolid plate\n";
    return stl.str();
  }

  static io::Json identified(const std::string& options) {
    const Outcome outcome =
        kinetostat("identify petsc.yaml --no-cache --bracket never -q -o petsc.json " + options);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return io::read_json(working_folder() / "petsc.json");
  }

  // The 1e-8 that is asked for, of every entry beside its diagonal.
  static void expect_agreement(const io::Json& a, const io::Json& b) {
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = 0; j < 6; ++j) {
        const auto entry = [&](const io::Json& json, std::size_t r, std::size_t c) {
          return json["compliance"][r][c].get<double>();
        };
        EXPECT_NEAR(entry(a, i, j), entry(b, i, j),
                    1e-8 * std::sqrt(entry(b, i, i) * entry(b, j, j)));
      }
  }
};

class PetscProcesses : public Petsc {
 protected:
  void SetUp() override {
    Petsc::SetUp();
    if (!IsSkipped() && std::system("command -v mpirun > /dev/null 2>&1") != 0)
      GTEST_SKIP() << "mpirun is not installed (Debian: openmpi-bin)";
  }
};

// A rigid body, springs to the ground, and elements of a second, much stiffer material.
TEST_F(Petsc, OneProcessAgreesWithTheFactors) {
  for (const char* coupling : {"rigid", "distributing", "body"}) {
    write_link(coupling);
    const io::Json one = identified("--solver petsc");
    EXPECT_EQ(one["solver"]["method"], "petsc");
    expect_agreement(one, identified("--solver direct"));
  }
}

TEST_F(PetscProcesses, SeveralProcessesAgreeWithTheFactors) {
  const std::pair<const char*, std::vector<const char*>> cases[] = {
      {"rigid", {"2", "3", "4"}}, {"distributing", {"3"}}, {"body", {"4"}}};
  for (const auto& [coupling, numbers] : cases) {
    write_link(coupling, 12);
    const io::Json direct = identified("--solver direct");
    for (const char* processes : numbers)
      expect_agreement(identified(std::string("--solver petsc --processes ") + processes), direct);
  }
}

// Elements with curved edges, and springs on their middle nodes.
TEST_F(PetscProcesses, AgreeOnElementsWithCurvedEdges) {
  if (!std::filesystem::exists(
          std::filesystem::path(KINETOSTAT_PROGRAM).replace_filename("kinetostat-step")))
    GTEST_SKIP() << "Open CASCADE is not installed";
  std::string text = io::read_text(working_folder() / "meshes/cad/cylinder.yaml");
  text.replace(text.find("cylinder.step"), 13, "meshes/cad/cylinder.step");
  text.replace(text.find("accuracy: 1 %"), 13, "order: 2, size: 8");
  std::ofstream(working_folder() / "petsc.yaml") << text;
  const io::Json direct = identified("--solver direct");
  expect_agreement(identified("--solver petsc --processes 3"), direct);
}

// Some processes have no unknowns then.
TEST_F(PetscProcesses, MayBeMoreThanASmallModelFills) {
  write_link("rigid", 100);
  expect_agreement(identified("--solver petsc --processes 4"), identified("--solver direct"));
}

// So that many processes, and machines, hold what one cannot.
TEST_F(PetscProcesses, DivideTheModelAmongThem) {
  write_link("rigid", 6);
  const io::Json one = identified("--solver petsc");
  const io::Json four = identified("--solver petsc --processes 4");
  const auto elements = one["mesh"]["elements"].get<double>();
  EXPECT_EQ(one["solver"]["most_elements"].get<double>(), elements);
  EXPECT_LT(four["solver"]["most_elements"].get<double>(), 0.35 * elements);
  EXPECT_GE(four["solver"]["most_elements"].get<double>(), 0.25 * elements);
  const auto peak = [](const io::Json& json, const char* key) {
    return json["timings"][key].get<double>();
  };
  EXPECT_EQ(peak(one, "memory_helper"), peak(one, "memory_helper_largest"));
  EXPECT_LT(peak(four, "memory_helper_largest"), 0.5 * peak(four, "memory_helper"));
  expect_agreement(four, one);
}

// The corners about it are more than PETSc's aggregation takes in one row.
TEST_F(PetscProcesses, AgreeOnAReferenceBodyOnALargeInterface) {
  std::string text = io::read_text(working_folder() / "meshes/test_bar.yaml");
  text.replace(text.find("test_bar.stl"), 12, "petsc_plate.stl");
  text.replace(text.find("[0, 0, 0], normal: [-1, 0, 0]"), 29, "[0, 0, 0], normal: [0, 0, -1]");
  text.replace(text.find("[310, 0, 0], normal: [1, 0, 0]"), 30, "[0, 0, 6], normal: [0, 0, 1]");
  text.replace(text.find("point: [310, 0, 0], coupling"), 28, "point: [30, 30, 6], coupling");
  text.replace(text.find("size: 3"), 7, "size: 2.6");
  std::ofstream(working_folder() / "petsc.yaml") << text;
  std::ofstream(working_folder() / "petsc_plate.stl") << plate(60, 6);
  const io::Json direct = identified("--solver direct");
  expect_agreement(identified("--solver petsc"), direct);
  expect_agreement(identified("--solver petsc --processes 3"), direct);
}

TEST_F(Petsc, SaysWhichLauncherIsMissing) {
  write_link("rigid");
  const Outcome outcome = kinetostat(
      "identify petsc.yaml --no-cache --solver petsc --processes 2 --launcher 'no-such-mpirun -q'");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("'no-such-mpirun'"));
  EXPECT_THAT(outcome.err, HasSubstr("openmpi-bin"));
}

TEST_F(Petsc, PassesOnWhatTheLauncherSays) {
  write_link("rigid");
  const Outcome outcome = kinetostat(
      "identify petsc.yaml --no-cache --solver petsc --processes 2 --launcher 'ls "
      "--no-such-option'");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("no-such-option"));
}

}  // namespace
}  // namespace kinetostat::petsc_test

// The solver in PETSc, on one process and on two, beside the factors of the matrix.
#include <cmath>
#include <cstdlib>
#include <fstream>

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

  // A coarse bar whose ends both have this coupling.
  static void write_link(const std::string& coupling) {
    std::string text = io::read_text(working_folder() / "meshes/test_bar.yaml");
    text.replace(text.find("size: 3"), 7, "size: 24");
    text.replace(text.find("test_bar.stl"), 12, "meshes/test_bar.stl");
    text.replace(text.find("coupling: rigid"), 15, "coupling: " + coupling);
    if (const std::size_t fixed = text.find("fixed:"); fixed != std::string::npos)
      text.insert(text.find('{', fixed) + 1, "coupling: " + coupling + ", ");
    std::ofstream(working_folder() / "petsc.yaml") << text;
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

TEST_F(Petsc, OneProcessAndTwoAgreeWithTheFactors) {
  for (const char* coupling : {"rigid", "distributing"}) {  // a rigid body; springs to the ground
    write_link(coupling);
    const io::Json direct = identified("--solver direct");
    const io::Json one = identified("--solver petsc");
    EXPECT_EQ(one["solver"]["method"], "petsc");
    expect_agreement(one, direct);
    if (std::system("command -v mpirun > /dev/null 2>&1") != 0)
      GTEST_SKIP() << "mpirun is not installed (Debian: openmpi-bin): one process only";
    expect_agreement(identified("--solver petsc --processes 2"), direct);
  }
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

#include "kinetostat/fea/link/modal_study.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"

#include "fea/shapes.h"

namespace kinetostat::fea::modal_study_test {
namespace {

using testing::HasSubstr;

const SurfaceMesh bar = box_surface({0, -0.01, -0.006}, {0.1, 0.01, 0.006});

class ModalStudy : public testing::Test {
 protected:
  ModalResult run(const std::string& elements, ModalOptions options = {},
                  const std::string& density = ", density: 7850 kg/m^3") {
    folder_.file("bar.stl", binary_stl(bar, 1000));
    const LinkSpec spec =
        read_link(folder_.file("bar.yaml",
                               "kinetostat: 1\nlink: bar\nmesh: {file: bar.stl, unit: mm}\n"
                               "material: {E: 210 GPa, nu: 0.3" +
                                   density +
                                   "}\n"
                                   "fixed: {plane: {point: [0, 0, 0], normal: [-1, 0, 0]}}\n"
                                   "loaded: {plane: {point: [100, 0, 0], normal: [1, 0, 0]}, "
                                   "coupling: distributing}\n"
                                   "elements: {" +
                                   elements + "}\n"));
    options.meshing.helper = KINETOSTAT_TETGEN;
    common::Progress silent;
    return modal_study(spec, read_geometry(spec, silent), options, silent);
  }
  TemporaryFolder folder_;
};

TEST_F(ModalStudy, RefinesToTheAccuracyAskedForAndNotToTwiceIt) {
  const ModalResult coarse = run("accuracy: 2 %", {.modes = 4});
  ASSERT_EQ(coarse.modes.size(), 4u);
  EXPECT_TRUE(coarse.accuracy.converged);
  EXPECT_GE(coarse.accuracy.meshes.size(), 2u);
  EXPECT_LE(coarse.error(), 0.02);
  // The bars of 1 / omega^2 are twice as wide.
  EXPECT_NEAR(2 * coarse.error(), coarse.accuracy.bars.relative_error, 1e-12);
}

// The frequencies come down, and the bars of a coarse mesh hold those of a fine one.
TEST_F(ModalStudy, BarsHoldTheFrequenciesOfAFinerMesh) {
  const ModalResult coarse = run("size: 12", {.modes = 5}), fine = run("size: 3", {.modes = 5});
  for (std::size_t k = 0; k < 5; ++k) {
    const double down = 1 - fine.modes[k].frequency / coarse.modes[k].frequency;
    EXPECT_GT(down, 0) << k;
    EXPECT_LT(down, coarse.modes[k].error) << k;
    EXPECT_LT(coarse.modes[k].error, 30 * down) << k;  // and are no empty promise
    EXPECT_LT(fine.modes[k].error, coarse.modes[k].error) << k;
  }
}

TEST_F(ModalStudy, SaysWhichWayItMovesAndHowMuchTakesPart) {
  const ModalResult result = run("size: 6", {.modes = 40});
  // A bar along x, higher along y than along z: it bends along z first.
  EXPECT_GT(result.modes[0].motion.z(), 0.95);
  EXPECT_GT(result.modes[1].motion.y(), 0.95);
  Vector3 sum = Vector3::Zero();
  for (const NaturalMode& mode : result.modes) {
    EXPECT_NEAR(mode.motion.sum(), 1, 1e-9);
    sum += mode.effective_mass;
  }
  EXPECT_LT(sum.maxCoeff(), 1 + 1e-9);
  EXPECT_GT(sum.minCoeff(), 0.9);  // what is at the clamp does not take part
  // Of Euler and Bernoulli's first mode of a cantilever: (integral of w)^2 / (L integral of w^2).
  EXPECT_NEAR(result.modes[0].effective_mass.z(), 0.6131, 0.005);
  const double mass = 7850 * 0.1 * 0.02 * 0.012;
  EXPECT_NEAR(result.mass, mass, 1e-9 * mass);
}

TEST_F(ModalStudy, InTheAirNothingShakesIt) {
  const ModalResult result = run("size: 8", {.support = Support::none, .modes = 3});
  for (const NaturalMode& mode : result.modes) EXPECT_EQ(mode.effective_mass.norm(), 0);
}

TEST_F(ModalStudy, NamesTheLineOfTheMaterialWithoutDensity) {
  try {
    run("size: 8", {}, "");
    FAIL();
  } catch (const common::InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("bar.yaml:4: material: there is no density"));
    EXPECT_THAT(error.what(), HasSubstr("7850 kg/m^3"));
  }
}

TEST_F(ModalStudy, RefusesMoreThanTheMemory) {
  EXPECT_ANY_THROW(run("size: 4", {.solver = {.memory = 1e6}}));
}

}  // namespace
}  // namespace kinetostat::fea::modal_study_test

#include "kinetostat/fea/link/refinement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/out_of_memory.h"

#include "fea/reference_bar.h"

namespace kinetostat::fea::refinement_test {
namespace {

using testing::HasSubstr;

// A stub of a bar: 60 x 20 x 12 mm, root held, tip rigid.
class Refine : public testing::Test {
 protected:
  LinkModel solved(const SizeField& sizes) {
    std::vector<int> tags(12, 0);
    tags[8] = tags[9] = 1;
    tags[10] = tags[11] = 2;
    TetrahedralizeOptions options;
    options.sizes = sizes;
    options.helper = KINETOSTAT_TETGEN;
    LinkModel model{.mesh = with_mid_nodes(tetrahedralize(surface_, tags, options, silent_)),
                    .materials = {Material(210e9, 0.3)}};
    model.interfaces = coupled_ends(model.mesh);
    model.response = respond(model.mesh, model.materials, model.interfaces, {}, silent_);
    ++meshes_;
    return model;
  }
  RefinedModel refined(const RefinementOptions& options) {
    return refine([this](const SizeField& sizes) { return solved(sizes); },
                  size_from_surface(surface_), options, silent_);
  }

  SurfaceMesh surface_ = box_surface({0, 0, 0}, {0.06, 0.02, 0.012});
  common::Progress silent_;
  std::size_t meshes_ = 0;
};

TEST_F(Refine, ReachesTheAccuracyAndItsBarsHoldTheTrueError) {
  const RefinedModel coarse = refined({.accuracy = 0.02});
  EXPECT_TRUE(coarse.accuracy.converged) << coarse.accuracy.shortfall;
  EXPECT_LE(coarse.accuracy.bars.relative_error, 0.02);
  const RefinedModel fine = refined({.accuracy = 0.002});
  EXPECT_TRUE(fine.accuracy.converged) << fine.accuracy.shortfall;
  EXPECT_GT(fine.model.response.solver.unknowns, 2 * coarse.model.response.solver.unknowns);
  const ErrorBars& bars = coarse.accuracy.bars;
  const Eigen::MatrixXd& c = coarse.accuracy.meshes.back().flexibility;
  const Eigen::MatrixXd& reference = fine.accuracy.meshes.back().flexibility;
  for (Eigen::Index i = 0; i < 6; ++i)
    for (Eigen::Index j = 0; j < 6; ++j) {
      if (!bars.significant(i, j)) continue;
      const double error = std::abs(c(i, j) - reference(i, j));
      EXPECT_LT(error, bars.bar(i, j)) << i << j;
      EXPECT_LT(error, 0.02 * std::abs(reference(i, j))) << i << j;
    }
}

TEST_F(Refine, IndicatorsSumToOne) {
  const RefinedModel model = refined({.accuracy = 0.1});
  ASSERT_EQ(model.accuracy.indicator.size(), model.model.mesh.element_count());
  double sum = 0;
  for (const double share : model.accuracy.indicator) sum += share;
  EXPECT_NEAR(sum, 1, 1e-12);
}

TEST_F(Refine, OneMeshIsNeverEnough) {
  const RefinedModel model = refined({.accuracy = 0.4});
  EXPECT_GE(meshes_, 2u);
  EXPECT_TRUE(model.accuracy.converged) << model.accuracy.shortfall;
}

TEST_F(Refine, SaysWhyItStoppedShort) {
  const RefinedModel model = refined({.accuracy = 1e-4, .most_meshes = 2});
  EXPECT_FALSE(model.accuracy.converged);
  EXPECT_THAT(model.accuracy.shortfall, HasSubstr("0.01 % was asked for; 2 meshes are the limit"));
  EXPECT_EQ(model.accuracy.meshes.size(), 2u);
}

TEST_F(Refine, GoesToTheLimitOfUnknownsAndNotBeyond) {
  constexpr std::size_t limit = 40000;
  const RefinedModel model = refined({.accuracy = 1e-5, .most_unknowns = limit});
  EXPECT_FALSE(model.accuracy.converged);
  EXPECT_THAT(model.accuracy.shortfall, HasSubstr("40000 unknowns are the limit"));
  EXPECT_LE(model.accuracy.meshes.back().unknowns, limit);
  EXPECT_GT(model.accuracy.meshes.back().unknowns, limit / 2);
}

// Whatever interrupts a later mesh, the mesh before it is the result.
TEST_F(Refine, KeepsTheLastGoodMesh) {
  const auto interrupted = [&](auto error) {
    meshes_ = 0;
    return refine(
        [&](const SizeField& sizes) {
          if (meshes_ == 1) throw error;
          return solved(sizes);
        },
        size_from_surface(surface_), {.accuracy = 1e-4}, silent_);
  };
  for (const RefinedModel& model :
       {interrupted(common::Cancelled()), interrupted(std::bad_alloc()),
        interrupted(common::OutOfMemory("the solver needs 9 GiB", "Allow more")),
        interrupted(common::InputError("link.yaml", "TetGen crashed"))}) {
    EXPECT_FALSE(model.accuracy.converged);
    EXPECT_EQ(model.accuracy.meshes.size(), 1u);
    EXPECT_EQ(model.accuracy.indicator.size(), model.model.mesh.element_count());
    EXPECT_THAT(model.accuracy.shortfall, HasSubstr("was asked for; "));
  }
}

TEST_F(Refine, ThrowsWhatStopsTheFirstMesh) {
  const Solve fails = [](const SizeField&) -> LinkModel { throw common::Cancelled(); };
  EXPECT_THROW(refine(fails, size_from_surface(surface_), {}, silent_), common::Cancelled);
}

}  // namespace
}  // namespace kinetostat::fea::refinement_test

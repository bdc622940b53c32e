#include "kinetostat/fea/mesh/size_field.h"

#include <algorithm>
#include <numeric>

#include <gtest/gtest.h>

#include "kinetostat/fea/mesh/tetrahedralize.h"

#include "fea/shapes.h"

namespace kinetostat::fea::size_field_test {
namespace {

double least(const SizeField& field) {
  return *std::min_element(field.sizes.begin(), field.sizes.end());
}

// A plate of 2 mm asks for elements of its thickness, a block for a part of itself.
TEST(SizeField, FollowsTheThicknessOfTheSurface) {
  const SizeField plate = size_from_surface(box_surface({0, 0, 0}, {0.1, 0.1, 0.002}));
  EXPECT_NEAR(least(plate), 1.5 * 0.002, 1e-12);
  const SizeField block = size_from_surface(box_surface({0, 0, 0}, {0.1, 0.1, 0.1}));
  EXPECT_NEAR(least(block), 0.1 * std::sqrt(3.0) * 0.1, 1e-12);
}

TEST(SizeField, FollowsTheCurvatureOfTheSurface) {
  const SizeField tube = size_from_surface(tube_surface(0.05, 0.5, 0.5, 48));
  EXPECT_NEAR(least(tube), 0.05, 0.001);
}

class SizeFromError : public testing::Test {
 protected:
  TetMesh mesh_ = with_mid_nodes(box_mesh({1, 1, 1}, 4, 4, 4));
  std::vector<double> even_ = std::vector<double>(mesh_.element_count(), 1);
  // Of a field without change.
  double present_ = size_from_error(mesh_, even_, {.share = 1}).sizes.front();
};

// Errors fall as h^4: a sixteenth of them takes half the size everywhere.
TEST_F(SizeFromError, SpreadsAnEvenErrorEvenly) {
  const SizeField field = size_from_error(mesh_, even_, {.share = 1.0 / 16, .most_growth = 1000});
  for (const double size : field.sizes) EXPECT_NEAR(size, 0.5 * present_, 1e-3 * present_);
}

TEST_F(SizeFromError, RefinesWhereTheErrorIs) {
  std::vector<double> error = even_;
  for (std::size_t e = 0; e < error.size(); ++e)
    if (mesh_.corners(e)[0].x() + mesh_.corners(e)[1].x() < 0.6) error[e] = 1000;
  const SizeField field = size_from_error(mesh_, error, {.share = 0.1, .most_growth = 1000});
  double near = 0, far = 1e9;
  for (std::size_t i = 0; i < field.points.size(); ++i) {
    if (field.points[i].x() == 0) near = std::max(near, field.sizes[i]);
    if (field.points[i].x() == 1) far = std::min(far, field.sizes[i]);
  }
  EXPECT_LT(near, 0.6 * far);
}

TEST_F(SizeFromError, KeepsTheGrowthWithinItsLimits) {
  const SizeField most = size_from_error(mesh_, even_, {.share = 1e-6, .most_growth = 8});
  EXPECT_NEAR(least(most), 0.5 * present_, 1e-3 * present_);
  const SizeField fewest = size_from_error(mesh_, even_, {.share = 1, .least_growth = 3.375});
  EXPECT_NEAR(least(fewest), present_ / 1.5, 1e-3 * present_);
}

TEST_F(SizeFromError, ANullErrorLetsElementsGrow) {
  const std::vector<double> none(mesh_.element_count(), 0);
  for (const double size : size_from_error(mesh_, none, {}).sizes) EXPECT_GT(size, present_);
}

// What TetGen makes of it: small elements at one end of a bar, large ones at the other.
TEST(SizeField, GradesTheTetrahedra) {
  SizeField field;
  for (int i = 0; i <= 50; ++i) {
    field.points.emplace_back(0.1 * i / 50, 0.005, 0.005);
    field.sizes.push_back(0.0007 + 0.1 * 0.1 * i / 50);
  }
  TetrahedralizeOptions options;
  options.sizes = field;
  options.helper = KINETOSTAT_TETGEN;
  common::Progress silent;
  const TetMesh mesh = tetrahedralize(box_surface({0, 0, 0}, {0.1, 0.01, 0.01}),
                                      std::vector<int>(12, 0), options, silent);
  std::size_t near = 0, far = 0;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const double x = mesh.corners(e)[0].x();
    near += x < 0.02 ? 1 : 0;
    far += x > 0.08 ? 1 : 0;
    if (x < 0.01) {
      EXPECT_LT(volume(mesh.corners(e)), 1.3 * std::pow(0.0017, 3) / 8.48);
    }
  }
  EXPECT_GT(near, 10 * far);
  EXPECT_NEAR(mass_properties(mesh).volume, 1e-5, 1e-15);
}

}  // namespace
}  // namespace kinetostat::fea::size_field_test

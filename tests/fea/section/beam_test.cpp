#include <gtest/gtest.h>

#include "kinetostat/spatial/stiffness.h"

#include "fea/reference_bar.h"

namespace kinetostat::fea::beam_test {
namespace {

// Torsion constant of a rectangle a > b by Saint-Venant's series.
double torsion_constant(double a, double b) {
  double sum = 0;
  for (int n = 1; n < 60; n += 2) sum += std::tanh(n * M_PI * a / (2 * b)) / std::pow(n, 5);
  return a * b * b * b / 3 * (1 - 192 * b / (std::pow(M_PI, 5) * a) * sum);
}

// A clamped Timoshenko beam along x with a rigid end face, shear factor 5/6.
Matrix6 timoshenko(double l, double a, double b, double e, double nu) {
  const double area = a * b, g = e / (2 * (1 + nu)), shear = l / (5.0 / 6 * g * area);
  const double iz = b * a * a * a / 12, iy = a * b * b * b / 12;  // bending in y, in z
  Matrix6 c = Matrix6::Zero();
  c(0, 0) = l / (e * area);
  c(1, 1) = l * l * l / (3 * e * iz) + shear;
  c(2, 2) = l * l * l / (3 * e * iy) + shear;
  c(3, 3) = l / (g * torsion_constant(a, b));
  c(4, 4) = l / (e * iy);
  c(5, 5) = l / (e * iz);
  c(1, 5) = c(5, 1) = l * l / (2 * e * iz);
  c(2, 4) = c(4, 2) = -l * l / (2 * e * iy);
  return c;
}

TEST(Beam, TheReferenceBarAgreesWithTimoshenkoWithinOnePercent) {
  const ReferenceBar bar(0.003);
  const Matrix6 c = bar.compliance();
  EXPECT_LT(spatial::symmetry_defect(c), 1e-9);
  const Matrix6 beam = timoshenko(bar.length, bar.width, bar.height, 210e9, 0.3);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      if (beam(i, j) != 0) {
        EXPECT_NEAR(c(i, j) / beam(i, j), 1, 0.01) << i << j;
      } else {
        // Zero by symmetry of the bar; the mesh is not symmetric.
        EXPECT_LT(std::abs(c(i, j)), 1e-4 * std::sqrt(c(i, i) * c(j, j))) << i << j;
      }
    }
}

// Finer meshes are softer: displacement elements approach from below.
TEST(Beam, ComplianceGrowsWithRefinementAndSettles) {
  const Matrix6 coarse = ReferenceBar(0.012).compliance(),
                medium = ReferenceBar(0.008).compliance(), fine = ReferenceBar(0.005).compliance();
  for (int i = 0; i < 6; ++i) {
    EXPECT_LT(coarse(i, i), medium(i, i)) << i;
    EXPECT_LT(medium(i, i), fine(i, i)) << i;
    EXPECT_LT(fine(i, i) - medium(i, i), medium(i, i) - coarse(i, i)) << i;
    EXPECT_LT(fine(i, i) / medium(i, i) - 1, 1e-2) << i;
  }
}

}  // namespace
}  // namespace kinetostat::fea::beam_test

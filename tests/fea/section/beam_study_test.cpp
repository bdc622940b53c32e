// Beams found in solid bodies, against the beam theory of the textbooks.
#include "kinetostat/fea/section/beam_study.h"

#include <cmath>
#include <functional>
#include <map>

#include <gtest/gtest.h>

#include "fea/shapes.h"

namespace kinetostat::fea::beam_study_test {
namespace {

constexpr double pi = 3.14159265358979323846;
const Material steel(210e9, 0.3);

// The sides of elements that belong to one element only.
SurfaceMesh skin(const TetMesh& mesh) {
  const std::size_t sides[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  std::map<std::array<int, 3>, std::pair<Triangle, int>> uses;
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    for (const auto& side : sides) {
      const Triangle t{mesh.element(e)[side[0]], mesh.element(e)[side[1]],
                       mesh.element(e)[side[2]]};
      std::array<int, 3> key = t;
      std::sort(key.begin(), key.end());
      auto& use = uses[key];
      use.first = t;
      ++use.second;
    }
  SurfaceMesh surface{.points = mesh.nodes};
  for (const auto& [key, use] : uses)
    if (use.second == 1) surface.triangles.push_back(use.first);
  return surface;
}

// A bar along x, bent into shape.
struct BentBar {
  TetMesh mesh;
  SurfaceMesh surface;
  Interface fixed, loaded;

  BentBar(const Vector3& size, int along, int across, const std::function<Vector3(Vector3)>& bend)
      : mesh(box_mesh(size, along, across, across)) {
    for (Vector3& p : mesh.nodes) p = bend(p - Vector3(0, size.y() / 2, size.z() / 2));
    surface = skin(mesh);
    fixed = interface_on(mesh, 1);
    loaded = interface_on(mesh, 2);
  }
  BeamStudy study(const BeamOptions& options = {}) const {
    common::Progress silent;
    return study_beams({surface, mesh, fixed, loaded}, steel, loaded.centroid, options, silent);
  }
};

Vector3 straight(const Vector3& p) { return p; }

// Around the origin from (R, 0) counterclockwise.
std::function<Vector3(Vector3)> around(double radius) {
  return [radius](const Vector3& p) {
    const double angle = p.x() / radius, r = radius - p.y();
    return Vector3(r * std::cos(angle), r * std::sin(angle), p.z());
  };
}

double torsion_constant(double a, double b) {
  double sum = 0;
  for (int n = 1; n < 100; n += 2) sum += std::tanh(n * pi * a / (2 * b)) / std::pow(n, 5);
  return a * b * b * b / 3 * (1 - 192 * b / (std::pow(pi, 5) * a) * sum);
}

TEST(BeamStudy, StraightBarIsTimoshenkosBeamWhateverTheNumberOfBeams) {
  const double l = 0.31, a = 0.02, b = 0.012, e = 210e9, g = e / 2.6;
  const BeamStudy study = BentBar({l, a, b}, 30, 3, straight).study();
  EXPECT_NEAR(study.axis.length(), l, 1e-6 * l);
  ASSERT_EQ(study.models.size(), 3u);
  const double iz = b * a * a * a / 12, iy = a * b * b * b / 12;
  for (const BeamModel& model : study.models) {
    const Matrix6& c = model.compliance.matrix();
    EXPECT_NEAR(c(0, 0) / (l / (e * a * b)), 1, 1e-6) << model.name;
    EXPECT_NEAR(c(4, 4) / (l / (e * iy)), 1, 1e-6) << model.name;
    EXPECT_NEAR(c(5, 5) / (l / (e * iz)), 1, 1e-6) << model.name;
    EXPECT_NEAR(c(1, 5) / (l * l / (2 * e * iz)), 1, 1e-6) << model.name;
    EXPECT_NEAR(c(2, 4) / (-l * l / (2 * e * iy)), 1, 1e-6) << model.name;
    EXPECT_NEAR(c(3, 3) / (l / (g * torsion_constant(a, b))), 1, 1e-3) << model.name;
    // Shear is 0.4 % of these, and its coefficient is within 4 % of 5/6.
    const double shear = l / (5.0 / 6 * g * a * b);
    EXPECT_NEAR(c(1, 1) / (l * l * l / (3 * e * iz) + shear), 1, 2e-4) << model.name;
    EXPECT_NEAR(c(2, 2) / (l * l * l / (3 * e * iy) + shear), 1, 2e-4) << model.name;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        if (i != j && i + j != 6) {
          EXPECT_LT(std::abs(c(i, j)), 1e-4 * std::sqrt(c(i, i) * c(j, j))) << i << j;
        }
  }
}

// Castigliano's theorem for a thin quarter of a ring, clamped at (R, 0), taken at its tip (0, R).
TEST(BeamStudy, QuarterRingFollowsCastigliano) {
  const double r = 0.2, h = 0.01, e = 210e9, g = e / 2.6;
  const double area = h * h, i = std::pow(h, 4) / 12, j = torsion_constant(h, h);
  const double membrane = pi / 4 * r * (1 / (e * area) + 1 / (5.0 / 6 * g * area));
  const BentBar bar({pi / 2 * r, h, h}, 60, 2, around(r));
  const BeamStudy study = bar.study({.beams = 4, .stations = 40});
  EXPECT_NEAR(study.axis.length(), pi / 2 * r, 2e-3 * r);
  const Matrix6& c = study.models.back().compliance.matrix();
  EXPECT_NEAR(c(0, 0) / (r * r * r / (e * i) * (3 * pi / 4 - 2) + membrane), 1, 5e-3);
  EXPECT_NEAR(c(1, 1) / (r * r * r / (e * i) * pi / 4 + membrane), 1, 5e-3);
  EXPECT_NEAR(c(0, 1) / (r * r * r / (2 * e * i)), 1, 5e-3);
  EXPECT_NEAR(c(5, 5) / (pi / 2 * r / (e * i)), 1, 5e-3);
  EXPECT_NEAR(c(2, 2) / (r * r * r * (pi / 4 / (e * i) + (3 * pi / 4 - 2) / (g * j)) +
                         pi / 2 * r / (5.0 / 6 * g * area)),
              1, 5e-3);
  // One straight beam from end to end is far off.
  EXPECT_GT(std::abs(study.models.front().compliance.matrix()(1, 1) / c(1, 1) - 1), 0.1);
}

// The planes across one leg cut the other leg as well; it is not part of the section.
TEST(BeamStudy, HairpinKeepsItsLegsApart) {
  const double leg = 0.1, r = 0.02, h = 0.008;
  const auto hairpin = [&](const Vector3& p) -> Vector3 {
    if (p.x() < leg) return {p.x(), -r + p.y(), p.z()};
    if (p.x() > leg + pi * r) return {2 * leg + pi * r - p.x(), r - p.y(), p.z()};
    const double angle = (p.x() - leg) / r;
    return {leg + (r - p.y()) * std::sin(angle), -(r - p.y()) * std::cos(angle), p.z()};
  };
  const BentBar bar({2 * leg + pi * r, h, h}, 80, 2, hairpin);
  const BeamStudy study = bar.study();
  EXPECT_NEAR(study.axis.length(), 2 * leg + pi * r, 0.02 * leg);
  for (const BeamStation& station : study.stations) {
    EXPECT_EQ(station.properties.pieces, 1);
    EXPECT_NEAR(station.properties.area / (h * h), 1, 0.02);
  }
}

TEST(BeamStudy, ForceThroughTheShearCentreDoesNotTwist) {
  // A channel open towards y, shear centre behind its web.
  const double b = 0.05, t = 0.002, f = 0.05;
  const SectionProperties s = analyse({{{{{-t / 2, -f - t / 2},
                                          {b, -f - t / 2},
                                          {b, -f + t / 2},
                                          {t / 2, -f + t / 2},
                                          {t / 2, f - t / 2},
                                          {b, f - t / 2},
                                          {b, f + t / 2},
                                          {-t / 2, f + t / 2}}}}},
                                      0.3);
  const Matrix6 local = compliance_per_length(s, steel);
  Vector6 wrench = Vector6::Zero();
  wrench[2] = 1;                                  // Fz at the centroid ...
  wrench[3] = (s.shear_centre - s.centroid).x();  // ... moved to the shear centre
  EXPECT_NEAR((local * wrench)[3], 0, 1e-9 * local(3, 2));
  EXPECT_GT(std::abs(local(3, 2)), 0.01 * local(3, 3) * b);
}

TEST(BeamStudy, ComparisonNamesTheWorstSignificantEntry) {
  Matrix6 fea = Matrix6::Identity();
  fea(1, 5) = fea(5, 1) = 0.5;
  fea(0, 3) = fea(3, 0) = 0.01;  // not significant
  Matrix6 beam = fea;
  beam(2, 2) = 1.3;
  beam(1, 5) = beam(5, 1) = 0.45;
  beam(0, 3) = beam(3, 0) = 0.03;
  const BeamModel model{"4 beams", {}, spatial::Compliance6(beam)};
  const BeamComparison c = compare(model, spatial::Compliance6(fea));
  EXPECT_NEAR(c.worst, 0.3, 1e-12);
  EXPECT_EQ(c.worst_row, 2);
  EXPECT_NEAR(c.errors(1, 5), -0.1, 1e-12);
  EXPECT_NEAR(c.errors(0, 3), 0.02, 1e-12);
  EXPECT_FALSE(c.significant(0, 3));
  EXPECT_NEAR(c.largest_ratio, 1.3, 1e-12);
  EXPECT_EQ(verdict({c}, 0.1),
            "No beam model is within 10 % of FEA: 4 beams differ by up to 30 % (z under Fz); use "
            "the FEA result.");
  EXPECT_EQ(verdict({c}, 0.5),
            "4 beams are enough for 50 %: they are within 30 % of FEA in every significant entry.");
}

}  // namespace
}  // namespace kinetostat::fea::beam_study_test

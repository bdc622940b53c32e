// Closed forms of beam theory against the finite-element solution on the section.
#include "kinetostat/fea/section/section.h"

#include <cmath>

#include <gtest/gtest.h>

namespace kinetostat::fea::section_test {
namespace {

constexpr double pi = 3.14159265358979323846;

Loop polygon(int sides, double a, double b, const Vector2& centre = Vector2::Zero()) {
  Loop loop;
  for (int i = 0; i < sides; ++i)
    loop.emplace_back(centre.x() + a * std::cos(2 * pi * i / sides),
                      centre.y() + b * std::sin(2 * pi * i / sides));
  return loop;
}

Loop rectangle(double y0, double z0, double y1, double z1) {
  return {{y0, z0}, {y1, z0}, {y1, z1}, {y0, z1}};
}

Loop reversed(const Loop& loop) { return {loop.rbegin(), loop.rend()}; }

SectionProperties analyse_one(std::vector<Loop> loops, double poisson = 0.3) {
  return analyse({{std::move(loops)}}, poisson);
}

// Saint-Venant's series for a > b, the whole sides.
double rectangle_torsion(double a, double b) {
  double sum = 0;
  for (int n = 1; n < 100; n += 2) sum += std::tanh(n * pi * a / (2 * b)) / std::pow(n, 5);
  return a * b * b * b / 3 * (1 - 192 * b / (std::pow(pi, 5) * a) * sum);
}

// 1 / (kappa A) of a rectangle with half sides a along the force and b across: 6 / 5A of the
// parabola, and the energy of the stress function chi with Laplacian chi = nu / (1 + nu) z / I that
// vanishes on the outline (Timoshenko and Goodier, article 124), by its Fourier series.
double rectangle_shear(double a, double b, double nu) {
  const double second_moment = 4 * a * a * a * b / 3, c = nu / (1 + nu) / second_moment;
  double energy = 0;
  for (int n = 1; n < 2000; ++n) {
    const double k = n * pi / b, coefficient = 2 / k;
    energy += coefficient * coefficient / (k * k) * b * (2 * a - 2 / k * std::tanh(k * a));
  }
  return 6 / (5 * 4 * a * b) + c * c * energy;
}

TEST(Section, RectangleHasItsMomentsAndSaintVenantsTorsion) {
  for (const double ratio : {1.0, 2.0, 5.0, 20.0}) {
    const double a = 0.02 * ratio, b = 0.02;
    const SectionProperties s = analyse_one({rectangle(0.1, 0.3, 0.1 + a, 0.3 + b)});
    EXPECT_NEAR(s.area / (a * b), 1, 1e-6);
    EXPECT_LT((s.centroid - Vector2(0.1 + a / 2, 0.3 + b / 2)).norm(), 1e-8);
    EXPECT_NEAR(s.second_moment(0, 0) / (b * a * a * a / 12), 1, 1e-6);
    EXPECT_NEAR(s.second_moment(1, 1) / (a * b * b * b / 12), 1, 1e-6);
    EXPECT_NEAR(s.torsion_constant / rectangle_torsion(a, b), 1, 5e-4) << ratio;
    EXPECT_GT(s.torsion_constant, rectangle_torsion(a, b) * (1 - 1e-6)) << ratio;
    EXPECT_LT((s.shear_centre - s.centroid).norm(), 1e-4 * a);
  }
}

TEST(Section, RectangleHasFiveSixthsWithoutPoissonAndTheSeriesWithIt) {
  for (const double nu : {0.0, 0.3, 0.45})
    for (const double ratio : {0.25, 1.0, 4.0}) {
      const double a = 0.5 * ratio, b = 0.5;
      const SectionProperties s = analyse_one({rectangle(-a, -b, a, b)}, nu);
      EXPECT_NEAR(s.shear_compliance(0, 0) / rectangle_shear(a, b, nu), 1, 1e-3) << nu << ratio;
      EXPECT_NEAR(s.shear_compliance(1, 1) / rectangle_shear(b, a, nu), 1, 1e-3) << nu << ratio;
      if (nu == 0) {
        EXPECT_NEAR(s.principal().shear_coefficients[0], 5.0 / 6, 1e-3);
        EXPECT_NEAR(s.principal().shear_coefficients[1], 5.0 / 6, 1e-3);
      }
    }
}

// 6 (1 + nu)^2 / (7 + 14 nu + 8 nu^2), of equal energy (Renton 1991).
TEST(Section, CircleHasPolarTorsionAndRentonsShearCoefficient) {
  for (const double nu : {0.0, 0.3, 0.5}) {
    const SectionProperties s = analyse_one({polygon(240, 0.01, 0.01)}, nu);
    EXPECT_NEAR(s.torsion_constant / (pi / 2 * 1e-8), 1, 1e-3);
    EXPECT_NEAR(s.principal().shear_coefficients[0],
                6 * (1 + nu) * (1 + nu) / (7 + 14 * nu + 8 * nu * nu), 1e-3);
  }
}

TEST(Section, EllipseAndTriangleTwistAsInTheTextbook) {
  const double a = 0.03, b = 0.01;
  const SectionProperties ellipse = analyse_one({polygon(400, a, b)});
  EXPECT_NEAR(ellipse.torsion_constant / (pi * a * a * a * b * b * b / (a * a + b * b)), 1, 2e-3);
  const double side = 0.02;
  const SectionProperties triangle =
      analyse_one({{{0, 0}, {side, 0}, {side / 2, side * std::sqrt(3) / 2}}});
  EXPECT_NEAR(triangle.torsion_constant / (std::sqrt(3) / 80 * std::pow(side, 4)), 1, 5e-4);
}

// A thick tube is exact in J; Bredt's formula for thin walls, and half the area in shear.
TEST(Section, TubesTwistAroundTheirHole) {
  const SectionProperties thick =
      analyse_one({polygon(360, 0.02, 0.02), reversed(polygon(360, 0.01, 0.01))});
  EXPECT_NEAR(thick.torsion_constant / (pi / 2 * (1.6e-7 - 1e-8)), 1, 1e-3);
  EXPECT_EQ(thick.holes, 1);
  const SectionProperties thin =
      analyse_one({polygon(720, 1.005, 1.005), reversed(polygon(720, 0.995, 0.995))});
  EXPECT_NEAR(thin.torsion_constant / (2 * pi * 0.01), 1, 2e-3);
  EXPECT_NEAR(thin.principal().shear_coefficients[0], 0.5, 2e-3);
}

TEST(Section, SquareBoxFollowsBredtAndSlitOpenItDoesNot) {
  const double middle = 1, wall = 0.02, out = (middle + wall) / 2, in = (middle - wall) / 2;
  const SectionProperties closed =
      analyse_one({rectangle(-out, -out, out, out), reversed(rectangle(-in, -in, in, in))});
  // Bredt: 4 Am^2 t / perimeter, to the first order of the wall.
  EXPECT_NEAR(closed.torsion_constant / (middle * middle * middle * wall), 1, wall / middle);
  const double gap = 1e-3;
  const SectionProperties open = analyse_one({{{-out, -out},
                                               {out, -out},
                                               {out, -gap},
                                               {in, -gap},
                                               {in, -in},
                                               {-in, -in},
                                               {-in, in},
                                               {in, in},
                                               {in, gap},
                                               {out, gap},
                                               {out, out},
                                               {-out, out}}});
  EXPECT_NEAR(open.torsion_constant / (4 * middle * wall * wall * wall / 3), 1, 0.03);
  EXPECT_LT(open.torsion_constant, 2e-3 * closed.torsion_constant);
}

// A channel's shear centre lies e = 3 b^2 / (h + 6 b) behind the middle of its web (thin walls).
TEST(Section, ChannelHasItsShearCentreBehindTheWeb) {
  const double b = 0.5, h = 1, t = 0.01;  // flanges, web, wall: along the middle lines
  const SectionProperties s = analyse_one({{{-t / 2, -h / 2 - t / 2},
                                            {b, -h / 2 - t / 2},
                                            {b, -h / 2 + t / 2},
                                            {t / 2, -h / 2 + t / 2},
                                            {t / 2, h / 2 - t / 2},
                                            {b, h / 2 - t / 2},
                                            {b, h / 2 + t / 2},
                                            {-t / 2, h / 2 + t / 2}}});
  EXPECT_NEAR(s.shear_centre.x(), -3 * b * b / (h + 6 * b), 0.01 * b);
  EXPECT_NEAR(s.shear_centre.y(), 0, 1e-4);
}

// An I-beam carries the force along its web by the web alone, nearly.
TEST(Section, IBeamShearsInItsWeb) {
  const double b = 0.1, h = 0.2, t = 0.002;
  const double w = t / 2, f = h / 2 - t / 2, g = h / 2 + t / 2;
  const SectionProperties s = analyse_one({{{-b / 2, -g},
                                            {b / 2, -g},
                                            {b / 2, -f},
                                            {w, -f},
                                            {w, f},
                                            {b / 2, f},
                                            {b / 2, g},
                                            {-b / 2, g},
                                            {-b / 2, f},
                                            {-w, f},
                                            {-w, -f},
                                            {-b / 2, -f}}});
  EXPECT_NEAR(1 / (s.shear_compliance(1, 1) * h * t), 1, 0.06);
  EXPECT_NEAR(s.torsion_constant / ((2 * b + h) * t * t * t / 3), 1, 0.05);
}

TEST(Section, PropertiesDoNotDependOnTheAxes) {
  const Loop shape{{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 2.5}, {0, 2}};
  const Eigen::Rotation2Dd turn(0.7);
  const Vector2 shift(4, -9);
  Loop moved;
  for (const Vector2& p : shape) moved.emplace_back(turn * p + shift);
  const SectionProperties a = analyse_one({shape}), b = analyse_one({moved});
  EXPECT_NEAR(b.torsion_constant / a.torsion_constant, 1, 1e-3);
  EXPECT_LT((b.centroid - (turn * a.centroid + shift)).norm(), 1e-6);
  EXPECT_LT((b.shear_centre - (turn * a.shear_centre + shift)).norm(), 1e-3);
  const Matrix2 r = turn.toRotationMatrix();
  EXPECT_LT((b.second_moment - r * a.second_moment * r.transpose()).norm(),
            1e-5 * a.second_moment.norm());
  EXPECT_LT((b.shear_compliance - r * a.shear_compliance * r.transpose()).norm(),
            1e-3 * a.shear_compliance.norm());
}

TEST(Section, TwoPiecesBendTogetherAndTwistAlone) {
  const SectionProperties one = analyse_one({rectangle(-1, -1, 1, 1)});
  const SectionProperties two =
      analyse({{{rectangle(-1, 4, 1, 6)}}, {{rectangle(-1, -6, 1, -4)}}}, 0.3);
  EXPECT_EQ(two.pieces, 2);
  EXPECT_NEAR(two.torsion_constant, 2 * one.torsion_constant, 1e-2);
  EXPECT_NEAR(two.second_moment(1, 1), 2 * (one.second_moment(1, 1) + 4 * 25), 1e-4);
  EXPECT_NEAR(two.shear_compliance(0, 0), one.shear_compliance(0, 0) / 2, 1e-3);
  EXPECT_LT(two.shear_centre.norm(), 1e-3);
}

TEST(Section, OutlineThatCrossesItselfIsRefused) {
  EXPECT_THROW(analyse_one({{{0, 0}, {2, 1}, {2, 0}, {0, 0.9}}}), SectionError);
  EXPECT_THROW(analyse({}, 0.3), SectionError);
}

}  // namespace
}  // namespace kinetostat::fea::section_test

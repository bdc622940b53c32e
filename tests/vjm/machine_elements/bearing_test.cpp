#include "kinetostat/vjm/machine_elements/bearing.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

namespace kinetostat::vjm::bearing_test {
namespace {

using spatial::Matrix6;
using spatial::Vector3;
using spatial::Vector6;

constexpr double pi = std::numbers::pi;

// Forces on the inner rings by a sum over balls that is written down anew, exact in the position of
// the centres of curvature: those of the inner ring move with it, those of the outer one stand.
Vector6 forces(const std::vector<PreloadedRow>& rows, const Vector6& motion) {
  Vector6 sum = Vector6::Zero();
  for (const auto& [row, approach] : rows)
    for (int i = 0; i < row.count; ++i) {
      const double phi = 2 * pi * i / row.count, c = std::cos(row.contact_angle),
                   s = std::sin(row.contact_angle);
      const Vector3 radial(std::cos(phi), std::sin(phi), 0), axial = Vector3::UnitZ();
      const Vector3 place = row.radius * radial + row.position * axial;
      const Vector3 moved = motion.head<3>() + Vector3(motion.tail<3>()).cross(place);
      const bool is_radial = row.contact_angle == 0;
      const double r = row.centres_apart * c + moved.dot(radial) + (is_radial ? approach : 0),
                   z = row.centres_apart * s + moved.dot(axial) + (is_radial ? 0 : approach);
      const double deflection = std::hypot(r, z) - row.centres_apart;
      if (deflection <= 0) continue;
      const Vector3 force = row.constant * std::pow(deflection, row.power) *
                            (r * radial + z * axial) / std::hypot(r, z);
      sum.head<3>() += force;
      sum.tail<3>() += place.cross(force);
    }
  return sum;
}

std::vector<PreloadedRow> pair(double sign, double spacing, double preload) {
  std::vector<PreloadedRow> rows;
  for (const double side : {1., -1.}) {
    const BearingRow row =
        ball_row(16, 9e-3, 60e-3, sign * side * 25 * pi / 180, 0.52, 0.53, side * spacing / 2);
    rows.push_back({row, axial_approach(row, std::copysign(preload, row.contact_angle))});
  }
  return rows;
}

TEST(Bearing, StiffnessIsTheDerivativeOfItsForces) {
  const std::vector<PreloadedRow> one{
      {ball_row(12, 10e-3, 50e-3, 0.4), axial_approach(ball_row(12, 10e-3, 50e-3, 0.4), 700)}};
  const std::vector<PreloadedRow> deep{{ball_row(9, 10e-3, 50e-3, 0), 4e-6}};
  for (const auto& rows : {one, deep, pair(1, 40e-3, 500), pair(-1, 40e-3, 500)}) {
    const Matrix6 stiffness = bearing_stiffness(rows);
    for (Eigen::Index k = 0; k < 6; ++k) {
      const double h = k < 3 ? 1e-10 : 1e-9;
      const Vector6 step = h * Vector6::Unit(k);
      const Vector6 slope = (forces(rows, step) - forces(rows, -step)) / (2 * h);
      EXPECT_LT((stiffness.col(k) - slope).norm(), 1e-5 * slope.norm() + 1e-3) << k;
    }
    EXPECT_TRUE(stiffness.row(5).isZero(0));
    EXPECT_EQ(stiffness, stiffness.transpose());
  }
}

TEST(Bearing, PreloadIsTheSumOfAllAxialForces) {
  for (const double sign : {1., -1.}) {
    const BearingRow row = ball_row(14, 8e-3, 50e-3, sign * 0.3);
    const double approach = axial_approach(row, sign * 400);
    EXPECT_NEAR(forces({{row, approach}}, Vector6::Zero())[2], sign * 400, 1e-7);
    EXPECT_NEAR(axial_force(row, approach), sign * 400, 1e-7);
    EXPECT_THROW(axial_approach(row, -sign), std::invalid_argument);
  }
  EXPECT_THROW(axial_approach(ball_row(14, 8e-3, 50e-3, 0), 1), std::invalid_argument);
}

// Example 7.5 of Harris and Kotzalas: the 218 bearing, 16 balls of 22.23 mm at 40 deg, grooves of
// which the centres are 1.031 mm apart, bears 17,800 N with 0.0386 mm; Jones' axial constant 896.7
// N/mm^2 there stands for 896.7 D^2 / A^1.5.
TEST(Bearing, YieldsAsThatOfTheBook) {
  BearingRow row = ball_row(16, 22.23e-3, 125.26e-3, 40 * pi / 180, 0.5232, 0.5232);
  EXPECT_NEAR(row.centres_apart, 1.031e-3, 1e-6);
  row.constant = 896.7e6 * std::pow(22.23e-3, 2) / std::pow(row.centres_apart, 1.5);
  EXPECT_NEAR(axial_approach(row, 17'800), 0.0386e-3, 5e-7);  // by an angle to 0.1 deg
  // Its own constant, by the elliptic integrals, is within a tenth of what Jones' chart gives.
  EXPECT_NEAR(ball_row(16, 22.23e-3, 125.26e-3, 40 * pi / 180, 0.5232, 0.5232).constant,
              row.constant, 0.12 * row.constant);
}

// Of equal elements with normals that do not turn: axial Z k sin^2, radial Z k cos^2 / 2, tilt
// axial R^2 / 2 about the row's own middle.
TEST(Bearing, OfRollersIsTheSumOfTheirSprings) {
  const double angle = 20 * pi / 180, radius = 40e-3;
  const int count = 24;
  BearingRow row = roller_row(count, 12e-3, 2 * radius, angle);
  const double along = axial_approach(row, 3000), deflection = along * std::sin(angle);
  const double each = 10. / 9 * row.constant * std::pow(deflection, 1. / 9);
  const Matrix6 stiffness = bearing_stiffness({{row, along}});
  const double axial = count * each * std::pow(std::sin(angle), 2),
               radial = count * each * std::pow(std::cos(angle), 2) / 2;
  EXPECT_NEAR(stiffness(2, 2), axial, 1e-9 * axial);
  EXPECT_NEAR(stiffness(0, 0), radial, 1e-9 * radial);
  EXPECT_NEAR(stiffness(1, 1), radial, 1e-9 * radial);
  row.length = 1e-12;
  EXPECT_NEAR(bearing_stiffness({{row, along}})(3, 3), axial * radius * radius / 2,
              1e-9 * axial * radius * radius);
  // A cylindrical roller bearing resists a tilt by the length of its rollers: Z k L^2 / 24.
  const BearingRow cylindrical = roller_row(count, 12e-3, 2 * radius, 0);
  const double approach = 3e-6,
               spring = 10. / 9 * cylindrical.constant * std::pow(approach, 1. / 9);
  const Matrix6 of_cylindrical = bearing_stiffness({{cylindrical, approach}});
  const double tilt = count * spring * 12e-3 * 12e-3 / 24;
  EXPECT_NEAR(of_cylindrical(3, 3), tilt, 2e-3 * tilt);  // of 31 slices
  EXPECT_NEAR(of_cylindrical(2, 2), 0, 1e-6 * of_cylindrical(0, 0));
}

// Back to back resists a tilt more than face to face; radially both are the same, and a pair is
// stiffer along its axis than one row with that preload by two.
TEST(Bearing, OfAPairDependsOnHowItStands) {
  const Matrix6 back = bearing_stiffness(pair(-1, 40e-3, 500)),
                face = bearing_stiffness(pair(1, 40e-3, 500));
  EXPECT_GT(back(3, 3), 2 * face(3, 3));
  EXPECT_NEAR(back(0, 0), face(0, 0), 1e-9 * back(0, 0));
  const Matrix6 one = bearing_stiffness({pair(1, 40e-3, 500)[0]});
  EXPECT_NEAR(back(2, 2), 2 * one(2, 2), 1e-9 * back(2, 2));
}

}  // namespace
}  // namespace kinetostat::vjm::bearing_test

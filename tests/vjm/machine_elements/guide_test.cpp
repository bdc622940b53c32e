#include "kinetostat/vjm/machine_elements/guide.h"

#include <gtest/gtest.h>

#include "kinetostat/vjm/machine_elements/ball_screw.h"

namespace kinetostat::vjm::guide_test {
namespace {

// Four carriages at the corners of 2a by 2b: 4 k across, 4 k b^2, 4 k a^2 and 4 k_y a^2 in turns.
TEST(Guide, OfFourCarriagesResistsTurnsByTheirDistances) {
  const double a = 0.2, b = 0.15, lateral = 3e8, normal = 5e8;
  std::vector<Carriage> carriages;
  for (const double x : {-a, a})
    for (const double y : {-b, b})
      carriages.push_back({.lateral = lateral, .normal = normal, .place = {x, y, 0}});
  spatial::Vector6 expected;
  expected << 0, 4 * lateral, 4 * normal, 4 * normal * b * b, 4 * normal * a * a,
      4 * lateral * a * a;
  const spatial::Matrix6 stiffness = guide_stiffness(carriages);
  EXPECT_LT((stiffness - spatial::Matrix6(expected.asDiagonal())).norm(), 1e-6 * normal);
}

// A table above its carriages leans over when it is pushed.
TEST(Guide, HasItsCentreWhereTheCarriagesAre) {
  const Carriage one{
      .lateral = 3e8, .normal = 5e8, .roll = 2e4, .pitch = 1e4, .yaw = 3e4, .place = {0, 0, -0.1}};
  const spatial::Matrix6 stiffness = guide_stiffness({one});
  EXPECT_NEAR(stiffness(3, 3), 2e4 + 3e8 * 0.01, 1);
  EXPECT_NEAR(stiffness(1, 3), 3e8 * 0.1, 1);
  EXPECT_NEAR(stiffness(4, 4), 1e4, 1e-6);  // nothing holds it along the rail
  EXPECT_TRUE(stiffness.row(0).isZero(0));
}

// Shaft, nut and bearing in series; with both ends held the middle is softest, E A / (L/4).
TEST(BallScrew, IsASeriesOfItsParts) {
  const BallScrew one_end{
      .shaft_area = 5e-4, .young_modulus = 2e11, .length = 1, .nut = 4e8, .bearing = 5e8};
  EXPECT_NEAR(1 / axial_stiffness(one_end, 0.5), 1 / 4e8 + 1 / 5e8 + 0.5 / 1e8, 1e-18);
  BallScrew both = one_end;
  both.bearing = both.other_bearing = 1e20;
  both.nut = 1e20;
  EXPECT_NEAR(axial_stiffness(both, 0.5), 4e8, 1);
  for (const double place : {0.1, 0.3, 0.7})
    EXPECT_GT(axial_stiffness(both, place), axial_stiffness(both, 0.5));
  EXPECT_DOUBLE_EQ(axial_stiffness(both, 0.3), axial_stiffness(both, 0.7));
  EXPECT_THROW(axial_stiffness(one_end, 1.1), std::invalid_argument);
}

}  // namespace
}  // namespace kinetostat::vjm::guide_test

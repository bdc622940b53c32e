#include "kinetostat/vjm/machine_elements/rolling_contact.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

namespace kinetostat::vjm::rolling_contact_test {
namespace {

constexpr ContactMaterial steel;
const double reduced_modulus =
    steel.young_modulus / (2 * (1 - steel.poisson_ratio * steel.poisson_ratio));

// Hertz: a sphere of radius R on a plane bears 4/3 E* sqrt(R) delta^(3/2).
TEST(PointContact, OfASphereOnAPlaneIsHertzs) {
  const double radius = 4e-3;
  EXPECT_NEAR(point_contact(2 / radius, 0), 4. / 3 * reduced_modulus * std::sqrt(radius),
              1e-9 * reduced_modulus);
}

// Table 6.1 of Harris and Kotzalas, Rolling Bearing Analysis.
TEST(PointContact, ApproachIsThatOfTheBooks) {
  for (const auto& [difference, approach] :
       {std::pair(0., 1.), std::pair(.1075, .9974), std::pair(.3204, .9761),
        std::pair(.4795, .9429), std::pair(.5916, .9077), std::pair(.6716, .8733),
        std::pair(.7332, .8394), std::pair(.7948, .7961), std::pair(.8350, .7602),
        std::pair(.87366, .7169), std::pair(.90999, .6636), std::pair(.93657, .6112),
        std::pair(.95738, .5551), std::pair(.97290, .4960), std::pair(.983797, .4352)})
    EXPECT_NEAR(dimensionless_approach(difference), approach, 5e-4) << difference;
}

TEST(PointContact, RefusesWhatDoesNotTouch) {
  EXPECT_THROW(point_contact(0, 0), std::invalid_argument);
  EXPECT_THROW(point_contact(100, 1), std::invalid_argument);
  EXPECT_THROW(ball_between_races(10e-3, 50e-3, 0, 0.5, 0.52), std::invalid_argument);
  EXPECT_THROW(ball_between_races(60e-3, 50e-3, 0, 0.52, 0.52), std::invalid_argument);
}

// A closer groove bears more, and between flat plates the ball is Hertz's twice in series.
TEST(BallBetweenRaces, BearsMoreInACloserGroove) {
  const double close = ball_between_races(10e-3, 50e-3, 0.4, 0.515, 0.515),
               wide = ball_between_races(10e-3, 50e-3, 0.4, 0.54, 0.54);
  EXPECT_GT(close, 1.15 * wide);
  const double flat = ball_between_races(10e-3, 1e9, 0, 1e9, 1e9);
  EXPECT_NEAR(flat, point_contact(2 / 5e-3, 0) / std::pow(2, 1.5), 1e-6 * flat);
}

// Palmgren: delta = 7.68e-5 Q^0.9 / L^0.8 in N and mm of both contacts, within a tenth.
TEST(RollerBetweenRaces, IsNearPalmgrens) {
  for (const double length : {5e-3, 20e-3})
    for (const double load : {100., 5000.}) {
      const double approach = std::pow(load / roller_between_races(length), 0.9);
      EXPECT_NEAR(approach * 1e3, 7.68e-5 * std::pow(load, 0.9) / std::pow(length * 1e3, 0.8),
                  0.1 * approach * 1e3);
    }
}

}  // namespace
}  // namespace kinetostat::vjm::rolling_contact_test

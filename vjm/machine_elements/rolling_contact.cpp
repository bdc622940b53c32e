#include "kinetostat/vjm/machine_elements/rolling_contact.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

namespace kinetostat::vjm {
namespace {

using std::numbers::pi;

// Complete elliptic integrals of a contact ellipse whose axes are as kappa to 1.
struct Ellipse {
  double first, second;

  explicit Ellipse(double kappa) {
    const double modulus = std::sqrt(1 - 1 / (kappa * kappa));
    first = std::comp_ellint_1(modulus);
    second = std::comp_ellint_2(modulus);
  }
  double curvature_difference(double kappa) const {
    const double square = kappa * kappa;
    return ((square + 1) * second - 2 * first) / ((square - 1) * second);
  }
};

// The difference grows with kappa: bisection of its logarithm.
double axes_ratio(double curvature_difference) {
  double lower = 1e-7, upper = 20;  // of log(kappa)
  for (int i = 0; i < 200 && upper - lower > 1e-15 * upper; ++i) {
    const double middle = (lower + upper) / 2, kappa = std::exp(middle);
    (Ellipse(kappa).curvature_difference(kappa) < curvature_difference ? lower : upper) = middle;
  }
  return std::exp(lower);
}

struct Curvatures {
  double sum, difference;
};

// Of a ball on a groove of a ring; `along` is that of the ring along the way of the ball, positive
// where it is convex, times the ball's diameter.
Curvatures on_groove(double diameter, double conformity, double along) {
  const double sum = 4 - 1 / conformity + along;
  return {sum / diameter, (1 / conformity + along) / sum};
}

}  // namespace

double dimensionless_approach(double curvature_difference) {
  if (!(curvature_difference >= 0 && curvature_difference < 1))
    throw std::invalid_argument(
        fmt::format("curvatures differ by {}, which is not in [0, 1)", curvature_difference));
  if (curvature_difference < 1e-6) return 1;
  const double kappa = axes_ratio(curvature_difference);
  const Ellipse ellipse(kappa);
  return 2 * ellipse.first / pi * std::cbrt(pi / (2 * kappa * kappa * ellipse.second));
}

double point_contact(double curvature_sum, double curvature_difference,
                     const ContactMaterial& material) {
  if (!(curvature_sum > 0))
    throw std::invalid_argument("two bodies with such curvatures touch at no point");
  const double yield =
      2 * (1 - material.poisson_ratio * material.poisson_ratio) / material.young_modulus;
  return std::pow(2 / (dimensionless_approach(curvature_difference) * curvature_sum), 1.5) * 2 *
         curvature_sum / (3 * yield);
}

double ball_between_races(double ball_diameter, double pitch_diameter, double contact_angle,
                          double inner_conformity, double outer_conformity,
                          const ContactMaterial& material) {
  if (!(inner_conformity > 0.5 && outer_conformity > 0.5))
    throw std::invalid_argument("the radius of a groove is more than half the ball's diameter");
  const double gamma = ball_diameter * std::cos(contact_angle) / pitch_diameter;
  if (!(gamma < 1)) throw std::invalid_argument("the balls are larger than the bearing");
  const Curvatures inner = on_groove(ball_diameter, inner_conformity, 2 * gamma / (1 - gamma)),
                   outer = on_groove(ball_diameter, outer_conformity, -2 * gamma / (1 + gamma));
  const auto soft = [&](const Curvatures& at) {
    return std::pow(point_contact(at.sum, at.difference, material), -2.0 / 3);
  };
  return std::pow(soft(inner) + soft(outer), -1.5);
}

double roller_between_races(double length) {
  constexpr double of_steel = 35'948e6;  // mm to m: to the power of 8/9 and of 10/9
  return of_steel * std::pow(length, 8.0 / 9);
}

}  // namespace kinetostat::vjm

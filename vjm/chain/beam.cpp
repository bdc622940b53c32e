#include "kinetostat/vjm/chain/beam.h"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace kinetostat::vjm {
namespace {

constexpr double pi = 3.14159265358979323846;

void require_positive(double value, const char* name) {
  if (!(value > 0) || !std::isfinite(value))
    throw std::invalid_argument(std::string(name) + " must be positive");
}

double shear_compliance(double length, const Section& s, const Material& m,
                        const std::optional<double>& coefficient, BeamTheory theory) {
  if (theory == BeamTheory::euler_bernoulli) return 0;
  if (!coefficient)
    throw std::invalid_argument("Timoshenko theory needs the shear coefficients of the section");
  return length / (*coefficient * m.shear_modulus * s.area);
}

}  // namespace

Section Section::rectangle(double y, double z, double poisson_ratio) {
  const double nu = poisson_ratio, kappa = 10 * (1 + nu) / (12 + 11 * nu);
  const auto [b, a] = std::minmax(y, z);
  const double ratio = b / a;
  return {
      .area = y * z,
      .second_moment_y = y * z * z * z / 12,
      .second_moment_z = z * y * y * y / 12,
      .torsion_constant = a * b * b * b * (1.0 / 3 - 0.21 * ratio * (1 - std::pow(ratio, 4) / 12)),
      .shear_coefficient_y = kappa,
      .shear_coefficient_z = kappa};
}

Section Section::circle(double diameter, double poisson_ratio) {
  const double nu = poisson_ratio, kappa = 6 * (1 + nu) / (7 + 6 * nu);
  const double i = pi * std::pow(diameter, 4) / 64;
  return {.area = pi * diameter * diameter / 4,
          .second_moment_y = i,
          .second_moment_z = i,
          .torsion_constant = 2 * i,
          .shear_coefficient_y = kappa,
          .shear_coefficient_z = kappa};
}

Section Section::tube(double outer_diameter, double inner_diameter, double poisson_ratio) {
  if (!(inner_diameter < outer_diameter))
    throw std::invalid_argument("the inner diameter of a tube must be below the outer one");
  const double i = pi * (std::pow(outer_diameter, 4) - std::pow(inner_diameter, 4)) / 64;
  const double nu = poisson_ratio, m = inner_diameter / outer_diameter;
  const double wide = (1 + m * m) * (1 + m * m);
  const double kappa = 6 * (1 + nu) * wide / ((7 + 6 * nu) * wide + (20 + 12 * nu) * m * m);
  return {.area = pi * (outer_diameter * outer_diameter - inner_diameter * inner_diameter) / 4,
          .second_moment_y = i,
          .second_moment_z = i,
          .torsion_constant = 2 * i,
          .shear_coefficient_y = kappa,
          .shear_coefficient_z = kappa};
}

spatial::Compliance6 beam_compliance(double length, const Section& s, const Material& m,
                                     BeamTheory theory) {
  require_positive(length, "the length of a beam");
  require_positive(m.young_modulus, "Young's modulus");
  require_positive(m.shear_modulus, "the shear modulus");
  require_positive(s.area, "the area of the section");
  require_positive(s.second_moment_y, "the second moment Iy of the section");
  require_positive(s.second_moment_z, "the second moment Iz of the section");
  require_positive(s.torsion_constant, "the torsion constant of the section");

  const double l = length, l2 = l * l, l3 = l2 * l;
  const double ei_y = m.young_modulus * s.second_moment_y;
  const double ei_z = m.young_modulus * s.second_moment_z;
  spatial::Matrix6 c = spatial::Matrix6::Zero();
  c(0, 0) = l / (m.young_modulus * s.area);
  c(1, 1) = l3 / (3 * ei_z) + shear_compliance(l, s, m, s.shear_coefficient_y, theory);
  c(2, 2) = l3 / (3 * ei_y) + shear_compliance(l, s, m, s.shear_coefficient_z, theory);
  c(3, 3) = l / (m.shear_modulus * s.torsion_constant);
  c(4, 4) = l / ei_y;
  c(5, 5) = l / ei_z;
  c(1, 5) = c(5, 1) = l2 / (2 * ei_z);
  c(2, 4) = c(4, 2) = -l2 / (2 * ei_y);
  return spatial::Compliance6(c, {.point = {length, 0, 0}, .axes = spatial::Matrix3::Identity()});
}

}  // namespace kinetostat::vjm

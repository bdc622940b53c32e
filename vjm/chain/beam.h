// A link as a beam: section and material to the compliance at its tip.
#pragma once

#include <optional>

#include "kinetostat/spatial/stiffness.h"

namespace kinetostat::vjm {

/// Linear elastic, isotropic.
struct Material {
  double young_modulus = 0;       // E [Pa]
  double shear_modulus = 0;       // G [Pa]
  std::optional<double> density;  // [kg/m^3]

  /// nu = E / (2 G) - 1.
  double poisson_ratio() const { return young_modulus / (2 * shear_modulus) - 1; }
};

/// A cross-section in its own axes: x along the beam, y and z through the centroid along the
/// principal axes.
struct Section {
  double area = 0;              // A [m^2]
  double second_moment_y = 0;   // Iy = integral of z^2 dA [m^4]: bending in the x-z plane
  double second_moment_z = 0;   // Iz = integral of y^2 dA [m^4]: bending in the x-y plane
  double torsion_constant = 0;  // J [m^4]
  /// Timoshenko shear coefficients for forces along y and z; without them the section can only be
  /// used with Euler-Bernoulli theory.
  std::optional<double> shear_coefficient_y, shear_coefficient_z;

  /// The shear coefficients of the following are Cowper's (1966), for Poisson's ratio nu > -1.
  ///
  /// Sides along y and z [m]. J = a b^3 (1/3 - 0.21 (b/a) (1 - b^4/(12 a^4))), a > b (Roark),
  /// within 0.5 % of the exact series. Shear coefficients 10 (1 + nu) / (12 + 11 nu).
  static Section rectangle(double y, double z, double poisson_ratio);
  /// Solid circle [m]; shear coefficients 6 (1 + nu) / (7 + 6 nu).
  static Section circle(double diameter, double poisson_ratio);
  /// Circular tube [m]; with m = inner over outer diameter, shear coefficients
  /// 6 (1 + nu) (1 + m^2)^2 / ((7 + 6 nu) (1 + m^2)^2 + (20 + 12 nu) m^2).
  static Section tube(double outer_diameter, double inner_diameter, double poisson_ratio);
};

enum class BeamTheory { euler_bernoulli, timoshenko };

/// Compliance at the tip of a cantilever along +x, clamped at its root, taken at the tip centroid
/// in the axes of the section (JAMRIS09 section 4.2; reference point and axes in the returned
/// frame). Throws std::invalid_argument when a length, modulus or section property is not positive,
/// or when Timoshenko theory is asked of a section without shear coefficients.
spatial::Compliance6 beam_compliance(double length, const Section& section,
                                     const Material& material, BeamTheory theory);

}  // namespace kinetostat::vjm

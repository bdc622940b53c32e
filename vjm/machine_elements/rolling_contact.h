// What a ball or a roller between two races yields.
#pragma once

namespace kinetostat::vjm {

/// Young's modulus [Pa] and Poisson's ratio of the bodies in contact: bearing steel.
struct ContactMaterial {
  double young_modulus = 206e9;
  double poisson_ratio = 0.3;
};

/// The load Q = K delta^(3/2) of an approach delta of two bodies that touch at a point: K
/// [N/m^1.5], from the sum of their principal curvatures, Sigma [1/m], and how much these differ,
/// F in [0, 1) (0: a circle of contact, 1: a line):
///
///   K = (2 / (delta* Sigma))^(3/2) 2 Sigma / (3 C),   C = 2 (1 - nu^2)/E,
///   delta* = (2 K(m)/pi) (pi / (2 kappa^2 E(m)))^(1/3),   m = 1 - 1/kappa^2,
///   F = ((kappa^2 + 1) E(m) - 2 K(m)) / ((kappa^2 - 1) E(m)),
///
/// K(m) and E(m) the complete elliptic integrals, kappa the ratio of the axes of the contact
/// ellipse. Hertz 1881; Harris and Kotzalas, Rolling Bearing Analysis, 5th ed., chapter 6. Throws
/// std::invalid_argument for a sum that is not positive or a difference out of its range.
double point_contact(double curvature_sum, double curvature_difference,
                     const ContactMaterial& material = {});

/// delta* of such a contact: 1 for a circle.
double dimensionless_approach(double curvature_difference);

/// A ball between two races, series of two such contacts: K of the approach of both races.
/// Diameters [m], contact angle [rad], conformities: radius of a groove over the diameter of the
/// ball, above 0.5. Curvatures as in Harris and Kotzalas, chapter 2.
double ball_between_races(double ball_diameter, double pitch_diameter, double contact_angle,
                          double inner_conformity, double outer_conformity,
                          const ContactMaterial& material = {});

/// A steel roller between two races: Q = K delta^(10/9), K [N/m^(10/9)] from its effective length
/// [m]; ISO/TS 16281: 35 948 L^(8/9) in N and mm.
double roller_between_races(double length);

}  // namespace kinetostat::vjm

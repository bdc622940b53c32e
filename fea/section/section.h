// Elastic properties of a cross-section of any shape.
#pragma once

#include "kinetostat/fea/section/section_mesh.h"

namespace kinetostat::fea {

/// Properties of a section in its plane y-z; all vectors and tensors in those axes.
///
/// Torsion and shear are Saint-Venant's problems for the warping function and for the two shear
/// functions, solved with quadratic triangles (Pilkey, Analysis and Design of Elastic Beams, 2002,
/// chapters 5 and 6). Both come out as a stiffness that is too large by the error of the mesh.
struct SectionProperties {
  double area = 0;                          // [m^2]
  Vector2 centroid = Vector2::Zero();       // [m]
  Matrix2 second_moment = Matrix2::Zero();  // integral of r r' dA about the centroid [m^4]
  double torsion_constant = 0;              // J [m^4]
  Vector2 shear_centre = Vector2::Zero();   // Trefftz: independent of Poisson's ratio [m]
  /// Shear strain of the section per force through the shear centre, times G [1/m^2]: equal energy.
  Matrix2 shear_compliance = Matrix2::Zero();
  int pieces = 0, holes = 0;
  int triangles = 0;

  /// Principal second moments about the centroid, the larger first, with their axes as columns: the
  /// first moment is the integral of the squared coordinate along the first axis.
  struct Principal {
    Vector2 moments;  // [m^4]
    Matrix2 axes;
    Vector2 shear_coefficients;  // kappa for forces along the axes
  };
  Principal principal() const;
};

/// A section in several pieces is one whose pieces keep a common plane in bending (parallel axes),
/// while torsion and shear pass through them side by side. Throws SectionError.
SectionProperties analyse(const std::vector<SectionPiece>& section, double poisson);

}  // namespace kinetostat::fea

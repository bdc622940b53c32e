// A link as a chain of straight beams.
#pragma once

#include "kinetostat/fea/elasticity/elasticity.h"
#include "kinetostat/fea/section/section.h"
#include "kinetostat/spatial/stiffness.h"

namespace kinetostat::fea {

/// A straight beam of one section.
struct BeamElement {
  spatial::Frame middle;      // point on the beam's axis half way along; x along it
  double length = 0;          // [m]
  SectionProperties section;  // in the y-z plane of `middle`
};

/// Compliance of one metre of the beam under a wrench at the centroid of the section, in the axes
/// of the section: [strain and shears; twist and curvatures] per [force; moment]. Axial force and
/// bending act at the centroid, shear and torsion at the shear centre.
Matrix6 compliance_per_length(const SectionProperties& section, const Material& material);

/// Compliance at `point` [m], mesh axes, of beams clamped to one another: every beam's own
/// compliance is taken to the point as by a rigid arm, J K^-1 J' (JAMRIS09 section 4.2). Exact for
/// Timoshenko's beam.
spatial::Compliance6 chain_compliance(const std::vector<BeamElement>& beams,
                                      const Material& material, const Vector3& point);

}  // namespace kinetostat::fea

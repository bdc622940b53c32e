// Surfaces of bodies that are given by numbers.
#pragma once

#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

/// A closed box of 12 facets between two corners [m].
SurfaceMesh box_surface(const Vector3& low, const Vector3& high);

/// Closed, about z, its middle at the origin, of flat facets that lie as far outside the round
/// surface as inside: a section has the area of the circle. Lengths in [m], above 0.
SurfaceMesh cylinder_surface(double radius, double length);

/// Likewise with a half ball at each end; `length` is that between them, 0 for a ball.
SurfaceMesh capsule_surface(double radius, double length);

}  // namespace kinetostat::fea

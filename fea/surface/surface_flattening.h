// Flat faces of a solid that rounding or welding has left nearly flat.
#pragma once

#include <cstddef>

#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

/// Fits planes to the faces whose corners lie within `tolerance` [m] of one, and moves corners into
/// the planes of all their faces where that takes no more than the tolerance. Faces that meet
/// another at a small angle are parts of a curved surface and stay. Returns how many corners moved.
///
/// A mesher that sees a face as hundreds of facets with almost the same normal makes elements as
/// small as the edges between them.
std::size_t flatten(SurfaceMesh& mesh, double tolerance);

}  // namespace kinetostat::fea

// Facets of a surface that pass through one another.
#pragma once

#include <utility>
#include <vector>

#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

struct SelfIntersections {
  std::vector<std::pair<int, int>> pairs;  // facets, lower number first, ascending
  bool complete = true;                    // false: the search stopped at `limit` pairs
};

/// Pairs of facets with a point in common that is not a common corner or edge: crossing ones,
/// overlapping ones in one plane, and neighbours folded onto one another. Contacts shallower than
/// `tolerance` [m] do not count, and facets thinner than it are passed over.
SelfIntersections self_intersections(const SurfaceMesh& mesh, double tolerance,
                                     std::size_t limit = 10000);

}  // namespace kinetostat::fea

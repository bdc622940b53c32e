// A closed surface without the thin facets that defeat meshers.
#pragma once

#include <optional>
#include <vector>

#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

struct CleanSurface {
  SurfaceMesh mesh;
  std::vector<int> tags;  // of its facets
};

/// Merges corners nearer than `tolerance` [m] and gives facets that are thinner than it to the
/// neighbour across their longest side. No point of the surface moves by more than `tolerance` a
/// step, few steps are taken. None when there is nothing to clean or the result would not be sound.
std::optional<CleanSurface> without_thin_facets(const SurfaceMesh& surface,
                                                const std::vector<int>& tags, double tolerance);

}  // namespace kinetostat::fea

// One solid of a mesh made to be looked at.
#pragma once

#include <optional>
#include <vector>

#include "kinetostat/common/progress.h"
#include "kinetostat/fea/surface/surface_repair.h"

namespace kinetostat::fea {

/// A surface that bounds one solid, and what was done to it for that.
struct OneSolid {
  SurfaceMesh surface;
  std::vector<RepairStep> repairs = {};  // in the order in which they were taken
  std::size_t bodies = 1;                // of which this is the largest
  double share = 1;                      // of their volume
};

/// Meshes for pictures are shells that stick in each other, open where nobody looks. As it is where
/// that bounds one solid, else what `weld`, `orient`, `fill` and `unite` make of it, with `wrap`
/// where these do not do, and last the largest shell alone, so repaired. Of bodies that do not
/// touch the largest. None where nothing bounds a solid. The steps of the options are not looked
/// at. Throws as repair() does.
std::optional<OneSolid> one_solid(const SurfaceMesh& mesh, const RepairOptions& options,
                                  common::Progress& progress);

}  // namespace kinetostat::fea

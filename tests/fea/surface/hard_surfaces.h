// A corpus of 120 surfaces that meshers and repair programs find hard, with fixed seeds: 60 sound
// ones, as decimators and CAD exporters write them, and 60 broken ones.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea::hard {

struct HardSurface {
  std::string family;
  bool is_broken = false;  // sound only after repair
  SurfaceMesh mesh;        // [mm]
  SurfaceMesh clean;       // [mm] the same shape as a careful exporter would write it
  Box fixed, loaded;       // [mm] around the faces at both ends in x
};

inline constexpr int variants = 6;  // of a family, the later ones mostly the harder ones

/// "hollow_shell" ... ; the broken ones after the sound ones.
const std::vector<std::string>& families();

/// Throws std::invalid_argument for another family. 0 <= variant < variants.
HardSurface hard_surface(const std::string& family, int variant);

}  // namespace kinetostat::fea::hard

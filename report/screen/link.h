// First screens of `identify`, `beam` and `mesh check`.
#pragma once

#include <string>

#include "kinetostat/fea/link/identify.h"
#include "kinetostat/report/links/beam.h"
#include "kinetostat/report/links/mesh_check.h"

namespace kinetostat::report {

/// "foot: softest along z, 1.15 um/N; every entry within 1.8 %."
std::string headline(const fea::LinkResult& result);
/// Headline, effect of the clamping assumption, the 6x6 compliance. `next`: the last line.
std::string first_screen(const fea::LinkResult& result, const std::string& next);

/// The verdict, and how far each beam model is off.
std::string first_screen(const BeamResult& result);

/// Whether the mesh bounds a solid.
std::string headline(const fea::SurfaceCheck& check, const MeshCheckUnits& units);

}  // namespace kinetostat::report

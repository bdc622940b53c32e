// The check of a mesh file, for people and for programs.
#pragma once

#include <string>

#include "kinetostat/fea/mesh/mesh_check.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

/// How a check is printed: lengths in `unit`, mass with a density above zero [kg/m^3].
struct MeshCheckUnits {
  std::string unit;
  double length = 1;  // [m] of one unit
  double density = 0;
};

/// What was welded and repaired, the defects with their cures, size, mass and bodies.
std::string text(const fea::SurfaceCheck& check, const fea::RepairOptions& asked,
                 const MeshCheckUnits& units);
/// Size and quality of the elements, mass and groups.
std::string text(const fea::VolumeCheck& check, const MeshCheckUnits& units);

/// In SI units; facets are counted from 1.
io::Json to_json(const fea::SurfaceCheck& check, const fea::RepairOptions& asked, double density);
io::Json to_json(const fea::VolumeCheck& check, double density);

}  // namespace kinetostat::report

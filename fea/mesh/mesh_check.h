// A mesh file looked at before anything is computed with it: repaired on request, checked, weighed.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "kinetostat/common/progress.h"
#include "kinetostat/fea/mesh/surface_import.h"
#include "kinetostat/fea/mesh/volume_mesh.h"
#include "kinetostat/fea/surface/surface_bodies.h"
#include "kinetostat/fea/surface/surface_check.h"
#include "kinetostat/fea/surface/surface_repair.h"

namespace kinetostat::fea {

struct SurfaceCheckOptions {
  std::string unit;       // of the file's lengths
  std::string body = {};  // the one of several that is meant; empty: the whole file
  RepairOptions repair;   // without steps: none
};

struct SurfaceCheck {
  ImportedSurface surface;    // repaired, of the body that was picked
  std::string picked = {};    // name of that body; empty: the whole file
  std::size_t picked_of = 0;  // bodies of the file, when one was picked
  RepairReport repair = {};   // empty when none was asked for
  SurfaceReport report = {};  // of the surface after repair
  MassProperties mass = {};   // of density one; of no meaning unless the surface is sound
  std::vector<Body> bodies = {};
};

/// Throws what read_surface() and repair() throw, and InputError for a body that is not there.
SurfaceCheck check_surface_file(const std::filesystem::path& file,
                                const SurfaceCheckOptions& options, common::Progress& progress);

struct VolumeCheck {
  ImportedVolume volume;
  MeshQuality quality;
  MassProperties mass;
  int pieces = 1;
};

/// A mesh that is not sound is refused when it is read. Throws what read_volume_mesh() throws.
VolumeCheck check_volume_file(const std::filesystem::path& file, const std::string& unit,
                              common::Progress& progress);

}  // namespace kinetostat::fea

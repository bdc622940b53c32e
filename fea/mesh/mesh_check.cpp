#include "kinetostat/fea/mesh/mesh_check.h"

#include <algorithm>

#include <fmt/format.h>

#include "kinetostat/common/error.h"

namespace kinetostat::fea {
namespace {

// Keeps the body of that name alone. Returns how many there were.
std::size_t pick_body(const std::filesystem::path& file, const SurfaceCheckOptions& options,
                      SurfaceMesh& surface) {
  const std::vector<Body> bodies = find_bodies(surface, nested_shells(surface, edge_uses(surface)));
  const auto picked = std::find_if(bodies.begin(), bodies.end(),
                                   [&](const Body& body) { return body.name == options.body; });
  if (picked == bodies.end())
    throw common::InputError(file, fmt::format("there is no body '{}'", options.body),
                             "The bodies are " + list_bodies(bodies, options.unit));
  keep_body(surface, *picked);
  return bodies.size();
}

}  // namespace

SurfaceCheck check_surface_file(const std::filesystem::path& file,
                                const SurfaceCheckOptions& options, common::Progress& progress) {
  progress.report("reading", 0);
  SurfaceCheck check{.surface = read_surface(file, options.unit)};
  SurfaceMesh& mesh = check.surface.mesh;
  check.picked = options.body;
  if (!check.picked.empty()) check.picked_of = pick_body(file, options, mesh);
  if (!options.repair.steps.empty()) check.repair = repair(mesh, options.repair, progress);
  progress.report("checking", 0);
  check.report = check_surface(mesh, check.surface.weld.tolerance);
  check.mass = mass_properties(mesh);
  check.bodies = find_bodies(mesh, check.report.shells);
  return check;
}

VolumeCheck check_volume_file(const std::filesystem::path& file, const std::string& unit,
                              common::Progress& progress) {
  progress.report("reading", 0);
  ImportedVolume volume = read_volume_mesh(file, unit);
  const MeshQuality found = quality(volume.mesh);
  const MassProperties mass = mass_properties(volume.mesh);
  const int pieces = count_pieces(volume.mesh);
  return {.volume = std::move(volume), .quality = found, .mass = mass, .pieces = pieces};
}

}  // namespace kinetostat::fea

#include "kinetostat/fea/link/link_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/spelling.h"
#include "kinetostat/fea/mesh/length_unit.h"
#include "kinetostat/fea/mesh/volume_mesh.h"
#include "kinetostat/fea/surface/surface_bodies.h"
#include "kinetostat/fea/surface/surface_repair.h"

namespace kinetostat::fea {
namespace {

using common::InputError;

// A missing unit is a fault of the link file, though only the mesh shows what it might be.
template <class Read>
auto with_unit(const LinkSpec& spec, Read read) {
  try {
    return read(spec.mesh_file, spec.unit);
  } catch (const MissingUnit& error) {
    InputError::Details details = spec.mesh_origin;
    details.what = error.details().what;
    details.cure =
        fmt::format("Add it, for example 'mesh: {{file: {}, unit: mm}}'", spec.mesh_name);
    throw InputError(details);
  }
}

void pick_body(const LinkSpec& spec, SurfaceMesh& surface) {
  if (spec.body.empty()) return;
  const std::vector<Body> bodies = find_bodies(surface, nested_shells(surface, edge_uses(surface)));
  const auto picked = std::find_if(bodies.begin(), bodies.end(),
                                   [&](const Body& body) { return body.name == spec.body; });
  if (picked != bodies.end()) return keep_body(surface, *picked);
  // A body that touches another has no shell of its own, but its name.
  for (const FacetGroup& group : surface.groups)
    if (group.name == spec.body && surface.faces.empty())
      return keep_body(surface, {.name = group.name, .facets = group.facets, .box = {}});
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (spec.body == std::to_string(i + 1)) return keep_body(surface, bodies[i]);
  std::vector<std::string> names;
  names.reserve(bodies.size());
  for (const Body& body : bodies) names.push_back(body.name);
  const std::string near = common::nearest_spelling(spec.body, names);
  InputError::Details details = spec.mesh_origin;
  details.what = fmt::format("the mesh has no body '{}'", spec.body);
  details.cure = fmt::format("{}The bodies are {}",
                             near.empty() ? "" : fmt::format("Did you mean '{}'? ", near),
                             list_bodies(bodies, spec.unit));
  throw InputError(details);
}

std::vector<std::string> repaired(const LinkSpec& spec, SurfaceMesh& surface,
                                  common::Progress& progress) {
  if (spec.repair.steps.empty()) return {};
  RepairOptions options = spec.repair;
  options.unit = spec.unit;
  return describe(repair(surface, options, progress), options);
}

void require_sound(const LinkSpec& spec, const LinkMesh& mesh) {
  if (mesh.report.sound()) return;
  std::vector<std::string> wrong = mesh.notes;
  const std::vector<std::string> lines = describe(mesh.report, spec.unit);
  wrong.insert(wrong.end(), lines.end() - static_cast<std::ptrdiff_t>(mesh.report.defects.size()),
               lines.end());
  throw SurfaceError(
      {.file = spec.mesh_file,
       .what = fmt::format("the surface does not bound a solid: {}", fmt::join(wrong, "; ")),
       .cure = spec.repair.steps.empty()
                   ? "See the offending facets with 'kinetostat mesh check --vtu', or let "
                     "'mesh: {repair: [weld, orient, fill, unite, drop, wrap]}' repair them"
                   : "See the offending facets with 'kinetostat mesh check --vtu'"},
      offending_facets(mesh.imported.mesh, mesh.report));
}

[[noreturn]] void refuse_several(const LinkSpec& spec, const std::vector<Body>& bodies) {
  throw SurfaceError(
      {.file = spec.mesh_file,
       .what = fmt::format("the surface bounds {} separate bodies, a link is one: {}",
                           bodies.size(), list_bodies(bodies, spec.unit)),
       .cure = fmt::format("Pick one with 'mesh: {{body: {}}}', join them with 'bodies' and "
                           "'joints', or unite them in the CAD program",
                           bodies.front().name)},
      {});
}

// Solids of a CAD file that touch would be no sound surface together.
void require_one_solid(const LinkSpec& spec, const LinkMesh& mesh) {
  if (mesh.imported.mesh.faces.empty()) return;
  const std::vector<Body> bodies = find_bodies(mesh.imported.mesh, mesh.report.shells);
  if (bodies.size() > 1) refuse_several(spec, bodies);
}

void require_one_body(const LinkSpec& spec, const LinkMesh& mesh) {
  if (mesh.report.bodies() != 1)
    refuse_several(spec, find_bodies(mesh.imported.mesh, mesh.report.shells));
}

// No defects are searched for: faces between elements cannot cross.
LinkMesh read_volume(const LinkSpec& spec) {
  const auto refuse = [&spec](const char* key) {
    InputError::Details details = spec.mesh_origin;
    details.what = fmt::format("'{}' is for surfaces, {} is a volume mesh", key, spec.mesh_name);
    details.cure = "Leave it out";
    throw InputError(details);
  };
  if (!spec.repair.steps.empty()) refuse("repair");
  if (spec.size) refuse("elements.size");
  const auto read = [&spec](const std::filesystem::path& file, const std::string& unit) {
    return read_volume_mesh(file, unit, spec.body);
  };
  ImportedVolume imported = with_unit(spec, read);
  if (imported.mesh.order == 2 && spec.order == 1)
    throw InputError(spec.file, "elements.order is 1, the elements of the mesh file have 10 nodes",
                     "Leave 'order' out, or write a mesh of 4-node elements");
  LinkMesh mesh;
  mesh.imported.mesh = std::move(imported.surface);
  mesh.report.facets = mesh.imported.mesh.triangles.size();
  mesh.report.points = mesh.imported.mesh.points.size();
  mesh.report.box = bounding_box(mesh.imported.mesh.points);
  mesh.report.area = area_of(mesh.imported.mesh);
  mesh.report.volume = mass_properties(imported.mesh).volume;
  mesh.volume = spec.order == 2 && imported.mesh.order == 1 ? with_mid_nodes(imported.mesh)
                                                            : std::move(imported.mesh);
  mesh.notes = std::move(imported.warnings);
  mesh.imported.sha256 = std::move(imported.sha256);
  return mesh;
}

// A curved element with its nodes on a round face is off by about (pi / sides)^4 / 20 of what the
// section bends with, a flat facet with its corners there by (pi / sides)^2: a tenth, and a
// quarter, of the accuracy are left for that.
StepFacets step_facets(const LinkSpec& spec) {
  const double accuracy = spec.size ? LinkSpec::usual_accuracy : spec.accuracy;
  const double sides = spec.order == 2 ? std::numbers::pi * std::pow(0.5 / accuracy, 0.25)
                                       : std::numbers::pi * std::sqrt(4 / accuracy);
  return {.sides = static_cast<int>(std::ceil(std::clamp(sides, 16.0, 96.0)))};
}

constexpr int most_sides = 128;

LinkMesh read_with(const LinkSpec& spec, const StepFacets& facets, common::Progress& progress) {
  const auto read = [&facets](const std::filesystem::path& file, const std::string& unit) {
    return read_surface(file, unit, facets);
  };
  LinkMesh mesh{.imported = with_unit(spec, read), .report = {}};
  SurfaceMesh& surface = mesh.imported.mesh;
  pick_body(spec, surface);
  mesh.notes = repaired(spec, surface, progress);
  mesh.report = check_surface(surface, mesh.imported.weld.tolerance);
  return mesh;
}

}  // namespace

LinkMesh read_link_mesh(const LinkSpec& spec, common::Progress& progress) {
  progress.report("surface", 0);
  if (holds_volume_mesh(spec.mesh_file)) return read_volume(spec);
  StepFacets facets = step_facets(spec);
  LinkMesh mesh = read_with(spec, facets, progress);
  require_one_solid(spec, mesh);
  // Coarse facets of faces that are near each other may cross.
  for (; !mesh.report.sound() && !mesh.imported.step.empty() && facets.sides < most_sides;
       mesh = read_with(spec, facets, progress))
    facets = {.sides = 2 * facets.sides, .deviation = facets.deviation / 4};
  require_sound(spec, mesh);
  require_one_body(spec, mesh);
  return mesh;
}

}  // namespace kinetostat::fea

#include "kinetostat/fea/identify.h"

#include <algorithm>
#include <chrono>
#include <new>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/fea/surface_faces.h"

namespace kinetostat::fea {
namespace {

using files::InputError;

enum Tag { free_surface = 0, fixed_tag = 1, loaded_tag = 2 };

// Collects the wall-clock time of each phase.
class Stopwatch {
 public:
  void lap(std::string phase) {
    const auto now = Clock::now();
    laps_.emplace_back(std::move(phase), std::chrono::duration<double>(now - last_).count());
    last_ = now;
  }
  std::vector<std::pair<std::string, double>> laps() && { return std::move(laps_); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
  std::vector<std::pair<std::string, double>> laps_;
};

// A missing unit is a fault of the link file, though only the mesh shows what it might be.
ImportedSurface import(const LinkSpec& spec) {
  try {
    return read_surface(spec.mesh_file, spec.unit);
  } catch (const MissingUnit& error) {
    InputError::Details details = spec.mesh_origin;
    details.what = error.details().what;
    details.cure =
        fmt::format("Add it, for example 'mesh: {{file: {}, unit: mm}}'", spec.mesh_name);
    throw InputError(details);
  }
}

void require_sound(const LinkSpec& spec, const SurfaceMesh& surface, const SurfaceReport& report) {
  if (!report.sound()) {
    std::vector<std::string> wrong;
    const std::vector<std::string> lines = describe(report, spec.unit);
    wrong.assign(lines.end() - static_cast<std::ptrdiff_t>(report.defects.size()), lines.end());
    throw SurfaceError(
        {.file = spec.mesh_file,
         .what = fmt::format("the surface does not bound a solid: {}", fmt::join(wrong, "; ")),
         .cure = "See the offending facets with 'kinetostat mesh check --vtu'"},
        offending_facets(surface, report));
  }
  if (report.bodies() != 1)
    throw SurfaceError({.file = spec.mesh_file,
                        .what = fmt::format("the surface bounds {} separate bodies, a link is one",
                                            report.bodies()),
                        .cure = "Unite them in the CAD program, or export one of them"},
                       {});
}

std::vector<int> select(const InterfaceSpec& spec, const SurfaceMesh& surface,
                        const std::string& unit) {
  std::vector<int> facets = select_facets(surface, spec.selector);
  if (!facets.empty()) return facets;
  InputError::Details details = spec.origin;
  details.what = "no facet of the mesh is selected";
  details.cure = nearest_candidates(surface, spec.selector, unit);
  throw InputError(details);
}

// A rigid body needs three points that are not in line; a fixed face as well.
void require_area(const InterfaceSpec& spec, const SurfaceMesh& surface,
                  const std::vector<int>& facets) {
  double area = 0;
  for (const int f : facets) area += surface.area_vector(static_cast<std::size_t>(f)).norm();
  if (area > 0) return;
  InputError::Details details = spec.origin;
  details.what = "the selected facets have no area";
  throw InputError(details);
}

// Tags of all facets. The two interfaces may not even touch: a node cannot be held and follow.
std::vector<int> tag_facets(const LinkSpec& spec, const SurfaceMesh& surface) {
  std::vector<int> tags(surface.triangles.size(), free_surface);
  std::vector<bool> is_fixed(surface.points.size(), false);
  const std::vector<int> fixed = select(spec.fixed, surface, spec.unit);
  const std::vector<int> loaded = select(spec.loaded, surface, spec.unit);
  require_area(spec.fixed, surface, fixed);
  require_area(spec.loaded, surface, loaded);
  for (const int f : fixed) {
    tags[static_cast<std::size_t>(f)] = fixed_tag;
    for (const int p : surface.triangles[static_cast<std::size_t>(f)])
      is_fixed[static_cast<std::size_t>(p)] = true;
  }
  std::size_t common_facets = 0, touching = 0;
  for (const int f : loaded) {
    int& tag = tags[static_cast<std::size_t>(f)];
    if (tag == fixed_tag) ++common_facets;
    tag = loaded_tag;
    const Triangle& t = surface.triangles[static_cast<std::size_t>(f)];
    if (std::any_of(t.begin(), t.end(),
                    [&](int p) { return is_fixed[static_cast<std::size_t>(p)]; }))
      ++touching;
  }
  if (touching == 0) return tags;
  InputError::Details details = spec.loaded.origin;
  details.what =
      common_facets > 0
          ? fmt::format("{} facets are in both interfaces, fixed and loaded", common_facets)
          : fmt::format("the loaded interface touches the fixed one in {} facets", touching);
  details.cure = "Choose interfaces without a common edge or corner. " +
                 nearest_candidates(surface, spec.loaded.selector, spec.unit);
  throw InputError(details);
}

TetMesh make_mesh(const LinkSpec& spec, const SurfaceMesh& surface, const std::vector<int>& tags,
                  const TetrahedralizeOptions& options, files::Progress& progress) {
  try {
    const TetMesh linear = tetrahedralize(surface, tags, options, progress);
    return spec.order == 2 ? with_mid_nodes(linear) : linear;
  } catch (const MeshingError& error) {
    SurfaceReport blamed;
    if (!error.facets().empty())
      blamed.defects.push_back(
          {DefectKind::self_intersection, error.facets(), error.facets().size()});
    throw SurfaceError({.file = spec.mesh_file, .what = error.what(), .cure = error.cure()},
                       offending_facets(surface, blamed));
  }
}

// Three elements through a plate of the mean thickness 2 V / A.
double default_size(const SurfaceReport& report) { return 0.67 * report.volume / report.area; }

void add_warnings(const LinkSpec& spec, const SurfaceReport& report, LinkResult& result) {
  if (spec.order == 1)
    result.warnings.emplace_back(
        "4-node elements are too stiff, in bending often by tens of percent: use order 2");
  for (const Defect& defect : report.defects)
    result.warnings.push_back(
        fmt::format("{} {}s in the surface", defect.count, name(defect.kind)));
  if (!result.weld.collapsed.empty())
    result.warnings.push_back(fmt::format("{} facets collapsed in welding and were left out",
                                          result.weld.collapsed.size()));
  if (std::abs(result.geometry.volume / result.surface_volume - 1) > 1e-6)
    result.warnings.push_back(
        fmt::format("the volume of the mesh is {:.3g} % off the surface's",
                    100 * (result.geometry.volume / result.surface_volume - 1)));
  if (result.quality.least_dihedral < 2)
    result.warnings.push_back(fmt::format("the flattest element has an angle of {:.2g} degrees",
                                          result.quality.least_dihedral));
}

UnitWrenchResponse solve(const LinkSpec& spec, LinkResult& result, Stopwatch& watch,
                         files::Progress& progress) {
  const Vector3 point = spec.loaded.point.value_or(result.loaded.centroid);
  const Unknowns unknowns(result.mesh, result.fixed.nodes, {{point, result.loaded.nodes}});
  try {
    const Equations equations = assemble(result.mesh, spec.material, unknowns, progress);
    result.unknowns = static_cast<std::size_t>(equations.stiffness.size());
    watch.lap("assembly");
    UnitWrenchResponse response =
        respond_to_unit_wrenches(result.mesh, equations, unknowns, 0, progress);
    watch.lap("solution");
    return response;
  } catch (const SingularStiffness& error) {
    throw InputError(spec.file, error.what(),
                     "Is the body in one piece and the fixed interface a proper face of it?");
  } catch (const std::bad_alloc&) {
    throw InputError(
        spec.file, fmt::format("{} nodes need more memory than there is", result.mesh.nodes.size()),
        "Use a larger element size");
  }
}

void add_mass(LinkResult& result) {
  result.center_of_mass = result.geometry.centroid;
  const std::optional<double>& density = result.material.density();
  if (!density) return;
  result.mass = *density * result.geometry.volume;
  result.inertia = inertia(result.geometry, *density);
}

}  // namespace

LinkResult identify(const LinkSpec& spec, const IdentifyOptions& options,
                    files::Progress& progress) {
  Stopwatch watch;
  progress.report("surface", 0);
  ImportedSurface imported = import(spec);
  const SurfaceMesh& surface = imported.mesh;
  const SurfaceReport report = check_surface(surface, imported.weld.tolerance);
  require_sound(spec, surface, report);
  const std::vector<int> tags = tag_facets(spec, surface);
  watch.lap("surface");

  LinkResult result(spec.name, spec.material);
  TetrahedralizeOptions meshing = options.meshing;
  meshing.edge_length = result.element_size = spec.size.value_or(default_size(report));
  result.mesh = make_mesh(spec, surface, tags, meshing, progress);
  result.geometry = mass_properties(result.mesh);
  result.quality = quality(result.mesh);
  if (count_pieces(result.mesh) != 1)
    throw InputError(spec.mesh_file, "the mesh falls into pieces that do not hang together",
                     "Unite the bodies in the CAD program");
  result.fixed = interface_on(result.mesh, fixed_tag);
  result.loaded = interface_on(result.mesh, loaded_tag);
  watch.lap("tetrahedra");

  result.response = solve(spec, result, watch, progress);
  const Matrix6& raw = result.response.compliance;
  result.symmetry_defect = spatial::symmetry_defect(raw);
  result.compliance = spatial::Compliance6(
      0.5 * (raw + raw.transpose()), {.point = spec.loaded.point.value_or(result.loaded.centroid)});
  result.surface_volume = report.volume;
  result.weld = imported.weld;
  result.facets = report.facets;
  add_mass(result);
  add_warnings(spec, report, result);
  result.link_sha256 = spec.sha256;
  result.mesh_sha256 = imported.sha256;
  result.mesh_file = spec.mesh_name;
  result.unit = spec.unit;
  result.blas = blas_info();
  result.timings = std::move(watch).laps();
  return result;
}

}  // namespace kinetostat::fea

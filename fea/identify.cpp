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

// Refuses interfaces that overlap or touch: a node cannot follow two bodies.
void require_apart(const LinkSpec& spec, const SurfaceMesh& surface, std::size_t one,
                   const std::vector<int>& facets_of_one, std::size_t other,
                   const std::vector<int>& facets_of_other) {
  std::vector<bool> in_one(surface.points.size(), false);
  for (const int f : facets_of_one)
    for (const int p : surface.triangles[static_cast<std::size_t>(f)])
      in_one[static_cast<std::size_t>(p)] = true;
  std::size_t common_facets = 0, touching = 0;
  for (const int f : facets_of_other) {
    if (std::binary_search(facets_of_one.begin(), facets_of_one.end(), f)) ++common_facets;
    const Triangle& t = surface.triangles[static_cast<std::size_t>(f)];
    if (std::any_of(t.begin(), t.end(), [&](int p) { return in_one[static_cast<std::size_t>(p)]; }))
      ++touching;
  }
  if (touching == 0) return;
  const InterfaceSpec &a = spec.interfaces[one], &b = spec.interfaces[other];
  InputError::Details details = b.origin;
  details.what = common_facets > 0 ? fmt::format("{} facets are in both interfaces, {} and {}",
                                                 common_facets, a.name, b.name)
                                   : fmt::format("the {} interface touches the {} one in {} facets",
                                                 b.name, a.name, touching);
  details.cure = "Choose interfaces without a common edge or corner. " +
                 nearest_candidates(surface, b.selector, spec.unit);
  throw InputError(details);
}

// Tags of all facets: 0, or 1 + the number of the interface.
std::vector<int> tag_facets(const LinkSpec& spec, const SurfaceMesh& surface) {
  std::vector<int> tags(surface.triangles.size(), 0);
  std::vector<std::vector<int>> selected;
  for (const InterfaceSpec& interface : spec.interfaces) {
    selected.push_back(select(interface, surface, spec.unit));
    require_area(interface, surface, selected.back());
    for (const int f : selected.back())
      tags[static_cast<std::size_t>(f)] = static_cast<int>(selected.size());
    for (std::size_t other = 0; other + 1 < selected.size(); ++other)
      require_apart(spec, surface, other, selected[other], selected.size() - 1, selected.back());
  }
  return tags;
}

std::vector<CoupledInterface> coupled_interfaces(const LinkSpec& spec, const TetMesh& mesh) {
  std::vector<CoupledInterface> interfaces;
  for (const InterfaceSpec& interface : spec.interfaces) {
    const Interface geometry = interface_on(mesh, static_cast<int>(interfaces.size()) + 1);
    interfaces.push_back({.name = interface.name,
                          .geometry = geometry,
                          .point = interface.point.value_or(geometry.centroid),
                          .coupling = interface.coupling,
                          .modulus_ratio = interface.modulus_ratio});
  }
  return interfaces;
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

LinkResponse solve(const LinkSpec& spec, const SolverOptions& options, const LinkResult& result,
                   files::Progress& progress) {
  try {
    return respond(result.mesh, {spec.material}, result.interfaces, options, progress);
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
  result.interfaces = coupled_interfaces(spec, result.mesh);
  watch.lap("tetrahedra");

  result.response = solve(spec, options.solver, result, progress);
  watch.lap("response");
  const Matrix6 raw = result.response.compliance();
  result.symmetry_defect = spatial::symmetry_defect(raw);
  result.compliance =
      spatial::Compliance6(0.5 * (raw + raw.transpose()), {.point = result.interfaces[1].point});
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

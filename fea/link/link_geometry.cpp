#include "kinetostat/fea/link/link_geometry.h"

#include <algorithm>
#include <chrono>

#include <fmt/format.h>

#include "kinetostat/common/index.h"
#include "kinetostat/common/out_of_memory.h"
#include "kinetostat/fea/mesh/curved_boundary.h"
#include "kinetostat/fea/surface/surface_faces.h"

namespace kinetostat::fea {
namespace {

using common::at;
using common::InputError;

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
  for (const int f : facets) area += surface.area_vector(at(f)).norm();
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
    for (const int p : surface.triangles[at(f)]) in_one[at(p)] = true;
  std::size_t common_facets = 0, touching = 0;
  for (const int f : facets_of_other) {
    if (std::binary_search(facets_of_one.begin(), facets_of_one.end(), f)) ++common_facets;
    const Triangle& t = surface.triangles[at(f)];
    if (std::any_of(t.begin(), t.end(), [&](int p) { return in_one[at(p)]; })) ++touching;
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
    for (const int f : selected.back()) tags[at(f)] = static_cast<int>(selected.size());
    for (std::size_t other = 0; other + 1 < selected.size(); ++other)
      require_apart(spec, surface, other, selected[other], selected.size() - 1, selected.back());
  }
  return tags;
}

// How many tags each face of the file has.
int tags_of_face(const LinkSpec& spec) { return static_cast<int>(spec.interfaces.size()) + 1; }

}  // namespace

LinkGeometry read_geometry(const LinkSpec& spec, common::Progress& progress) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  LinkGeometry geometry{read_link_mesh(spec, progress)};
  geometry.tags = tag_facets(spec, geometry.imported.mesh);
  const std::vector<int> faces = face_of_facets(geometry.imported.mesh);
  for (std::size_t f = 0; f < faces.size(); ++f) geometry.tags[f] += tags_of_face(spec) * faces[f];
  geometry.reading_seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return geometry;
}

double default_size(const SurfaceReport& report) { return 0.67 * report.volume / report.area; }

namespace {

// A mesh from a file, its faces tagged like the facets that stand for them.
TetMesh tagged(TetMesh mesh, const std::vector<int>& tags) {
  for (std::size_t f = 0; f < tags.size(); ++f) mesh.boundary[f].tag = tags[f];
  return mesh;
}

void require_one_piece(const LinkSpec& spec, const TetMesh& mesh) {
  if (count_pieces(mesh) != 1)
    throw InputError(spec.mesh_file, "the mesh falls into pieces that do not hang together",
                     "Unite the bodies in the CAD program");
}

}  // namespace

namespace {

[[noreturn]] void refuse(const LinkSpec& spec, const SurfaceMesh& surface,
                         const MeshingError& error) {
  if (error.cause() == MeshingError::Cause::out_of_memory)
    throw common::OutOfMemory(error.what(), error.cure(), spec.mesh_file.string());
  SurfaceReport blamed;
  if (!error.facets().empty())
    blamed.defects.push_back(
        {DefectKind::self_intersection, error.facets(), error.facets().size()});
  throw SurfaceError({.file = spec.mesh_file, .what = error.what(), .cure = error.cure()},
                     offending_facets(surface, blamed));
}

// Takes the faces of the file out of the tags and puts the nodes onto them.
TetMesh finished(const LinkSpec& spec, const LinkGeometry& geometry, TetMesh linear,
                 common::Progress& progress) {
  if (geometry.imported.step.empty())
    return spec.order == 2 ? with_mid_nodes(linear) : std::move(linear);
  CadBoundary cad{.step = geometry.imported.step, .faces = geometry.imported.mesh.faces};
  for (BoundaryFace& face : linear.boundary) {
    cad.face_of.push_back(face.tag / tags_of_face(spec));
    face.tag %= tags_of_face(spec);
  }
  try {
    return on_cad_faces(linear, cad, spec.order, progress);
  } catch (const StepError& error) {
    throw InputError(spec.mesh_file, error.what(),
                     "Export the link again, as STEP AP214 or as STL");
  }
}

}  // namespace

TetMesh fill(const LinkSpec& spec, const LinkGeometry& geometry, SolidMesher& mesher,
             const TetrahedralizeOptions& options, common::Progress& progress) {
  if (geometry.volume) {
    require_one_piece(spec, *geometry.volume);
    return tagged(*geometry.volume, geometry.tags);
  }
  try {
    const TetMesh linear = mesher.fill(options, progress);
    require_one_piece(spec, linear);
    return finished(spec, geometry, linear, progress);
  } catch (const MeshingError& error) {
    refuse(spec, geometry.imported.mesh, error);
  }
}

std::vector<CoupledInterface> interfaces_on(const LinkSpec& spec, const TetMesh& mesh) {
  std::vector<CoupledInterface> interfaces;
  for (const InterfaceSpec& interface : spec.interfaces) {
    const Interface geometry = interface_on(mesh, static_cast<int>(interfaces.size()) + 1);
    interfaces.push_back({.name = interface.name,
                          .geometry = geometry,
                          .point = interface.point.value_or(geometry.centroid),
                          .coupling = interface.coupling,
                          .modulus_ratio = interface.modulus_ratio,
                          .layer = interface.layer});
  }
  return interfaces;
}

}  // namespace kinetostat::fea

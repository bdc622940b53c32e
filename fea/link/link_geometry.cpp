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

// The link itself, or the bodies of an assembly.
template <class Geometry>
std::vector<Geometry*> solids_of(Geometry& geometry) {
  if (geometry.bodies.empty()) return {&geometry};
  std::vector<Geometry*> solids;
  for (auto& body : geometry.bodies) solids.push_back(&body);
  return solids;
}

const SurfaceMesh& surface_of(const LinkGeometry& geometry) { return geometry.imported.mesh; }

// Facets of each body, in the order of solids_of().
using Selection = std::vector<std::vector<int>>;

bool is_on(const InterfaceSpec& spec, std::size_t body) { return !spec.body || *spec.body == body; }

// A ray meets one face of one body first.
Selection first_met(const InterfaceSpec& spec, const LinkGeometry& geometry) {
  Selection facets(geometry.bodies.size());
  int first = 0;
  std::size_t body = 0;
  for (const int facet : select_facets(surface_of(geometry), spec.selector)) {
    const auto size = [&] {
      return static_cast<int>(surface_of(geometry.bodies[body]).triangles.size());
    };
    while (facet >= first + size()) first += size(), ++body;
    facets[body].push_back(facet - first);
  }
  return facets;
}

Selection selected(const InterfaceSpec& spec, const LinkGeometry& geometry) {
  if (!geometry.bodies.empty() && !spec.body &&
      std::holds_alternative<NearestFaceSelector>(spec.selector))
    return first_met(spec, geometry);
  Selection facets;
  for (const LinkGeometry* solid : solids_of(geometry))
    facets.push_back(is_on(spec, facets.size()) ? select_facets(surface_of(*solid), spec.selector)
                                                : std::vector<int>());
  return facets;
}

std::string candidates(const InterfaceSpec& interface, const LinkSpec& spec,
                       const LinkGeometry& geometry) {
  if (spec.bodies.empty())
    return nearest_candidates(surface_of(geometry), interface.selector, spec.unit);
  std::string all;
  for (std::size_t b = 0; b < spec.bodies.size(); ++b)
    if (is_on(interface, b))
      all += fmt::format(
          "{}In {}: {}", all.empty() ? "" : " ", spec.bodies[b].name,
          nearest_candidates(surface_of(geometry.bodies[b]), interface.selector, spec.unit));
  return all;
}

// A rigid body needs three points that are not in line; a fixed face as well.
double area_of(const Selection& facets, const LinkGeometry& geometry) {
  double area = 0;
  const auto solids = solids_of(geometry);
  for (std::size_t b = 0; b < solids.size(); ++b)
    area += area_of(surface_of(*solids[b]), facets[b]);
  return area;
}

Selection select(const InterfaceSpec& interface, const LinkSpec& spec,
                 const LinkGeometry& geometry) {
  Selection facets = selected(interface, geometry);
  InputError::Details details = interface.origin;
  if (std::all_of(facets.begin(), facets.end(), [](const auto& own) { return own.empty(); })) {
    details.what = "no facet of the mesh is selected";
    details.cure = candidates(interface, spec, geometry);
    throw InputError(details);
  }
  if (area_of(facets, geometry) > 0) return facets;
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

// Tags of the facets of one body: 0, or 1 + the number of the interface; and with the faces.
void tag_facets(const LinkSpec& spec, const std::vector<Selection>& selections, std::size_t body,
                LinkGeometry& solid) {
  const SurfaceMesh& surface = surface_of(solid);
  solid.tags_of_face = static_cast<int>(spec.interfaces.size()) + 1;
  solid.tags = face_of_facets(surface);
  for (int& tag : solid.tags) tag *= solid.tags_of_face;
  solid.tags.resize(surface.triangles.size(), 0);
  for (std::size_t i = 0; i < selections.size(); ++i) {
    const std::vector<int>& facets = selections[i][body];
    for (std::size_t other = 0; other < i; ++other)
      require_apart(spec, surface, other, selections[other][body], i, facets);
    for (const int f : facets) solid.tags[at(f)] += static_cast<int>(i) + 1;
  }
}

LinkGeometry read_solids(const LinkSpec& spec, common::Progress& progress) {
  if (spec.bodies.empty()) return {read_link_mesh(spec, progress)};
  std::vector<LinkGeometry> bodies;
  for (const LinkSpec& body : spec.bodies) bodies.push_back({read_link_mesh(body, progress)});
  return together(spec, std::move(bodies));
}

}  // namespace

LinkGeometry read_geometry(const LinkSpec& spec, common::Progress& progress) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  LinkGeometry geometry = read_solids(spec, progress);
  std::vector<Selection> selections;
  for (const InterfaceSpec& interface : spec.interfaces)
    selections.push_back(select(interface, spec, geometry));
  const std::vector<LinkGeometry*> solids = solids_of(geometry);
  for (std::size_t b = 0; b < solids.size(); ++b) tag_facets(spec, selections, b, *solids[b]);
  if (!geometry.bodies.empty()) require_held(spec, geometry);
  geometry.reading_seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return geometry;
}

double default_size(const SurfaceReport& report) { return 0.67 * report.volume / report.area; }

SizeField first_sizes(const LinkGeometry& geometry) {
  SizeField all;
  for (const LinkGeometry* solid : solids_of(geometry)) {
    const SizeField own = size_from_surface(surface_of(*solid));
    all.points.insert(all.points.end(), own.points.begin(), own.points.end());
    all.sizes.insert(all.sizes.end(), own.sizes.begin(), own.sizes.end());
  }
  return all;
}

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
  CadBoundary cad{.step = geometry.imported.step, .faces = surface_of(geometry).faces};
  for (BoundaryFace& face : linear.boundary) {
    cad.face_of.push_back(face.tag / geometry.tags_of_face);
    face.tag %= geometry.tags_of_face;
  }
  try {
    return on_cad_faces(linear, cad, spec.order, progress);
  } catch (const StepError& error) {
    throw InputError(spec.mesh_file, error.what(),
                     "Export the link again, as STEP AP214 or as STL");
  }
}

// One body; `geometry` is its own.
TetMesh filled(const LinkSpec& spec, const LinkGeometry& geometry, SolidMesher& mesher,
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
    refuse(spec, surface_of(geometry), error);
  }
}

}  // namespace

LinkMesher::LinkMesher(const LinkGeometry& geometry) {
  for (const LinkGeometry* solid : solids_of(geometry))
    meshers_.emplace_back(surface_of(*solid), solid->tags);
}

MeshingRecord LinkMesher::record() const {
  MeshingRecord all = meshers_.front().record();
  for (std::size_t b = 1; b < meshers_.size(); ++b) {
    const MeshingRecord& own = meshers_[b].record();
    all.failures.insert(all.failures.end(), own.failures.begin(), own.failures.end());
    if (!all.deviation || (own.deviation && own.deviation->distance > all.deviation->distance))
      all.deviation = own.deviation;
  }
  return all;
}

TetMesh fill(const LinkSpec& spec, const LinkGeometry& geometry, LinkMesher& mesher,
             const TetrahedralizeOptions& options, common::Progress& progress) {
  if (geometry.bodies.empty()) return filled(spec, geometry, mesher.of_body(0), options, progress);
  TetrahedralizeOptions share = options;
  share.time_limit /= static_cast<double>(geometry.bodies.size());
  std::vector<TetMesh> bodies;
  for (std::size_t b = 0; b < geometry.bodies.size(); ++b)
    bodies.push_back(
        filled(spec.bodies[b], geometry.bodies[b], mesher.of_body(b), share, progress));
  TetMesh mesh = side_by_side(bodies);
  join_bodies(spec, geometry, mesh);
  return mesh;
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

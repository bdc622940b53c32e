// The shape of a link: its surface, checked, with its interfaces, and the solid filled with
// elements.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "kinetostat/common/progress.h"
#include "kinetostat/fea/link/link_file.h"
#include "kinetostat/fea/link/link_mesh.h"
#include "kinetostat/fea/mesh/size_field.h"
#include "kinetostat/fea/mesh/solid_mesh.h"
#include "kinetostat/fea/mesh/tetrahedralize.h"
#include "kinetostat/fea/surface/surface_check.h"

namespace kinetostat::fea {

struct LinkGeometry : LinkMesh {
  /// Of the facets: 0, or 1 + the number of the interface; plus, where the file has faces, their
  /// number (from 1) times `tags_of_face`.
  std::vector<int> tags = {};
  int tags_of_face = 1;        // one more than the link has interfaces
  double reading_seconds = 0;  // [s] wall clock
  /// Of an assembly, in the order of the link file; `imported`, `report` and `notes` are then of
  /// all of them together. Empty: the link is one body.
  std::vector<LinkGeometry> bodies = {};

  /// The elements come from files.
  bool is_meshed() const { return volume || (!bodies.empty() && bodies.front().volume); }
};

/// The meshers of the bodies of a link.
class LinkMesher {
 public:
  /// `geometry` must outlive this.
  explicit LinkMesher(const LinkGeometry& geometry);

  SolidMesher& of_body(std::size_t number) { return meshers_[number]; }
  /// Of all bodies: their failures, and the surface that was moved farthest.
  MeshingRecord record() const;

 private:
  std::vector<SolidMesher> meshers_;
};

/// Reads the meshes and picks the interfaces. Throws SurfaceError when the surface of a body does
/// not bound one solid, InputError when an interface is empty or touches another, or when a body of
/// an assembly is neither joined to the others nor held by an interface.
LinkGeometry read_geometry(const LinkSpec& spec, common::Progress& progress);

/// What is said of all bodies together, from what is said of each (link_bodies.cpp, as the next
/// two).
LinkGeometry together(const LinkSpec& spec, std::vector<LinkGeometry> bodies);

/// Throws InputError where a body of an assembly is neither joined to the others nor held with them
/// by a rigid interface. Requires tags.
void require_held(const LinkSpec& spec, const LinkGeometry& geometry);

/// Adds the contacts of all joints to the bodies' meshes side by side. Throws InputError where
/// there are none for a joint, or where an interface lies on one.
void join_bodies(const LinkSpec& spec, const LinkGeometry& geometry, TetMesh& mesh);

/// Three elements through a plate of the mean thickness 2 V / A [m].
double default_size(const SurfaceReport& report);

/// Where bodies should be coarse and fine to start with.
SizeField first_sizes(const LinkGeometry& geometry);

/// Tetrahedra of the order of the link file, their boundary tagged as the facets: those of the mesh
/// file when it is a volume mesh, else made by `mesher`, which is one of `geometry`. Bodies are
/// side by side, with the contacts of their joints; the faces there are tagged with one more than
/// there are interfaces. Throws SurfaceError, common::OutOfMemory, InputError where bodies with a
/// joint do not touch, or an interface lies on one.
TetMesh fill(const LinkSpec& spec, const LinkGeometry& geometry, LinkMesher& mesher,
             const TetrahedralizeOptions& options, common::Progress& progress);

/// The interfaces of the link file on its mesh, in the same order.
std::vector<CoupledInterface> interfaces_on(const LinkSpec& spec, const TetMesh& mesh);

}  // namespace kinetostat::fea

// The shape of a link: its surface, checked, with its interfaces, and the solid filled with
// elements.
#pragma once

#include <utility>
#include <vector>

#include "kinetostat/common/progress.h"
#include "kinetostat/fea/link/link_file.h"
#include "kinetostat/fea/link/link_mesh.h"
#include "kinetostat/fea/mesh/solid_mesh.h"
#include "kinetostat/fea/mesh/tetrahedralize.h"
#include "kinetostat/fea/surface/surface_check.h"

namespace kinetostat::fea {

struct LinkGeometry : LinkMesh {
  /// Of the facets: 0, or 1 + the number of the interface; plus, where the file has faces, their
  /// number (from 1) times one more than there are interfaces.
  std::vector<int> tags = {};
  double reading_seconds = 0;  // [s] wall clock
};

/// Reads the mesh and picks the interfaces. Throws SurfaceError when the surface does not bound
/// one solid, InputError when an interface is empty or touches another.
LinkGeometry read_geometry(const LinkSpec& spec, common::Progress& progress);

/// Three elements through a plate of the mean thickness 2 V / A [m].
double default_size(const SurfaceReport& report);

/// Tetrahedra of the order of the link file, their boundary tagged as the facets: those of the mesh
/// file when it is a volume mesh, else made by `mesher`, which is one of the surface of `geometry`.
/// Throws SurfaceError, common::OutOfMemory.
TetMesh fill(const LinkSpec& spec, const LinkGeometry& geometry, SolidMesher& mesher,
             const TetrahedralizeOptions& options, common::Progress& progress);

/// The interfaces of the link file on its mesh, in the same order.
std::vector<CoupledInterface> interfaces_on(const LinkSpec& spec, const TetMesh& mesh);

}  // namespace kinetostat::fea

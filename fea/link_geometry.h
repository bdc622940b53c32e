// The shape of a link: its surface, checked, with its interfaces, and the solid filled with
// elements.
#pragma once

#include <utility>
#include <vector>

#include "kinetostat/fea/link_file.h"
#include "kinetostat/fea/surface_check.h"
#include "kinetostat/fea/tetrahedralize.h"
#include "kinetostat/files/progress.h"
#include "kinetostat/files/vtu.h"

namespace kinetostat::fea {

/// The surface of the link cannot be meshed. Ends the program like any other bad input, but keeps
/// the facets for a picture.
class SurfaceError : public files::InputError {
 public:
  SurfaceError(Details details, files::VtuGrid facets)
      : InputError(std::move(details)), facets_(std::move(facets)) {}

  /// Empty when no facet is to blame.
  const files::VtuGrid& facets() const { return facets_; }

 private:
  files::VtuGrid facets_;
};

struct LinkGeometry {
  ImportedSurface imported;
  SurfaceReport report;
  std::vector<int> tags;  // of the facets: 0, or 1 + the number of the interface
};

/// Reads the surface and picks the interfaces. Throws SurfaceError when the surface does not bound
/// one solid, InputError when an interface is empty or touches another.
LinkGeometry read_geometry(const LinkSpec& spec);

/// Three elements through a plate of the mean thickness 2 V / A [m].
double default_size(const SurfaceReport& report);

/// Tetrahedra of the order of the link file, their boundary tagged as the facets. Throws
/// SurfaceError.
TetMesh fill(const LinkSpec& spec, const LinkGeometry& geometry,
             const TetrahedralizeOptions& options, files::Progress& progress);

/// The interfaces of the link file on its mesh, in the same order.
std::vector<CoupledInterface> interfaces_on(const LinkSpec& spec, const TetMesh& mesh);

}  // namespace kinetostat::fea

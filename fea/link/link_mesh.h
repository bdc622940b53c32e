// Mesh of a link from its file: read, one body picked, repaired on request, checked.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/common/error.h"
#include "kinetostat/common/progress.h"
#include "kinetostat/fea/link/link_file.h"
#include "kinetostat/fea/mesh/surface_import.h"
#include "kinetostat/fea/mesh/tet_mesh.h"
#include "kinetostat/fea/surface/surface_check.h"
#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

/// The surface of the link cannot be meshed. Ends the program like any other bad input, but keeps
/// the facets for a picture.
class SurfaceError : public common::InputError {
 public:
  SurfaceError(Details details, io::VtuGrid facets)
      : InputError(std::move(details)), facets_(std::move(facets)) {}

  /// Empty when no facet is to blame.
  const io::VtuGrid& facets() const { return facets_; }

 private:
  io::VtuGrid facets_;
};

struct LinkMesh {
  ImportedSurface imported;  // bounds one solid; of a volume mesh, facet f is boundary face f
  SurfaceReport report;      // of the surface; of a volume mesh without a search for defects
  std::optional<TetMesh> volume = {};   // the file is a volume mesh; of the order of the link file
  std::vector<std::string> notes = {};  // what was done to the mesh, for the user to look at
};

/// Throws SurfaceError when the surface does not bound one solid, InputError for everything else
/// that the user can repair, Cancelled.
LinkMesh read_link_mesh(const LinkSpec& spec, common::Progress& progress);

}  // namespace kinetostat::fea

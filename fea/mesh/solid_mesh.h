// A closed surface filled with tetrahedra by whoever can: TetGen, TetGen on a cleaned or remeshed
// surface, Gmsh. The ladder of attempts is a list in solid_mesh.cpp.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/common/progress.h"
#include "kinetostat/fea/mesh/tet_mesh.h"
#include "kinetostat/fea/mesh/tetrahedralize.h"
#include "kinetostat/fea/surface/surface_cleaning.h"

namespace kinetostat::fea {

/// How far the surface that was meshed is from the given one.
struct SurfaceDeviation {
  double allowed = 0;        // [m] no point of either is farther from the other: checked
  double distance = 0;       // [m] the largest distance found
  double volume_change = 0;  // as a fraction, at most most_volume_change
};
inline constexpr double most_volume_change = 0.005;

struct MeshingFailure {
  std::string way;     // "TetGen on the surface as it is"
  std::string reason;  // "TetGen crashed on this surface (Aborted)"
};

/// How the meshes of a solid came about.
struct MeshingRecord {
  std::vector<MeshingFailure> failures = {};       // in the order of the attempts
  std::string way = {};                            // what made the last mesh; empty: nothing yet
  std::optional<SurfaceDeviation> deviation = {};  // none: the surface was meshed as it is
};

/// Fills one solid, once or with several sizes, by the first rung of the ladder that succeeds.
/// Later meshes start at the rung that made the one before, so that all have the same surface where
/// that is possible.
class SolidMesher {
 public:
  /// As tetrahedralize() requires; both must outlive this.
  SolidMesher(const SurfaceMesh& surface, const std::vector<int>& tags)
      : surface_(surface), tags_(tags) {}

  /// As tetrahedralize(), whose time limit holds for all attempts and all meshes of this solid
  /// together; `shapes` is left to the ladder. `made_by` of the mesh says who did it. When all
  /// fail, the MeshingError is that of the first attempt and says what else was tried; its cause is
  /// out_of_memory when that was the cause of any.
  TetMesh fill(const TetrahedralizeOptions& options, common::Progress& progress);

  const MeshingRecord& record() const { return record_; }

 private:
  class Attempt;
  struct Prepared {
    std::optional<CleanSurface> surface;  // none: there is no such surface, or it is the given one
    std::optional<SurfaceDeviation> deviation;
    std::string fault;         // why there is none
    double good_elements = 0;  // about so many it would take to fill it with well shaped ones
  };

  const SurfaceMesh& surface_;
  const std::vector<int>& tags_;
  std::size_t rung_ = 0;
  double time_used_ = 0;              // [s] by all meshes so far
  std::map<int, Prepared> prepared_;  // by the kind of surface
  MeshingRecord record_;
};

}  // namespace kinetostat::fea

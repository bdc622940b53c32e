// STEP files, read by Open CASCADE in a process of its own, when kinetostat was built with it.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "kinetostat/common/progress.h"
#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

/// Why it was not done.
class StepError : public std::runtime_error {
 public:
  enum class Cause { unreadable, no_helper, timed_out, out_of_memory };
  StepError(Cause cause, const std::string& what) : std::runtime_error(what), cause_(cause) {}
  Cause cause() const { return cause_; }

 private:
  Cause cause_;
};

/// How finely faces are cut into facets.
struct StepFacets {
  int sides = 32;           // of a full turn at least, 8 or more
  double deviation = 2e-3;  // of facets from faces at most, in parts of the diagonal
};

struct StepLimits {
  double time = 300;                          // [s]
  std::size_t memory = std::size_t{8} << 30;  // [bytes]
  std::filesystem::path helper = {};          // kinetostat-step; empty: find_helper()
};

/// The faces of the solids of a STEP file with these bytes, cut into facets [m]; unwelded. Throws
/// StepError, Cancelled.
SurfaceMesh step_surface(const std::string& step, const StepFacets& facets,
                         const StepLimits& limits, common::Progress& progress);

/// Points [m] that belong on faces of the file.
struct PointsOnFaces {
  std::vector<Vector3> points = {};
  std::vector<std::vector<int>> faces = {};  // of each point, by number, ascending; may be empty
};

/// The point on the face that is nearest to each point: on the edge common to two faces, at the
/// corner common to more; the point itself where there is none. Throws as step_surface().
std::vector<Vector3> nearest_on_faces(const std::string& step, const PointsOnFaces& points,
                                      const StepLimits& limits, common::Progress& progress);

}  // namespace kinetostat::fea

// Surfaces that do not bound a solid, repaired on request, and how much that changed them.
#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "kinetostat/common/progress.h"
#include "kinetostat/fea/surface/surface_check.h"
#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

/// In the order in which they are taken.
///   weld    corners of open edges nearer than the tolerance become one, open edges take in the
///           corners that lie on them, facets that are there twice go
///   orient  facets of a shell agree with one another, its outside is out
///   fill    holes are closed by triangles between their corners (CGAL)
///   unite   closed bodies that overlap, touch or lie within one another become their union; where
///           one crosses itself, the facets that do are replaced (CGAL)
///   drop    bodies that touch nothing and are small beside the largest are left out
///   wrap    a new surface is shrunk onto the old one from outside (CGAL, alpha wrapping)
enum class RepairStep { weld, orient, fill, unite, drop, wrap };

/// All steps, by name: "weld" ... "wrap".
const std::vector<std::string>& repair_steps();
std::string name(RepairStep step);
/// Throws std::invalid_argument for a word that is no step.
RepairStep repair_step(const std::string& name);

struct RepairOptions {
  std::vector<RepairStep> steps = {};  // allowed; taken where there is something to repair
  double tolerance = 0;                // [m] of weld, >= 0; 0: 1e-4 of the bounding box's diagonal
  double limit = 0.01;  // the enclosed volume may change by this fraction, what is dropped
                        // included, and no point of the new surface be farther than this fraction
                        // of the diagonal from the old one
  std::string unit = "m";   // of the lengths in words
  double stored_unit = 0;   // [m] of the STL file that the surface is for: every step is judged by
                            // what the file holds in single precision; 0: it is not stored
  double time_limit = 120;  // [s] of each run of the helper, > 0
  std::size_t memory_limit = std::size_t{6} << 30;  // [bytes] of the helper
  std::filesystem::path helper = {};                // kinetostat-cgal; empty: find_helper()
};

struct RepairAction {
  RepairStep step;
  bool done = false;  // false: it was tried and given up, the words say why
  std::string words = {};
};

struct RepairReport {
  std::vector<RepairAction> actions = {};  // steps that had nothing to repair are not listed
  std::optional<double> volume_before;     // [m^3] enclosed, overlaps counted once; none when the
                                           // surface is too open for a volume
  double volume_after = 0;                 // [m^3], measured the same way
  double distance = 0;    // [m] largest distance of the new surface from the old one, patches of
                          // holes apart
  double patch_area = 0;  // [m^2] of the patches of holes
};

/// Repairs the surface by the steps that are allowed, each only while check_surface() finds
/// something that it can repair; a result that moved beyond the limit is given up and the action
/// says by how much. Groups of facets are kept. The same input gives the same surface. Throws only
/// Cancelled, common::OutOfMemory, and std::invalid_argument for options out of bounds: what could
/// not be repaired is left to the check.
RepairReport repair(SurfaceMesh& mesh, const RepairOptions& options, common::Progress& progress);

/// One sentence an action, and the change as a whole.
std::vector<std::string> describe(const RepairReport& report, const RepairOptions& options);

}  // namespace kinetostat::fea

// The pre-flight check of a surface: can it bound a solid?
#pragma once

#include <string>
#include <vector>

#include "kinetostat/fea/surface/surface_mesh.h"
#include "kinetostat/fea/surface/surface_orientation.h"
#include "kinetostat/io/vtu.h"

namespace kinetostat::fea {

enum class DefectKind {
  open_edge,
  non_manifold_edge,
  inconsistent_orientation,
  inside_out,
  self_intersection,
  duplicate_facet,
  degenerate_facet
};

/// "open edge", "non-manifold edge" ...
std::string name(DefectKind kind);

struct Defect {
  DefectKind kind;
  std::vector<int> facets;  // concerned, from 0, ascending
  std::size_t count;        // of edges for the edge defects, of pairs for self-intersections
};

struct SurfaceReport {
  std::size_t facets = 0, points = 0;
  Box box;               // [m]
  double area = 0;       // [m^2]
  double volume = 0;     // [m^3], signed
  double tolerance = 0;  // [m] used for degenerate facets and contacts
  std::vector<Shell> shells = {};
  std::vector<Defect> defects = {};  // in the order of DefectKind; absent kinds are not listed

  /// No defect that keeps the surface from bounding a solid. Degenerate facets alone do not.
  bool sound() const;
  int bodies() const;
  int cavities() const;
};

/// Never throws on a bad surface: what is wrong is the result.
SurfaceReport check_surface(const SurfaceMesh& mesh, double tolerance);

/// The report in plain sentences, one a line; lengths in `unit`. A density above zero adds the
/// mass.
std::vector<std::string> describe(const SurfaceReport& report, const std::string& unit,
                                  double density = 0);

/// A question when the box is too small or too large for a link in this unit; else empty.
std::string doubt_about_unit(const Box& box, const std::string& unit);

/// Cure of a defect, one sentence.
std::string cure(DefectKind kind);

/// The offending facets; one cell field of 0 and 1 per kind of defect, named after it, and the
/// number of each facet.
io::VtuGrid offending_facets(const SurfaceMesh& mesh, const SurfaceReport& report);

}  // namespace kinetostat::fea

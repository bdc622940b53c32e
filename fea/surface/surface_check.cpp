#include "kinetostat/fea/surface/surface_check.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/surface/self_intersection.h"
#include "kinetostat/fea/surface/surface_orientation.h"
#include "kinetostat/fea/surface/surface_topology.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::fea {
namespace {

using common::at;

void add_defect(SurfaceReport& report, DefectKind kind, std::vector<int> facets,
                std::size_t count) {
  if (facets.empty()) return;
  std::sort(facets.begin(), facets.end());
  facets.erase(std::unique(facets.begin(), facets.end()), facets.end());
  report.defects.push_back({kind, std::move(facets), count});
}

void find_edge_defects(const std::vector<EdgeUse>& uses, SurfaceReport& report) {
  std::vector<int> open, crowded;
  std::size_t open_count = 0, crowded_count = 0;
  for_each_edge(uses, [&](auto first, auto last) {
    if (last - first == 2) return;
    std::vector<int>& facets = last - first == 1 ? open : crowded;
    ++(last - first == 1 ? open_count : crowded_count);
    for (auto use = first; use != last; ++use) facets.push_back(use->facet);
  });
  add_defect(report, DefectKind::open_edge, std::move(open), open_count);
  add_defect(report, DefectKind::non_manifold_edge, std::move(crowded), crowded_count);
}

void find_duplicates(const SurfaceMesh& mesh, SurfaceReport& report) {
  const auto corners = [&mesh](int f) { return sorted(mesh.triangles[at(f)]); };
  std::vector<int> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&corners](int a, int b) {
    return std::tuple(corners(a), a) < std::tuple(corners(b), b);
  });
  std::vector<int> extra;
  for (std::size_t i = 1; i < order.size(); ++i)
    if (corners(order[i]) == corners(order[i - 1])) extra.push_back(order[i]);
  const std::size_t count = extra.size();
  add_defect(report, DefectKind::duplicate_facet, std::move(extra), count);
}

void find_degenerate(const SurfaceMesh& mesh, SurfaceReport& report) {
  std::vector<int> thin;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k)
      longest = std::max(longest, (mesh.corner(f, (k + 1) % 3) - mesh.corner(f, k)).norm());
    if (2 * mesh.area_vector(f).norm() < report.tolerance * longest)
      thin.push_back(static_cast<int>(f));
  }
  const std::size_t count = thin.size();
  add_defect(report, DefectKind::degenerate_facet, std::move(thin), count);
}

// A body's shell must have positive volume, a cavity's negative; meaningless before the shells are
// closed and oriented.
void find_inside_out(SurfaceReport& report) {
  if (!report.defects.empty()) return;
  std::vector<int> facets;
  std::size_t count = 0;
  for (const Shell& shell : report.shells) {
    const double expected_sign = shell.depth % 2 == 0 ? 1 : -1;
    if (expected_sign * shell.volume > 0) continue;
    facets.insert(facets.end(), shell.facets.begin(), shell.facets.end());
    ++count;
  }
  add_defect(report, DefectKind::inside_out, std::move(facets), count);
}

void find_intersections(const SurfaceMesh& mesh, SurfaceReport& report) {
  const SelfIntersections crossings = self_intersections(mesh, report.tolerance);
  std::vector<int> facets;
  for (const auto& [a, b] : crossings.pairs) {
    facets.push_back(a);
    facets.push_back(b);
  }
  add_defect(report, DefectKind::self_intersection, std::move(facets), crossings.pairs.size());
}

std::string what_is_counted(const Defect& defect) {
  const std::size_t n = defect.count;
  const auto some = [n](const char* one, const char* many) {
    return fmt::format("{} {}", n, n == 1 ? one : many);
  };
  switch (defect.kind) {
    case DefectKind::self_intersection:
      return some("pair of facets crosses", "pairs of facets cross");
    case DefectKind::open_edge:
      return some("open edge", "open edges") + " (only one facet)";
    case DefectKind::non_manifold_edge:
      return some("non-manifold edge", "non-manifold edges") + " (three or more facets)";
    case DefectKind::inconsistent_orientation:
      return fmt::format(
          "{} the other way than {} ({})",
          defect.facets.size() == 1 ? "1 facet faces"
                                    : fmt::format("{} facets face", defect.facets.size()),
          defect.facets.size() == 1 ? "its neighbours" : "their neighbours", some("edge", "edges"));
    case DefectKind::inside_out:
      return some("shell is inside out", "shells are inside out");
    case DefectKind::duplicate_facet:
      return some("facet is", "facets are") + " there twice";
    case DefectKind::degenerate_facet:
      return some("facet is", "facets are") + " thinner than the tolerance";
  }
  return {};
}

std::string facet_list(const std::vector<int>& facets) {
  constexpr std::size_t shown = 5;
  std::vector<int> first;
  for (std::size_t i = 0; i < std::min(shown, facets.size()); ++i) first.push_back(facets[i] + 1);
  return fmt::format("facet{} {}{}", facets.size() > 1 ? "s" : "", fmt::join(first, ", "),
                     facets.size() > shown ? ", ..." : "");
}

}  // namespace

std::string name(DefectKind kind) {
  switch (kind) {
    case DefectKind::open_edge:
      return "open edge";
    case DefectKind::non_manifold_edge:
      return "non-manifold edge";
    case DefectKind::inconsistent_orientation:
      return "inconsistent orientation";
    case DefectKind::inside_out:
      return "inside out";
    case DefectKind::self_intersection:
      return "self-intersection";
    case DefectKind::duplicate_facet:
      return "duplicate facet";
    case DefectKind::degenerate_facet:
      return "degenerate facet";
  }
  return {};
}

std::string doubt_about_unit(const Box& box, const std::string& unit) {
  constexpr double smallest = 1e-3, largest = 100;  // [m] of a link that somebody would load
  const double diagonal = box.diagonal().norm();
  if (diagonal >= smallest && diagonal <= largest) return {};
  return fmt::format("the part would be {:.3g} m across: is the unit of its file {}?", diagonal,
                     unit);
}

std::string cure(DefectKind kind) {
  switch (kind) {
    case DefectKind::open_edge:
      return "Close the surface in the CAD program (fill the hole, sew the faces) and export again";
    case DefectKind::non_manifold_edge:
      return "Unite the bodies that touch along the edge, or remove inner walls";
    case DefectKind::inconsistent_orientation:
      return "Make the facet normals agree (\"unify normals\") and export again";
    case DefectKind::inside_out:
      return "Reverse all facet normals of that shell: out of the material, also in a cavity";
    case DefectKind::self_intersection:
      return "Unite overlapping bodies in the CAD program, or export with a finer tolerance";
    case DefectKind::duplicate_facet:
      return "Remove the facets that are there twice";
    case DefectKind::degenerate_facet:
      return "Harmless unless meshing fails; then export with a coarser tolerance";
  }
  return {};
}

bool SurfaceReport::sound() const {
  return std::all_of(defects.begin(), defects.end(), [](const Defect& defect) {
    return defect.kind == DefectKind::degenerate_facet;
  });
}

int SurfaceReport::bodies() const {
  return static_cast<int>(
      std::count_if(shells.begin(), shells.end(), [](const Shell& s) { return s.depth % 2 == 0; }));
}

int SurfaceReport::cavities() const { return static_cast<int>(shells.size()) - bodies(); }

SurfaceReport check_surface(const SurfaceMesh& mesh, double tolerance) {
  SurfaceReport report{.facets = mesh.triangles.size(),
                       .points = mesh.points.size(),
                       .box = bounding_box(mesh.points),
                       .tolerance = tolerance};
  const std::vector<EdgeUse> uses = edge_uses(mesh);
  find_edge_defects(uses, report);
  FlippedFacets flipped = flipped_facets(mesh.triangles.size(), uses);
  add_defect(report, DefectKind::inconsistent_orientation, std::move(flipped.facets),
             flipped.edges);
  report.shells = nested_shells(mesh, uses);
  find_inside_out(report);
  find_intersections(mesh, report);
  find_duplicates(mesh, report);
  find_degenerate(mesh, report);
  report.area = area_of(mesh);
  for (const Shell& shell : report.shells) report.volume += shell.volume;
  return report;
}

std::vector<std::string> describe(const SurfaceReport& report, const std::string& unit,
                                  double density) {
  const double length = spatial::parse_quantity("1 " + unit, spatial::dimension::length);
  const Vector3 low = report.box.min() / length, high = report.box.max() / length;
  std::vector<std::string> lines{
      fmt::format("{} facets, {} points", report.facets, report.points),
      fmt::format("bounding box [{:.6g}, {:.6g}, {:.6g}] to [{:.6g}, {:.6g}, {:.6g}] {}", low.x(),
                  low.y(), low.z(), high.x(), high.y(), high.z(), unit),
      fmt::format("area {:.6g} {}^2", report.area / (length * length), unit),
      fmt::format("{} {}, {} {}", report.bodies(), report.bodies() == 1 ? "body" : "bodies",
                  report.cavities(), report.cavities() == 1 ? "cavity" : "cavities")};
  if (const std::string doubt = doubt_about_unit(report.box, unit); !doubt.empty())
    lines.push_back("warning: " + doubt);
  if (report.sound()) {
    lines.push_back(fmt::format("volume {:.6g} {}^3", report.volume / std::pow(length, 3), unit));
    if (density > 0) lines.push_back(fmt::format("mass {:.6g} kg", report.volume * density));
    lines.emplace_back("closed, manifold, consistently oriented, free of self-intersections");
  }
  for (const Defect& defect : report.defects)
    lines.push_back(fmt::format("{}: {}. {}", what_is_counted(defect), facet_list(defect.facets),
                                cure(defect.kind)));
  return lines;
}

io::VtuGrid offending_facets(const SurfaceMesh& mesh, const SurfaceReport& report) {
  std::vector<int> facets;
  for (const Defect& defect : report.defects)
    facets.insert(facets.end(), defect.facets.begin(), defect.facets.end());
  std::sort(facets.begin(), facets.end());
  facets.erase(std::unique(facets.begin(), facets.end()), facets.end());
  io::VtuGrid grid;
  io::VtuField number{.name = "facet"};
  for (const int f : facets) {
    number.values.push_back(f + 1);
    for (std::size_t k = 0; k < 3; ++k) {
      grid.connectivity.push_back(static_cast<int>(grid.connectivity.size()));
      const Vector3& p = mesh.corner(at(f), k);
      grid.points.insert(grid.points.end(), {p.x(), p.y(), p.z()});
    }
  }
  grid.cell_fields.push_back(std::move(number));
  for (const Defect& defect : report.defects) {
    io::VtuField flag{.name = name(defect.kind)};
    for (const int f : facets)
      flag.values.push_back(std::binary_search(defect.facets.begin(), defect.facets.end(), f) ? 1
                                                                                              : 0);
    grid.cell_fields.push_back(std::move(flag));
  }
  return grid;
}

}  // namespace kinetostat::fea

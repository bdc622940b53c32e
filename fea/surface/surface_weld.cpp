#include "kinetostat/fea/surface/surface_weld.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/surface/box_tree.h"
#include "kinetostat/fea/surface/surface_topology.h"

namespace kinetostat::fea {
namespace {

using common::at;

// Sides that no other facet has.
std::vector<EdgeUse> open_edges(const SurfaceMesh& mesh) {
  std::vector<EdgeUse> open;
  for_each_edge(edge_uses(mesh), [&open](auto first, auto last) {
    if (last - first == 1) open.push_back(*first);
  });
  return open;
}

std::vector<int> corners_of(const std::vector<EdgeUse>& edges) {
  std::vector<int> corners;
  for (const EdgeUse& edge : edges) corners.insert(corners.end(), {edge.low, edge.high});
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  return corners;
}

bool has_collapsed(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

std::size_t drop_collapsed(SurfaceMesh& mesh) {
  std::vector<int> kept(mesh.triangles.size(), -1);
  int count = 0;
  for (std::size_t f = 0; f < kept.size(); ++f)
    if (!has_collapsed(mesh.triangles[f])) kept[f] = count++;
  const std::size_t dropped = kept.size() - at(count);
  if (dropped > 0) keep_facets(mesh, kept);
  return dropped;
}

std::size_t join_corners(SurfaceMesh& mesh, double tolerance) {
  const std::vector<int> corners = corners_of(open_edges(mesh));
  std::vector<Vector3> points;
  points.reserve(corners.size());
  for (const int c : corners) points.push_back(mesh.points[at(c)]);
  const std::vector<int> place = merge_near(points, tolerance);
  std::vector<int> first(points.size(), -1), number(mesh.points.size());
  std::iota(number.begin(), number.end(), 0);
  std::size_t joined = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    int& keeper = first[at(place[i])];
    if (keeper < 0) keeper = corners[i];
    if (keeper != corners[i]) ++joined;
    number[at(corners[i])] = keeper;
  }
  for (Triangle& t : mesh.triangles)
    for (int& corner : t) corner = number[at(corner)];
  return joined;
}

// The corners of open edges that lie on an open edge they do not end, by how far along they lie.
std::vector<std::pair<double, int>> corners_on(const SurfaceMesh& mesh, const EdgeUse& edge,
                                               const std::vector<int>& corners,
                                               const BoxTree& corner_tree, double tolerance) {
  const Vector3 &a = mesh.points[at(edge.low)], &b = mesh.points[at(edge.high)];
  const double length = (b - a).norm();
  const Vector3 direction = (b - a) / length;
  Box box(a.cwiseMin(b), a.cwiseMax(b));
  box.min().array() -= tolerance;
  box.max().array() += tolerance;
  std::vector<std::pair<double, int>> found;
  corner_tree.visit_overlapping(box, [&](int i) {
    const int corner = corners[at(i)];
    const Vector3 arm = mesh.points[at(corner)] - a;
    const double along = arm.dot(direction);
    if (corner == edge.low || corner == edge.high || along <= tolerance ||
        along >= length - tolerance || (arm - along * direction).norm() > tolerance)
      return;
    const Triangle& own = mesh.triangles[at(edge.facet)];
    if (std::find(own.begin(), own.end(), corner) != own.end()) return;
    found.emplace_back(along, corner);
  });
  std::sort(found.begin(), found.end());
  return found;
}

// Fans out the facet behind an open edge to the corners that lie on it.
void split(SurfaceMesh& mesh, const EdgeUse& edge, std::vector<std::pair<double, int>> corners,
           std::vector<std::vector<int>>& groups_of) {
  const Triangle whole = mesh.triangles[at(edge.facet)];
  const auto side = at(edge.side);
  const int tip = whole[(side + 2) % 3];
  if (!edge.forward) std::reverse(corners.begin(), corners.end());
  int from = whole[side];
  mesh.triangles[at(edge.facet)] = {from, corners.front().second, tip};
  from = corners.front().second;
  for (std::size_t i = 1; i <= corners.size(); ++i) {
    const int to = i < corners.size() ? corners[i].second : whole[(side + 1) % 3];
    mesh.triangles.push_back({from, to, tip});
    groups_of.push_back(groups_of[at(edge.facet)]);
    from = to;
  }
}

std::vector<std::vector<int>> groups_by_facet(const SurfaceMesh& mesh) {
  std::vector<std::vector<int>> groups_of(mesh.triangles.size());
  for (std::size_t g = 0; g < mesh.groups.size(); ++g)
    for (const int f : mesh.groups[g].facets) groups_of[at(f)].push_back(static_cast<int>(g));
  return groups_of;
}

// One open edge a facet; what that leaves is for the next pass.
void set_groups(SurfaceMesh& mesh, const std::vector<std::vector<int>>& groups_of) {
  for (FacetGroup& group : mesh.groups) group.facets.clear();
  for (std::size_t f = 0; f < groups_of.size(); ++f)
    for (const int g : groups_of[f]) mesh.groups[at(g)].facets.push_back(static_cast<int>(f));
}

std::size_t split_once(SurfaceMesh& mesh, double tolerance) {
  const std::vector<EdgeUse> edges = open_edges(mesh);
  const std::vector<int> corners = corners_of(edges);
  std::vector<Box> boxes;
  boxes.reserve(corners.size());
  for (const int c : corners) boxes.emplace_back(mesh.points[at(c)]);
  const BoxTree tree(std::move(boxes));
  std::vector<std::vector<int>> groups_of = groups_by_facet(mesh);
  std::vector<bool> touched(mesh.triangles.size(), false);
  std::size_t count = 0;
  for (const EdgeUse& edge : edges) {
    if (touched[at(edge.facet)]) continue;
    auto found = corners_on(mesh, edge, corners, tree, tolerance);
    if (found.empty()) continue;
    touched[at(edge.facet)] = true;
    split(mesh, edge, std::move(found), groups_of);
    ++count;
  }
  set_groups(mesh, groups_of);
  return count;
}

// The facets of each triple of corners that has several.
std::vector<std::vector<int>> repeated_facets(const SurfaceMesh& mesh) {
  std::map<Triangle, std::vector<int>> same;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    Triangle t = mesh.triangles[f];
    std::sort(t.begin(), t.end());
    same[t].push_back(static_cast<int>(f));
  }
  std::vector<std::vector<int>> repeated;
  for (auto& [corners, facets] : same)
    if (facets.size() > 1) repeated.push_back(std::move(facets));
  return repeated;
}

// Which triples belong to a wall: facets seen from both sides, in a patch around which the single
// facets close the surface without it.
std::vector<bool> walls(const SurfaceMesh& mesh, const std::vector<std::vector<int>>& copies) {
  std::vector<int> triple_of(mesh.triangles.size(), -1);
  for (std::size_t i = 0; i < copies.size(); ++i)
    for (const int f : copies[i]) triple_of[at(f)] = static_cast<int>(i);
  std::vector<int> parent(copies.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&parent](int i) {
    while (parent[at(i)] != i) i = parent[at(i)] = parent[at(parent[at(i)])];
    return i;
  };
  std::vector<bool> bordered(copies.size(), false), odd(copies.size(), false);
  for_each_edge(edge_uses(mesh), [&](auto first, auto last) {
    int triple = -1, singles = 0;
    for (auto use = first; use != last; ++use) {
      const int own = triple_of[at(use->facet)];
      if (own < 0) {
        ++singles;
      } else {
        if (triple >= 0) parent[at(root(own))] = root(triple);
        triple = own;
      }
    }
    if (triple < 0) return;
    if (singles > 0) bordered[at(triple)] = true;
    if (singles % 2 == 1) odd[at(triple)] = true;
  });
  std::vector<bool> good(copies.size(), true), has_border(copies.size(), false);
  for (std::size_t i = 0; i < copies.size(); ++i) {
    const auto patch = at(root(static_cast<int>(i)));
    if (odd[i] || copies[i].size() % 2 == 1) good[patch] = false;
    if (bordered[i]) has_border[patch] = true;
  }
  std::vector<bool> result(copies.size());
  for (std::size_t i = 0; i < copies.size(); ++i) {
    const auto patch = at(root(static_cast<int>(i)));
    result[i] = good[patch] && has_border[patch];
  }
  return result;
}

}  // namespace

std::size_t remove_repeated_facets(SurfaceMesh& mesh) {
  const std::vector<std::vector<int>> copies = repeated_facets(mesh);
  if (copies.empty()) return 0;
  const std::vector<bool> is_wall = walls(mesh, copies);
  std::vector<int> kept(mesh.triangles.size(), 0);
  for (std::size_t i = 0; i < copies.size(); ++i)
    for (std::size_t k = is_wall[i] ? 0 : 1; k < copies[i].size(); ++k) kept[at(copies[i][k])] = -1;
  int count = 0;
  for (int& number : kept)
    if (number >= 0) number = count++;
  const std::size_t removed = kept.size() - at(count);
  keep_facets(mesh, kept);
  return removed;
}

EdgeWeldReport weld_open_edges(SurfaceMesh& mesh, double tolerance) {
  EdgeWeldReport report;
  report.joined = join_corners(mesh, tolerance);
  report.removed = drop_collapsed(mesh);
  constexpr int most_passes = 8;
  for (int pass = 0; pass < most_passes; ++pass) {
    const std::size_t count = split_once(mesh, tolerance);
    if (count == 0) break;
    report.split += count;
  }
  report.removed += remove_repeated_facets(mesh);
  drop_unused_points(mesh);
  return report;
}

}  // namespace kinetostat::fea

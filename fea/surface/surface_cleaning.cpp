#include "kinetostat/fea/surface/surface_cleaning.h"

#include <algorithm>
#include <set>
#include <utility>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/surface/surface_check.h"
#include "kinetostat/fea/surface/surface_topology.h"
#include "kinetostat/fea/surface/surface_weld.h"

namespace kinetostat::fea {
namespace {

using common::at;

// Tags ride along as groups, which every operation on a surface keeps.
SurfaceMesh with_tags_as_groups(const SurfaceMesh& surface, const std::vector<int>& tags) {
  SurfaceMesh mesh{.points = surface.points, .triangles = surface.triangles};
  const int last = *std::max_element(tags.begin(), tags.end());
  for (int tag = 0; tag <= last; ++tag) {
    FacetGroup group{.name = std::to_string(tag), .facets = {}};
    for (std::size_t f = 0; f < tags.size(); ++f)
      if (tags[f] == tag) group.facets.push_back(static_cast<int>(f));
    mesh.groups.push_back(std::move(group));
  }
  return mesh;
}

std::vector<int> tags_of(const SurfaceMesh& mesh) {
  std::vector<int> tags(mesh.triangles.size(), 0);
  for (const FacetGroup& group : mesh.groups)
    for (const int f : group.facets) tags[at(f)] = std::stoi(group.name);
  return tags;
}

// The side opposite the least height, and that height [m].
std::pair<std::size_t, double> longest_side(const SurfaceMesh& mesh, std::size_t f) {
  std::size_t longest = 0;
  double length = 0;
  for (std::size_t k = 0; k < 3; ++k)
    if (const double side = (mesh.corner(f, (k + 1) % 3) - mesh.corner(f, k)).norm();
        side > length) {
      length = side;
      longest = k;
    }
  return {longest, 2 * mesh.area_vector(f).norm() / length};
}

// Turns the longest side of thin facets into the other diagonal of the two facets beside it.
std::size_t flip_caps(SurfaceMesh& mesh, std::vector<int>& tags, double tolerance) {
  const std::vector<Triangle> neighbours = facet_neighbours(mesh);
  std::set<std::pair<int, int>> edges;
  for (const EdgeUse& use : edge_uses(mesh)) edges.insert({use.low, use.high});
  std::vector<bool> touched(mesh.triangles.size(), false);
  std::size_t count = 0;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const auto [side, height] = longest_side(mesh, f);
    const int other = neighbours[f][side];
    if (height >= tolerance || other < 0 || touched[f] || touched[at(other)]) continue;
    const Triangle t = mesh.triangles[f], u = mesh.triangles[at(other)];
    const int a = t[side], b = t[(side + 1) % 3], c = t[(side + 2) % 3];
    const auto apex = std::find_if(u.begin(), u.end(), [&](int p) { return p != a && p != b; });
    if (apex == u.end() || *apex == c || !edges.insert(std::minmax(c, *apex)).second) continue;
    mesh.triangles[f] = {a, *apex, c};
    mesh.triangles[at(other)] = {*apex, b, c};
    tags[f] = tags[at(other)];
    for (const int near :
         {neighbours[f][0], neighbours[f][1], neighbours[f][2], neighbours[at(other)][0],
          neighbours[at(other)][1], neighbours[at(other)][2]})
      if (near >= 0) touched[at(near)] = true;
    ++count;
  }
  return count;
}

}  // namespace

std::optional<CleanSurface> without_thin_facets(const SurfaceMesh& surface,
                                                const std::vector<int>& tags, double tolerance) {
  if (tags.empty()) return {};
  SurfaceMesh mesh = with_tags_as_groups(surface, tags);
  constexpr int most_passes = 20;
  std::size_t flipped = 0;
  for (int pass = 0; pass < most_passes; ++pass) {
    weld(mesh, tolerance);
    remove_repeated_facets(mesh);
    if (mesh.triangles.empty()) return {};
    std::vector<int> now = tags_of(mesh);
    const std::size_t count = flip_caps(mesh, now, tolerance);
    mesh = with_tags_as_groups(mesh, now);
    flipped += count;
    if (count == 0) break;
  }
  const bool unchanged = flipped == 0 && mesh.triangles.size() == surface.triangles.size();
  if (unchanged || !check_surface(mesh, weld_tolerance(mesh.points)).sound()) return {};
  std::vector<int> result_tags = tags_of(mesh);
  mesh.groups.clear();
  return CleanSurface{std::move(mesh), std::move(result_tags)};
}

}  // namespace kinetostat::fea

#include "kinetostat/fea/surface/surface_topology.h"

#include <algorithm>
#include <tuple>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {

using common::at;

std::vector<EdgeUse> edge_uses(const SurfaceMesh& mesh) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * mesh.triangles.size());
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    for (std::size_t side = 0; side < 3; ++side) {
      const int a = mesh.triangles[f][side], b = mesh.triangles[f][(side + 1) % 3];
      uses.push_back(
          {std::min(a, b), std::max(a, b), static_cast<int>(f), static_cast<int>(side), a < b});
    }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& x, const EdgeUse& y) {
    return std::tie(x.low, x.high, x.facet, x.side) < std::tie(y.low, y.high, y.facet, y.side);
  });
  return uses;
}

std::vector<Triangle> facet_neighbours(const SurfaceMesh& mesh) {
  std::vector<Triangle> neighbours(mesh.triangles.size(), Triangle{-1, -1, -1});
  for_each_edge(edge_uses(mesh), [&neighbours](auto first, auto last) {
    if (last - first != 2) return;
    const EdgeUse &a = first[0], &b = first[1];
    neighbours[at(a.facet)][at(a.side)] = b.facet;
    neighbours[at(b.facet)][at(b.side)] = a.facet;
  });
  return neighbours;
}

}  // namespace kinetostat::fea

// Which facets meet at which edge.
#pragma once

#include <vector>

#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

/// One side of one facet, as an undirected edge between the points low < high.
struct EdgeUse {
  int low, high;
  int facet, side;  // the edge runs from corner `side` to corner (side + 1) % 3
  bool forward;     // the facet runs along it from low to high
};

/// All sides of all facets, those of the same edge one after the other, in order of facet.
std::vector<EdgeUse> edge_uses(const SurfaceMesh& mesh);

/// Calls visit(first, last) for every edge with its range of uses.
template <class Visit>
void for_each_edge(const std::vector<EdgeUse>& uses, Visit visit) {
  for (auto first = uses.begin(); first != uses.end();) {
    auto last = first + 1;
    while (last != uses.end() && last->low == first->low && last->high == first->high) ++last;
    visit(first, last);
    first = last;
  }
}

/// For each facet, the facet across each of its three sides; -1 where not exactly two facets meet.
std::vector<Triangle> facet_neighbours(const SurfaceMesh& mesh);

}  // namespace kinetostat::fea

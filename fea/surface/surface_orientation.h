// Which way the facets of a surface face, and which shell lies within which.
#pragma once

#include <cstddef>
#include <vector>

#include "kinetostat/fea/surface/surface_mesh.h"
#include "kinetostat/fea/surface/surface_topology.h"

namespace kinetostat::fea {

/// Facets connected over edges.
struct Shell {
  std::vector<int> facets;
  double volume = 0;  // [m^3], negative when the facets face inwards
  Box box;
  int depth = 0;  // number of shells around it: odd is a cavity, even a body
};

/// Facets that face the other way than their neighbours: the smaller party of each shell.
struct FlippedFacets {
  std::vector<int> facets = {};  // in no order, some twice on a one-sided shell
  std::size_t edges = 0;         // across which neighbours disagree
};
FlippedFacets flipped_facets(std::size_t facet_count, const std::vector<EdgeUse>& uses);

/// The shells in the order of their first facets. Volume and depth mean something for closed ones.
std::vector<Shell> nested_shells(const SurfaceMesh& mesh, const std::vector<EdgeUse>& uses);

/// Turns facets so that each shell agrees with itself and the outermost ones enclose positive
/// volume; a shell within one that had to be turned as a whole is turned too where its volume says
/// so. A shell that faces outwards within another stays: whether it is a cavity or a body of its
/// own cannot be known. Returns how many facets were turned.
std::size_t orient_outward(SurfaceMesh& mesh);

}  // namespace kinetostat::fea

// Seams of a surface closed without new facets.
#pragma once

#include <cstddef>

#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

struct EdgeWeldReport {
  std::size_t joined = 0;   // corners that became one with another
  std::size_t split = 0;    // open edges that took in a corner lying on them
  std::size_t removed = 0;  // facets that were there twice or collapsed
};

/// Joins corners of open edges nearer to one another than `tolerance` [m], splits open edges at
/// corners of other open edges within `tolerance` of them, then remove_repeated_facets(). Where the
/// surface is closed no point moves.
EdgeWeldReport weld_open_edges(SurfaceMesh& mesh, double tolerance);

/// Keeps one of the facets with the same three corners; none when the facets around close the
/// surface without them, as at the wall between two bodies that share a face. Returns how many
/// went.
std::size_t remove_repeated_facets(SurfaceMesh& mesh);

}  // namespace kinetostat::fea

// A plane region with straight sides as triangles of good shape.
#pragma once

#include <stdexcept>

#include "kinetostat/fea/section/section_outline.h"

namespace kinetostat::fea {

/// The region cannot be filled: its outline crosses itself, or is too intricate.
class SectionError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct SectionMesh {
  std::vector<Vector2> points;      // [m]
  std::vector<Triangle> triangles;  // counterclockwise
};

/// Fills one piece with a Delaunay triangulation that keeps its sides: no edge much longer than
/// `size` [m], angles above 20 degrees except where the outline itself is narrower (Ruppert 1995).
/// Points lie on a grid of 2^-26 of the extent, which makes all decisions exact. The same input
/// gives the same mesh. Throws SectionError.
SectionMesh triangulate(const SectionPiece& piece, double size);

}  // namespace kinetostat::fea

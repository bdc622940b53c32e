// Defects that exporters, decimators and careless modelling put into a good surface. Lengths in the
// unit of the surface. Everything is repeatable: randomness comes from a seed.
#pragma once

#include <cstdint>

#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea::hard {

/// The same numbers everywhere (Steele, Lea and Flood 2014, SplitMix64).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform(double low, double high);
  std::size_t below(std::size_t n);

 private:
  std::uint64_t next();
  std::uint64_t state_;
};

// -- The surface stays closed ---------------------------------------------------------------------

/// Each facet becomes four.
SurfaceMesh subdivided(const SurfaceMesh& mesh);
/// Divides `count` edges at `part` of their length from one end: two facets in four are slivers.
void add_slivers(SurfaceMesh& mesh, int count, double part, Random& random);
/// Puts points into facets, `part` of the height away from a side: needles along it.
void add_needles(SurfaceMesh& mesh, int count, double part, Random& random);
/// Moves every point by up to `size` in each direction.
void add_noise(SurfaceMesh& mesh, double size, Random& random);
/// Divides edges, and moves the new points along them past the end by `size`: folded slivers.
void add_folds(SurfaceMesh& mesh, int count, double size, Random& random);
/// Rounds coordinates to single precision, as a binary STL file does.
void round_to_single(SurfaceMesh& mesh);
/// Collapses edges by the quadric error [Garland and Heckbert 1997] down to `facets`, as far as no
/// facet turns over and the error stays below `most`. Points with x at the ends of the box stay.
SurfaceMesh decimated(const SurfaceMesh& mesh, std::size_t facets, double most);

// -- It does not ----------------------------------------------------------------------------------

/// Every facet with corners of its own, each off by up to `error`.
SurfaceMesh soup(const SurfaceMesh& mesh, double error, Random& random);
/// Leaves out `count` facets, none of them at an end in x, each with its neighbours `rings` wide.
void remove_facets(SurfaceMesh& mesh, int count, int rings, Random& random);
void flip_facets(SurfaceMesh& mesh, double share, Random& random);
void repeat_facets(SurfaceMesh& mesh, double share, Random& random);
/// Divides the edge of one facet only, leaving its neighbour with a corner on its side.
void add_t_junctions(SurfaceMesh& mesh, int count, Random& random);
/// Separates the facets along the plane through `x` by `gap`.
void add_crack(SurfaceMesh& mesh, double x, double gap);
/// Pushes `count` points inwards by `depth`, through what lies behind them.
void push_points(SurfaceMesh& mesh, int count, double depth, Random& random);

}  // namespace kinetostat::fea::hard

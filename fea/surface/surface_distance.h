// How far two surfaces are apart, and what a surface encloses.
#pragma once

#include <optional>

#include "kinetostat/fea/surface/box_tree.h"
#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

/// The nearest point of a surface, which must outlive this.
class SurfaceLocator {
 public:
  explicit SurfaceLocator(const SurfaceMesh& mesh);

  struct Place {
    int facet = -1;
    Vector3 point;
    double distance = 0;  // [m]
  };
  /// Requires a surface with facets.
  Place nearest(const Vector3& point) const;
  /// Distance of a point from one facet [m].
  double distance(const Vector3& point, int facet) const;

 private:
  const SurfaceMesh& mesh_;
  BoxTree tree_;
};

/// The largest distance [m] of a point of `from` from the surface of `to`: one side of Hausdorff's
/// distance, exact where pieces of `from` longer than `spacing` [m] decide it.
double farthest_distance(const SurfaceMesh& from, const SurfaceLocator& to, double spacing);

/// The volume [m^3] of what the facets wind around, so that overlaps count once, by columns^2
/// parallel rays. None when the surface is so open or so twisted that more than a fiftieth of the
/// rays leave it more or less often than they enter it.
std::optional<double> enclosed_volume(const SurfaceMesh& mesh, int columns = 300);

}  // namespace kinetostat::fea

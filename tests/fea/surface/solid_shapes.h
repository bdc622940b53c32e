// Closed surfaces of machine parts for the corpus of hard meshes (hard_surfaces.h): the shapes as a
// careful exporter would write them. Lengths in [mm]; facets look outwards.
#pragma once

#include <functional>
#include <vector>

#include "kinetostat/fea/surface/surface_mesh.h"

#include "fea/shapes.h"

namespace kinetostat::fea::hard {

using Point2 = Eigen::Vector2d;
using Outline = std::vector<Point2>;  // counterclockwise, closed by itself

/// Regular polygon on a circle.
Outline circle(const Point2& centre, double radius, int sides);
/// A rectangle from `low` to `high` whose corners are rounded by `segments` chords each.
Outline rounded_rectangle(const Point2& low, const Point2& high, double radius, int segments);
/// A strip of constant width along an open polyline: the section of bent sheet metal. Ends are cut
/// square.
Outline strip(const std::vector<Point2>& middle, double width);

/// The prism of an outline with holes (counterclockwise as well) from z = 0 to `height`, `layers`
/// quads high. Its caps are cut into ears between the given corners, as CAD exporters do, which
/// leaves needles.
SurfaceMesh prism(const Outline& outline, const std::vector<Outline>& holes, double height,
                  int layers = 1);

/// A closed profile (x, r), counterclockwise in that plane, turned about the x axis; points with
/// r = 0 become one.
SurfaceMesh revolved(const Outline& profile, int sides);

/// Rings of `around` points outside and inside, at `along` + 1 stations from 0 to 1, closed by an
/// annulus at both ends.
using Ring = std::function<Vector3(double station, double angle)>;
SurfaceMesh lofted_shell(const Ring& outer, const Ring& inner, int around, int along);

/// The cells of a grid with lines at `x`, `y`, `z` that `is_full` says of, by the middle of a cell.
/// Every side between a full and an empty cell is two facets.
SurfaceMesh cells(const std::vector<double>& x, const std::vector<double>& y,
                  const std::vector<double>& z, const std::function<bool(const Vector3&)>& is_full);
/// `cells` on the lines of some boxes: their union.
SurfaceMesh union_of(const std::vector<Box>& boxes);

/// An icosahedron that looks outwards.
SurfaceMesh icosahedron(const Vector3& centre, double radius);

/// Exchanges coordinates: (x, y, z) -> (y, z, x).
SurfaceMesh turned(SurfaceMesh mesh);

}  // namespace kinetostat::fea::hard

// The closed curves in which a plane cuts a surface.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "kinetostat/fea/surface/surface_mesh.h"
#include "kinetostat/spatial/wrench_twist.h"

namespace kinetostat::fea {

using Vector2 = Eigen::Vector2d;
using Matrix2 = Eigen::Matrix2d;

/// A closed polygon [m]: counterclockwise around material, clockwise around a hole.
using Loop = std::vector<Vector2>;

/// Twice the signed area gives the sense: positive when counterclockwise [m^2].
double signed_area(const Loop& loop);

/// Even-odd rule over all loops; points on an edge may count either way.
bool inside(const std::vector<Loop>& loops, const Vector2& p);

/// A piece of a section: one outer loop and the holes in it.
struct SectionPiece {
  std::vector<Loop> loops;  // the outer one first
};

/// A plane frame whose first axis is normal to the plane; the second and third are y and z of the
/// plane. `tangent` need not be of unit length. The y axis is the one nearest to `up` (another when
/// `up` is along the tangent), so that frames along a curve turn smoothly.
spatial::Frame section_frame(const Vector3& point, const Vector3& tangent, const Vector3& up);

/// Cuts the surface with the plane y-z of the frame, coordinates in that plane. Corners that lie on
/// the plane count as above it, so that on a closed surface the loops always close. Corners nearer
/// to their neighbours than `tolerance` [m], or nearer to the line between them, are left out; so
/// are loops that have no area then.
std::vector<Loop> cut(const SurfaceMesh& surface, const spatial::Frame& frame, double tolerance);

/// Gives each hole to the smallest outer loop around it. Holes outside every outer loop are
/// dropped.
std::vector<SectionPiece> pieces(const std::vector<Loop>& loops);

}  // namespace kinetostat::fea

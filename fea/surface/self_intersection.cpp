#include "kinetostat/fea/surface/self_intersection.h"

#include <algorithm>
#include <array>
#include <limits>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/surface/box_tree.h"

namespace kinetostat::fea {
namespace {

using common::at;

// A triangle as its plane and the three lines that bound it there.
struct FlatTriangle {
  std::array<Vector3, 3> corner;
  Vector3 normal;
  std::array<Vector3, 3> inward;  // in the plane, unit, at the side from corner k to k + 1
  double height = 0;              // smallest [m]

  explicit FlatTriangle(const std::array<Vector3, 3>& corners) : corner(corners) {
    const Vector3 area = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k)
      longest = std::max(longest, (corner[(k + 1) % 3] - corner[k]).norm());
    if (!(longest > 0)) return;
    height = area.norm() / longest;
    normal = area.normalized();
    for (std::size_t k = 0; k < 3; ++k)
      inward[k] = normal.cross(corner[(k + 1) % 3] - corner[k]).normalized();
  }

  double above(const Vector3& p) const { return normal.dot(p - corner[0]); }
  // How far inside the three sides a point of the plane is; negative outside.
  double depth(const Vector3& p) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k) least = std::min(least, inward[k].dot(p - corner[k]));
    return least;
  }
};

struct Tolerances {
  double plane;    // points this near to a plane are in it
  double contact;  // shallower contacts do not count
};

// A segment in the plane of the triangle: does a piece of it lie deeper inside than the tolerance?
bool runs_inside(const FlatTriangle& t, const Vector3& p, const Vector3& q, double tolerance) {
  double from = 0, to = 1;
  for (std::size_t k = 0; k < 3; ++k) {
    const double a = t.inward[k].dot(p - t.corner[k]) - tolerance;
    const double b = t.inward[k].dot(q - t.corner[k]) - tolerance;
    if (a <= 0 && b <= 0) return false;
    if (a < 0) from = std::max(from, a / (a - b));
    if (b < 0) to = std::min(to, a / (a - b));
  }
  return from < to;
}

bool segment_meets(const FlatTriangle& t, const Vector3& p, const Vector3& q,
                   const Tolerances& tolerance) {
  const double a = t.above(p), b = t.above(q), flat = tolerance.plane;
  if ((a > flat && b > flat) || (a < -flat && b < -flat)) return false;
  const bool p_in_plane = std::abs(a) <= flat, q_in_plane = std::abs(b) <= flat;
  if (p_in_plane && q_in_plane) return runs_inside(t, p, q, tolerance.contact);
  if (p_in_plane) return t.depth(p) > tolerance.contact;
  if (q_in_plane) return t.depth(q) > tolerance.contact;
  if (std::min(std::abs(a), std::abs(b)) < tolerance.contact) return false;
  return t.depth(p + (q - p) * (a / (a - b))) > -flat;
}

// Corners of a that are corners of b too, by number.
int common_corners(const Triangle& a, const Triangle& b, std::array<bool, 3>& shared) {
  int count = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    shared[k] = std::find(b.begin(), b.end(), a[k]) != b.end();
    count += shared[k] ? 1 : 0;
  }
  return count;
}

// Does a side of a that has no corner in common with b meet b?
bool sides_meet(const FlatTriangle& a, const std::array<bool, 3>& shared, const FlatTriangle& b,
                const Tolerances& tolerance) {
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    if (shared[k] || shared[next]) continue;
    if (segment_meets(b, a.corner[k], a.corner[next], tolerance)) return true;
  }
  return false;
}

// Two facets with a common side: is the third corner of one in the other's plane and on its side?
bool folded(const FlatTriangle& a, const std::array<bool, 3>& shared, const FlatTriangle& b,
            const std::array<bool, 3>& shared_b, const Tolerances& tolerance) {
  const std::size_t free_a = !shared[0] ? 0 : !shared[1] ? 1 : 2;
  const std::size_t free_b = !shared_b[0] ? 0 : !shared_b[1] ? 1 : 2;
  const Vector3& tip = b.corner[free_b];
  const std::size_t side = (free_a + 1) % 3;
  return std::abs(a.above(tip)) <= tolerance.plane &&
         a.inward[side].dot(tip - a.corner[side]) > tolerance.contact;
}

bool meet(const SurfaceMesh& mesh, const std::vector<FlatTriangle>& flat, std::size_t f,
          std::size_t g, const Tolerances& tolerance) {
  std::array<bool, 3> shared_f{}, shared_g{};
  const int common = common_corners(mesh.triangles[f], mesh.triangles[g], shared_f);
  common_corners(mesh.triangles[g], mesh.triangles[f], shared_g);
  if (common == 3) return false;  // a duplicate, not a crossing
  if (common == 2) return folded(flat[f], shared_f, flat[g], shared_g, tolerance);
  return sides_meet(flat[f], shared_f, flat[g], tolerance) ||
         sides_meet(flat[g], shared_g, flat[f], tolerance);
}

}  // namespace

SelfIntersections self_intersections(const SurfaceMesh& mesh, double tolerance, std::size_t limit) {
  const Box box = bounding_box(mesh.points);
  const Tolerances limits{.plane = 1e-9 * box.diagonal().norm(), .contact = tolerance};
  std::vector<FlatTriangle> flat;
  flat.reserve(mesh.triangles.size());
  // Around the centre of the box, so that a far origin costs no digits.
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    flat.emplace_back(std::array<Vector3, 3>{mesh.corner(f, 0) - box.center(),
                                             mesh.corner(f, 1) - box.center(),
                                             mesh.corner(f, 2) - box.center()});
  const std::vector<Box> boxes = facet_boxes(mesh, limits.plane);
  const BoxTree tree(boxes);
  SelfIntersections result;
  for (std::size_t f = 0; f < flat.size() && result.complete; ++f) {
    if (flat[f].height < tolerance) continue;
    tree.visit_overlapping(boxes[f], [&](int other) {
      const auto g = at(other);
      if (g <= f || flat[g].height < tolerance || !result.complete) return;
      if (!meet(mesh, flat, f, g, limits)) return;
      result.pairs.emplace_back(static_cast<int>(f), other);
      result.complete = result.pairs.size() < limit;
    });
  }
  std::sort(result.pairs.begin(), result.pairs.end());
  return result;
}

}  // namespace kinetostat::fea

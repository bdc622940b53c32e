#include "kinetostat/fea/surface/surface_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {
namespace {

using common::at;

// The nearest point of a triangle (Ericson, Real-Time Collision Detection, 2005, 5.1.5).
Vector3 nearest_of_triangle(const Vector3& p, const Vector3& a, const Vector3& b,
                            const Vector3& c) {
  const Vector3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const double sum = va + vb + vc;
  return a + vb / sum * ab + vc / sum * ac;
}

// The farthest point of triangles from a surface. A triangle is halved until it can hold no point
// farther than the farthest so far: the distance from one facet is convex, so that over a triangle
// it is largest at a corner, and no point is farther from the surface than from any of its facets.
class FarthestPoint {
 public:
  FarthestPoint(const SurfaceLocator& to, double spacing) : to_(to), spacing_(spacing) {}

  void search(const Vector3& a, const Vector3& b, const Vector3& c) {
    search({locate(a), locate(b), locate(c)});
  }
  double distance() const { return farthest_; }

 private:
  struct Corner {
    Vector3 point;
    SurfaceLocator::Place place;
  };

  Corner locate(const Vector3& point) {
    Corner corner{point, to_.nearest(point)};
    farthest_ = std::max(farthest_, corner.place.distance);
    return corner;
  }

  // Above the distance of every point of the triangle.
  double bound(const std::array<Corner, 3>& corners) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Corner& nearest : corners) {
      double largest = 0;
      for (const Corner& corner : corners)
        largest = std::max(largest, to_.distance(corner.point, nearest.place.facet));
      least = std::min(least, largest);
    }
    return least;
  }

  void search(const std::array<Corner, 3>& corners) {
    if (bound(corners) <= farthest_ + 1e-9 * spacing_) return;
    std::size_t side = 0;
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double length = (corners[(k + 1) % 3].point - corners[k].point).norm();
      if (length > longest) side = k;
      longest = std::max(longest, length);
    }
    const Corner &from = corners[side], &to = corners[(side + 1) % 3],
                 &tip = corners[(side + 2) % 3];
    if (longest <= spacing_) {
      locate((from.point + to.point + tip.point) / 3);
      return;
    }
    const Corner middle = locate(0.5 * (from.point + to.point));
    search({from, middle, tip});
    search({middle, to, tip});
  }

  const SurfaceLocator& to_;
  double spacing_;
  double farthest_ = 0;
};

// Where rays along z cross the surface, for a square of columns.
class Columns {
 public:
  Columns(const SurfaceMesh& mesh, int count) : count_(count), hits_(at(count) * at(count)) {
    // No direction that a designer would choose, so that no ray runs along a face.
    turn_ =
        Eigen::AngleAxisd(0.6180339887, Vector3(0.3, 0.5, 0.81).normalized()).toRotationMatrix();
    std::vector<Vector3> turned;
    for (const Vector3& p : mesh.points) turned.emplace_back(turn_ * p);
    const Box box = bounding_box(turned);
    low_ = box.min();
    step_ = box.sizes() / count;
    for (const Triangle& t : mesh.triangles)
      add(turned[at(t[0])], turned[at(t[1])], turned[at(t[2])]);
  }

  std::optional<double> volume() {
    double height = 0;
    std::size_t crossed = 0, unbalanced = 0;
    for (std::vector<Hit>& hits : hits_) {
      if (hits.empty()) continue;
      ++crossed;
      const double inside = length_inside(hits);
      if (inside < 0)
        ++unbalanced;
      else
        height += inside;
    }
    if (crossed == 0 || 50 * unbalanced > crossed) return {};
    // The few rays through holes are taken to be like the rest.
    return height * step_.x() * step_.y() * static_cast<double>(crossed) /
           static_cast<double>(crossed - unbalanced);
  }

 private:
  struct Hit {
    double z;
    int enters;  // 1 or -1, going up
  };
  void add(const Vector3& a, const Vector3& b, const Vector3& c) {
    const double area = (b - a).head<2>().x() * (c - a).y() - (b - a).y() * (c - a).x();
    if (area == 0) return;
    const auto first = [&](int k) {
      return std::max(0, static_cast<int>(
                             std::ceil((std::min({a[k], b[k], c[k]}) - low_[k]) / step_[k] - 0.5)));
    };
    const auto last = [&](int k) {
      return std::min(
          count_ - 1,
          static_cast<int>(std::floor((std::max({a[k], b[k], c[k]}) - low_[k]) / step_[k] - 0.5)));
    };
    for (int i = first(0); i <= last(0); ++i)
      for (int j = first(1); j <= last(1); ++j) {
        const double x = low_.x() + (i + 0.5) * step_.x() - a.x();
        const double y = low_.y() + (j + 0.5) * step_.y() - a.y();
        const double u = (x * (c - a).y() - y * (c - a).x()) / area;
        const double v = ((b - a).x() * y - (b - a).y() * x) / area;
        if (u < 0 || v < 0 || u + v > 1) continue;
        hits_[at(i) * at(count_) + at(j)].push_back(
            {a.z() + u * (b - a).z() + v * (c - a).z(), area < 0 ? 1 : -1});
      }
  }

  // -1 when the ray does not end outside.
  static double length_inside(std::vector<Hit>& hits) {
    std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return a.z < b.z; });
    int winding = 0;
    double length = 0;
    for (std::size_t i = 0; i < hits.size(); ++i) {
      winding += hits[i].enters;
      if (winding != 0 && i + 1 < hits.size()) length += hits[i + 1].z - hits[i].z;
    }
    return winding == 0 ? length : -1;
  }

  int count_;
  std::vector<std::vector<Hit>> hits_;
  Matrix3 turn_;
  Vector3 low_, step_;
};

}  // namespace

SurfaceLocator::SurfaceLocator(const SurfaceMesh& mesh)
    : mesh_(mesh), tree_(facet_boxes(mesh, 0)) {}

SurfaceLocator::Place SurfaceLocator::nearest(const Vector3& point) const {
  Place best;
  double least = std::numeric_limits<double>::infinity();
  tree_.visit_near(point, least, [&](int facet) {
    const auto f = at(facet);
    const Vector3 q =
        nearest_of_triangle(point, mesh_.corner(f, 0), mesh_.corner(f, 1), mesh_.corner(f, 2));
    const double squared = (q - point).squaredNorm();
    if (squared >= least) return;
    least = squared;
    best = {facet, q, std::sqrt(squared)};
  });
  return best;
}

double SurfaceLocator::distance(const Vector3& point, int facet) const {
  const auto f = at(facet);
  return (nearest_of_triangle(point, mesh_.corner(f, 0), mesh_.corner(f, 1), mesh_.corner(f, 2)) -
          point)
      .norm();
}

double farthest_distance(const SurfaceMesh& from, const SurfaceLocator& to, double spacing) {
  FarthestPoint farthest(to, spacing);
  for (std::size_t f = 0; f < from.triangles.size(); ++f)
    farthest.search(from.corner(f, 0), from.corner(f, 1), from.corner(f, 2));
  return farthest.distance();
}

std::optional<double> enclosed_volume(const SurfaceMesh& mesh, int columns) {
  return Columns(mesh, columns).volume();
}

}  // namespace kinetostat::fea

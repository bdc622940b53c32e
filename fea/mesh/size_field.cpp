#include "kinetostat/fea/mesh/size_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/surface/box_tree.h"
#include "kinetostat/fea/surface/surface_topology.h"

namespace kinetostat::fea {
namespace {

using common::at;

constexpr double thicknesses_per_element = 1.5;
constexpr double elements_per_diagonal = 10;
// Of the mean thickness: towards a sharp edge of the part the thickness falls to nothing.
constexpr double least_part = 0.25;
// Likewise of a radius: finer rounding is left to the refinement by errors.
constexpr double least_radius_part = 0.1;
constexpr double most_samples = 20000;
// On the surface, to start with: elements as small as a thin wall everywhere would be millions.
constexpr double most_triangles = 40000;
// Edges that turn by less belong to a curved face, not to two that meet in an edge of the part.
constexpr double most_turn = 0.6;  // [rad]

double regular_edge(double volume) { return std::cbrt(6 * std::sqrt(2.0) * volume); }

// How far the material reaches from a point of the surface along the inward normal.
class Thickness {
 public:
  explicit Thickness(const SurfaceMesh& surface)
      : surface_(surface), tree_(facet_boxes(surface, 0)) {}

  double at(std::size_t facet, const Vector3& point) const {
    const Vector3 direction = -surface_.area_vector(facet).normalized();
    double nearest = std::numeric_limits<double>::infinity();
    const auto touched = [&](const Box& box) { return enters(box, point, direction, nearest); };
    tree_.visit_if(touched, [&](int other) {
      if (common::at(other) != facet)
        nearest = std::min(nearest, ray_hit(surface_, common::at(other), point, direction));
    });
    return nearest;
  }

 private:
  // Slabs: does the ray meet the box before `limit`?
  static bool enters(const Box& box, const Vector3& from, const Vector3& direction, double limit) {
    double first = 0, last = limit;
    for (Eigen::Index k = 0; k < 3; ++k) {
      if (direction[k] == 0) {
        if (from[k] < box.min()[k] || from[k] > box.max()[k]) return false;
        continue;
      }
      const double a = (box.min()[k] - from[k]) / direction[k];
      const double b = (box.max()[k] - from[k]) / direction[k];
      first = std::max(first, std::min(a, b));
      last = std::min(last, std::max(a, b));
    }
    return first <= last;
  }

  const SurfaceMesh& surface_;
  BoxTree tree_;
};

// For each facet the smallest radius of curvature towards its neighbours, or infinity: the normal
// turns over the mean height of the two facets above their common side. Normals of facets that are
// hardly higher than the rounding of their corners tell nothing.
std::vector<double> curvature_radii(const SurfaceMesh& surface) {
  std::vector<double> radii(surface.triangles.size(), std::numeric_limits<double>::infinity());
  const std::vector<Triangle> neighbours = facet_neighbours(surface);
  const double rounding = weld_tolerance(surface.points);
  for (std::size_t f = 0; f < radii.size(); ++f)
    for (std::size_t side = 0; side < 3; ++side) {
      if (neighbours[f][side] < 0) continue;
      const Vector3 a = surface.area_vector(f);
      const Vector3 b = surface.area_vector(at(neighbours[f][side]));
      const double turn = std::atan2(a.cross(b).norm(), a.dot(b));
      if (turn < 1e-3 || turn > most_turn) continue;
      const double length = (surface.corner(f, (side + 1) % 3) - surface.corner(f, side)).norm();
      const double least_height = 2 * std::min(a.norm(), b.norm()) / length;
      if (turn * least_height < 4 * rounding) continue;
      radii[f] = std::min(radii[f], (a.norm() + b.norm()) / length / turn);
    }
  return radii;
}

// Points spread over a facet, about `spacing` apart: the centroids of its n^2 equal parts.
std::vector<Vector3> spread(const SurfaceMesh& surface, std::size_t facet, double spacing) {
  const double edge = std::sqrt(2 * surface.area_vector(facet).norm());
  const int n = std::max(1, static_cast<int>(std::ceil(edge / spacing)));
  const Vector3 &a = surface.corner(facet, 0), u = (surface.corner(facet, 1) - a) / n,
                v = (surface.corner(facet, 2) - a) / n;
  std::vector<Vector3> points;
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j) {
      points.emplace_back(a + (i + 1.0 / 3) * u + (j + 1.0 / 3) * v);
      if (i + j + 1 < n) points.emplace_back(a + (i + 2.0 / 3) * u + (j + 2.0 / 3) * v);
    }
  return points;
}

// Triangles of these sizes on the whole surface, of `areas` [m^2].
double triangle_count(const std::vector<double>& areas, const std::vector<double>& sizes) {
  double count = 0;
  for (std::size_t i = 0; i < areas.size(); ++i)
    count += areas[i] / (std::sqrt(3.0) / 4 * sizes[i] * sizes[i]);
  return count;
}

// The error of an element beside a singular edge falls as h^(2 lambda), whatever its order; at the
// edge of a held face lambda is about 3/4.
constexpr double singular_exponent = 1 / (2 * 0.75 + 3);
constexpr double most_refined = 0.2, most_coarsened = 1.5;

// The factor K of size_from_error for a share of the error, with sizes of p-th order elements.
class Equidistribution {
 public:
  Equidistribution(const std::vector<double>& error_of, int order)
      : error_of_(error_of), smooth_exponent_(1.0 / (2 * order + 3)), order_(order) {
    for (const double error : error_of) total_ += error;
  }

  double ratio(double k, double error) const {
    if (!(error > 0)) return most_coarsened;
    const double exponent = error > k ? singular_exponent : smooth_exponent_;
    return std::clamp(std::pow(k / error, exponent), most_refined, most_coarsened);
  }
  double share(double k) const {
    double sum = 0;
    for (const double error : error_of_) sum += error * std::pow(ratio(k, error), 2 * order_);
    return sum / total_;
  }
  double growth(double k) const {
    double sum = 0;
    for (const double error : error_of_) sum += std::pow(ratio(k, error), -3);
    return sum / static_cast<double>(error_of_.size());
  }
  // The share rises with K, the growth falls: the largest K that gives both wanted ones, but no
  // more growth than allowed.
  double solve(const RefinementAim& aim) const {
    if (total_ == 0) return 1;
    double low = std::log(1e-30 * total_), high = std::log(total_);
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high), k = std::exp(middle);
      const bool is_coarse = share(k) > aim.share || growth(k) < aim.least_growth;
      (is_coarse && growth(k) < aim.most_growth ? high : low) = middle;
    }
    return std::exp(low);
  }

 private:
  const std::vector<double>& error_of_;
  double smooth_exponent_, total_ = 0;
  int order_;
};

}  // namespace

SizeField size_from_surface(const SurfaceMesh& surface) {
  const double largest = bounding_box(surface.points).diagonal().norm() / elements_per_diagonal;
  double area = 0, volume = 0;
  for (std::size_t f = 0; f < surface.triangles.size(); ++f) {
    area += surface.area_vector(f).norm();
    volume += surface.area_vector(f).dot(surface.centroid(f) - surface.points.front()) / 3;
  }
  const double mean = 2 * volume / area, smallest = least_part * mean;
  const double spacing = std::max(std::sqrt(area / most_samples), 0.1 * largest);
  const Thickness thickness(surface);
  const std::vector<double> radii = curvature_radii(surface);
  SizeField field;
  std::vector<double> areas;  // that the points stand for
  for (std::size_t f = 0; f < surface.triangles.size(); ++f) {
    const double own_area = surface.area_vector(f).norm();
    if (own_area == 0) continue;
    const std::vector<Vector3> points = spread(surface, f, spacing);
    areas.insert(areas.end(), points.size(), own_area / static_cast<double>(points.size()));
    for (const Vector3& point : points) {
      field.points.push_back(point);
      field.sizes.push_back(
          std::min({std::max(thicknesses_per_element * thickness.at(f, point), smallest),
                    std::max(radii[f], least_radius_part * mean), largest}));
    }
  }
  const double growth = std::sqrt(triangle_count(areas, field.sizes) / most_triangles);
  for (double& size : field.sizes) size = std::min(std::max(1.0, growth) * size, largest);
  return field;
}

SizeField size_from_error(const TetMesh& mesh, const std::vector<double>& error_of,
                          const RefinementAim& aim) {
  const Equidistribution equidistribution(error_of, mesh.order);
  const double k = equidistribution.solve(aim);
  // At the corner nodes, the geometric mean over the elements around: the sizes of single elements
  // scatter.
  std::vector<double> sum(mesh.nodes.size(), 0);
  std::vector<int> count(mesh.nodes.size(), 0);
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    // A mesh of TetGen's has elements of a little over half the volume that is allowed.
    const double allowed = 1.7 * volume(mesh.corners(e));
    const double wish = std::log(regular_edge(allowed) * equidistribution.ratio(k, error_of[e]));
    for (const int node : mesh.element(e).first(4)) {
      sum[at(node)] += wish;
      ++count[at(node)];
    }
  }
  SizeField field;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    if (count[n] == 0) continue;
    field.points.push_back(mesh.nodes[n]);
    field.sizes.push_back(std::exp(sum[n] / count[n]));
  }
  return field;
}

}  // namespace kinetostat::fea

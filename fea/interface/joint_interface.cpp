#include "kinetostat/fea/interface/joint_interface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include <fmt/format.h>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/surface/surface_faces.h"

namespace kinetostat::fea::joint_interface {
namespace {

using common::at;

constexpr double farthest = 1.0 / 3;  // of the diagonal, from the point of the joint
constexpr double flatness = 1e-4;     // of the diagonal, as selectors have it
constexpr double aligned = 0.9998;    // cosine of 1 degree
constexpr double beside_axis = 0.02;  // of the radius, between the axes
constexpr double around_axis = 0.5;   // of the radius of a disc of its area, centroid to axis
constexpr double flat_penalty = 0.05, boss_penalty = 0.15;  // beside distances over the diagonal
constexpr double size_weight = 0.05;                        // of a decade of area
constexpr double least_share = 0.05;                        // of the area, of a box

// Where along the axis the joint is looked for: at its point, or where the mesh is nearest to that.
double place_along(const SurfaceMesh& surface, const JointAxis& axis) {
  double low = std::numeric_limits<double>::max(), high = -low;
  for (const Vector3& point : surface.points) {
    const double along = axis.direction.dot(point - axis.point);
    low = std::min(low, along);
    high = std::max(high, along);
  }
  return low > high ? 0 : std::clamp(0.0, low, high);
}

class Finder {
 public:
  Finder(const SurfaceMesh& surface, const JointAxis& axis)
      : surface_(surface),
        axis_(axis),
        size_(bounding_box(surface.points).diagonal().norm()),
        place_(place_along(surface, axis)) {}

  std::vector<JointInterface> run() {
    const std::vector<FlatFace> flat = flat_faces(surface_, flatness * size_);
    for (const RoundFace& face : round_faces(surface_, flat)) add_round(face);
    for (const FlatFace& face : flat) add_flat(face);
    std::stable_sort(
        found_.begin(), found_.end(),
        [](const JointInterface& a, const JointInterface& b) { return a.rank < b.rank; });
    return std::move(found_);
  }

 private:
  double along(const Vector3& point) const { return axis_.direction.dot(point - axis_.point); }
  double beside(const Vector3& point) const {
    return axis_.direction.cross(point - axis_.point).norm();
  }

  void add(const Selector& selector, double off, double penalty, const std::string& words) {
    JointInterface face{.selector = selector,
                        .facets = select_facets(surface_, selector),
                        .off = off,
                        .words = words};
    face.area = area_of(surface_, face.facets);
    const double away = std::abs(off - place_);
    if (away > farthest * size_ || !(face.area > 0)) return;
    face.rank = away / size_ + penalty - size_weight * std::log10(face.area / (size_ * size_));
    found_.push_back(std::move(face));
  }

  void add_round(const RoundFace& face) {
    if (std::abs(face.axis.dot(axis_.direction)) < aligned ||
        beside(face.axis_point) > beside_axis * face.radius)
      return;
    double inward = 0;
    for (const int f : face.facets) {
      const Vector3 radial = surface_.centroid(at(f)) - face.axis_point;
      inward -= surface_.area_vector(at(f)).dot(radial - face.axis * face.axis.dot(radial));
    }
    const bool is_bore = inward > 0;
    const double slack = 1e-3 * face.length;
    const CylinderSelector selector{
        .axis_point = face.axis_point - (face.length / 2 + slack) * face.axis,
        .axis = face.axis,
        .radius = face.radius,
        .length = face.length + 2 * slack};
    add(selector, along(face.axis_point), is_bore ? 0 : boss_penalty,
        fmt::format("{} of radius {:.4g} mm", is_bore ? "bore" : "boss", 1e3 * face.radius));
  }

  void add_flat(const FlatFace& face) {
    if (std::abs(face.normal.dot(axis_.direction)) < aligned ||
        beside(face.centroid) > around_axis * std::sqrt(face.area / std::numbers::pi))
      return;
    const PlaneSelector plane{face.centroid, face.normal};
    // All of the plane, unless that has other faces, too: then the one that a ray meets.
    if (std::abs(area_of(surface_, select_facets(surface_, plane)) - face.area) < 1e-6 * face.area)
      return add(plane, along(face.centroid), flat_penalty, words_of(face));
    const Vector3 on_face = surface_.centroid(at(face.facets.front()));
    const NearestFaceSelector ray{on_face + flatness * size_ * face.normal, -face.normal};
    if (std::abs(area_of(surface_, select_facets(surface_, ray)) - face.area) < 1e-6 * face.area)
      add(ray, along(face.centroid), flat_penalty, words_of(face));
  }
  static std::string words_of(const FlatFace& face) {
    return fmt::format("flat face of {:.4g} cm^2", 1e4 * face.area);
  }

  const SurfaceMesh& surface_;
  const JointAxis& axis_;
  double size_, place_;
  std::vector<JointInterface> found_;
};

// The half edge of the cube about the point that holds a facet, and the facet's area.
struct Reach {
  double half = 0, area = 0;
};

std::vector<Reach> reaches(const SurfaceMesh& surface, const Vector3& point) {
  std::vector<Reach> all;
  all.reserve(surface.triangles.size());
  for (std::size_t f = 0; f < surface.triangles.size(); ++f) {
    double half = 0;
    for (const int corner : surface.triangles[f])
      half = std::max(half, (surface.points[at(corner)] - point).cwiseAbs().maxCoeff());
    all.push_back({half, surface.area_vector(f).norm()});
  }
  std::sort(all.begin(), all.end(), [](const Reach& a, const Reach& b) { return a.half < b.half; });
  return all;
}

// Of the smallest cube that holds so much area.
double half_edge(const std::vector<Reach>& facets, double area) {
  double held = 0;
  for (const Reach& facet : facets)
    if ((held += facet.area) >= area) return facet.half;
  return facets.empty() ? 0 : facets.back().half;
}

std::set<int> points_of(const SurfaceMesh& surface, const JointInterface& face) {
  std::set<int> points;
  for (const int f : face.facets)
    points.insert(surface.triangles[at(f)].begin(), surface.triangles[at(f)].end());
  return points;
}

bool share_a_point(const std::set<int>& a, const std::set<int>& b) {
  return std::any_of(a.begin(), a.end(), [&b](int point) { return b.contains(point); });
}

}  // namespace
}  // namespace kinetostat::fea::joint_interface

namespace kinetostat::fea {

std::vector<JointInterface> joint_interfaces(const SurfaceMesh& surface, const JointAxis& axis) {
  return joint_interface::Finder(surface, axis).run();
}

std::vector<JointInterface> surroundings(const SurfaceMesh& surface, const JointAxis& axis) {
  using namespace joint_interface;
  const double off = place_along(surface, axis);
  const Vector3 point = axis.point + off * axis.direction;
  const std::vector<Reach> facets = reaches(surface, point);
  const double size = bounding_box(surface.points).diagonal().norm();
  double nearest = size;
  for (const Vector3& corner : surface.points) nearest = std::min(nearest, (corner - point).norm());
  const double ring =
      std::max(4 * std::numbers::pi * nearest * nearest, least_share * area_of(surface));
  std::vector<JointInterface> found;
  for (const double part : {1.0, 0.5, 0.25}) {
    const double half = half_edge(facets, part * ring) + flatness * size;
    if (half > farthest * size) continue;
    const Vector3 corner = Vector3::Constant(half);
    JointInterface box{.selector = BoxSelector{Box(point - corner, point + corner)},
                       .facets = {},
                       .off = off,
                       .words = "surface",
                       .rank = 2 - part};
    box.facets = select_facets(surface, box.selector);
    box.area = area_of(surface, box.facets);
    if (box.area > 0) found.push_back(std::move(box));
  }
  return found;
}

std::optional<std::pair<JointInterface, JointInterface>> apart(
    const SurfaceMesh& surface, const std::vector<JointInterface>& first,
    const std::vector<JointInterface>& second) {
  using namespace joint_interface;
  const JointInterface *best_a = nullptr, *best_b = nullptr;
  for (const JointInterface& a : first) {
    const std::set<int> points = points_of(surface, a);
    for (const JointInterface& b : second) {
      if (best_a != nullptr && a.rank + b.rank >= best_a->rank + best_b->rank) break;
      if (share_a_point(points, points_of(surface, b))) continue;
      best_a = &a;
      best_b = &b;
      break;
    }
  }
  if (best_a == nullptr) return std::nullopt;
  return std::pair(*best_a, *best_b);
}

}  // namespace kinetostat::fea

#include "kinetostat/fea/surface/surface_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <numeric>
#include <unordered_map>

#include <fmt/format.h>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {
namespace {

using common::at;

constexpr std::size_t stl_header = 84;

// Cubic cells as wide as the tolerance: a point's partners lie in its cell or the 26 around it.
class PointGrid {
 public:
  PointGrid(const Vector3& origin, double width) : origin_(origin), width_(width) {}

  // The kept point that `point` becomes, or -1.
  int find(const Vector3& point, const std::vector<Vector3>& kept) const {
    const Cell centre = cell(point);
    int best = -1;
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dz = -1; dz <= 1; ++dz) {
          const auto entry = cells_.find({centre[0] + dx, centre[1] + dy, centre[2] + dz});
          if (entry == cells_.end()) continue;
          for (const int candidate : entry->second)
            if ((kept[at(candidate)] - point).norm() <= width_ && (best < 0 || candidate < best))
              best = candidate;
        }
    return best;
  }
  void add(const Vector3& point, int index) { cells_[cell(point)].push_back(index); }

 private:
  using Cell = std::array<std::int64_t, 3>;
  struct Hash {
    std::size_t operator()(const Cell& c) const {
      std::uint64_t h = 0;
      for (const std::int64_t k : c)
        h = (h ^ static_cast<std::uint64_t>(k)) * 0x9E3779B97F4A7C15u + (h >> 29);
      return h ^ h >> 32;
    }
  };
  Cell cell(const Vector3& p) const {
    const Vector3 scaled = (p - origin_) / width_;
    return {std::llround(scaled.x()), std::llround(scaled.y()), std::llround(scaled.z())};
  }

  Vector3 origin_;
  double width_;
  std::unordered_map<Cell, std::vector<int>, Hash> cells_;
};

// Numbers identical points alike; `points` shrinks to one of each, in order of first appearance.
std::vector<int> merge_identical(std::vector<Vector3>& points) {
  std::vector<int> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&points](int i) {
    const Vector3& p = points[at(i)];
    return std::array<double, 3>{p.x(), p.y(), p.z()};
  };
  std::sort(order.begin(), order.end(), [&key](int a, int b) {
    const auto ka = key(a), kb = key(b);
    return ka != kb ? ka < kb : a < b;
  });
  std::vector<int> first(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
    first[at(order[i])] = same ? first[at(order[i - 1])] : order[i];
  }
  std::vector<int> number(points.size());
  std::vector<Vector3> kept;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (first[i] == static_cast<int>(i)) {
      number[i] = static_cast<int>(kept.size());
      kept.push_back(points[i]);
    } else {
      number[i] = number[at(first[i])];
    }
  }
  points = std::move(kept);
  return number;
}

}  // namespace

std::string group_of_face(std::size_t number) { return fmt::format("face {}", number); }

void append(SurfaceMesh& mesh, const SurfaceMesh& other) {
  const int base = static_cast<int>(mesh.points.size());
  mesh.points.insert(mesh.points.end(), other.points.begin(), other.points.end());
  for (const auto& [a, b, c] : other.triangles)
    mesh.triangles.push_back({a + base, b + base, c + base});
}

double area_of(const SurfaceMesh& mesh) {
  double area = 0;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) area += mesh.area_vector(f).norm();
  return area;
}

double area_of(const SurfaceMesh& mesh, const std::vector<int>& facets) {
  double area = 0;
  for (const int f : facets) area += mesh.area_vector(at(f)).norm();
  return area;
}

std::vector<int> face_of_facets(const SurfaceMesh& surface) {
  std::vector<int> face(surface.triangles.size(), 0);
  std::map<std::string, int> number;
  for (std::size_t i = 1; i <= surface.faces.size(); ++i)
    number[group_of_face(i)] = static_cast<int>(i);
  for (const FacetGroup& group : surface.groups)
    if (const auto found = number.find(group.name); found != number.end())
      for (const int f : group.facets) face[at(f)] = found->second;
  return face;
}

Box bounding_box(const std::vector<Vector3>& points) {
  Box box;
  for (const Vector3& p : points) box.extend(p);
  return box;
}

// Moeller and Trumbore 1997, Journal of Graphics Tools 2:21.
double ray_hit(const SurfaceMesh& surface, std::size_t facet, const Vector3& from,
               const Vector3& direction) {
  const Vector3 &a = surface.corner(facet, 0), ab = surface.corner(facet, 1) - a,
                ac = surface.corner(facet, 2) - a, cross = direction.cross(ac);
  const double determinant = ab.dot(cross);
  const double miss = std::numeric_limits<double>::infinity();
  if (determinant == 0) return miss;
  const Vector3 arm = from - a;
  const double u = arm.dot(cross) / determinant;
  const double v = direction.dot(arm.cross(ab)) / determinant;
  if (u < 0 || v < 0 || u + v > 1) return miss;
  const double distance = ac.dot(arm.cross(ab)) / determinant;
  return distance > 0 ? distance : miss;
}

double weld_tolerance(const std::vector<Vector3>& points) {
  const Box box = bounding_box(points);
  const double farthest =
      std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
  return std::max(1e-6 * box.diagonal().norm(),
                  4 * double{std::numeric_limits<float>::epsilon()} * farthest);
}

void drop_unused_points(SurfaceMesh& mesh) {
  std::vector<int> number(mesh.points.size(), -1);
  for (const Triangle& t : mesh.triangles)
    for (const int corner : t) number[at(corner)] = 0;
  std::size_t count = 0;
  for (std::size_t p = 0; p < number.size(); ++p) {
    if (number[p] < 0) continue;
    number[p] = static_cast<int>(count);
    mesh.points[count++] = mesh.points[p];
  }
  mesh.points.resize(count);
  for (Triangle& t : mesh.triangles)
    for (int& corner : t) corner = number[at(corner)];
}

void keep_facets(SurfaceMesh& mesh, const std::vector<int>& kept) {
  std::vector<Triangle> triangles;
  for (std::size_t f = 0; f < kept.size(); ++f)
    if (kept[f] >= 0) triangles.push_back(mesh.triangles[f]);
  mesh.triangles = std::move(triangles);
  for (FacetGroup& group : mesh.groups) {
    std::vector<int> facets;
    for (const int f : group.facets)
      if (kept[at(f)] >= 0) facets.push_back(kept[at(f)]);
    group.facets = std::move(facets);
  }
  std::erase_if(mesh.groups, [](const FacetGroup& group) { return group.facets.empty(); });
  drop_unused_points(mesh);
}

std::vector<int> merge_near(std::vector<Vector3>& points, double tolerance) {
  std::vector<int> number(points.size());
  std::vector<Vector3> kept;
  PointGrid grid(bounding_box(points).min(), tolerance);
  for (std::size_t i = 0; i < points.size(); ++i) {
    number[i] = grid.find(points[i], kept);
    if (number[i] >= 0) continue;
    number[i] = static_cast<int>(kept.size());
    grid.add(points[i], number[i]);
    kept.push_back(points[i]);
  }
  points = std::move(kept);
  return number;
}

WeldReport weld(SurfaceMesh& mesh, double tolerance) {
  WeldReport report{.tolerance = tolerance, .points_before = mesh.points.size()};
  const std::vector<int> identical = merge_identical(mesh.points);
  std::vector<int> near(mesh.points.size());
  std::iota(near.begin(), near.end(), 0);
  if (tolerance > 0) near = merge_near(mesh.points, tolerance);
  std::vector<int> kept(mesh.triangles.size(), -1);
  int count = 0;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    Triangle& t = mesh.triangles[f];
    for (int& corner : t) corner = near[at(identical[at(corner)])];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
      report.collapsed.push_back(static_cast<int>(f));
    else
      kept[f] = count++;
  }
  keep_facets(mesh, kept);
  report.points_after = mesh.points.size();
  return report;
}

std::string stl_bytes(const SurfaceMesh& mesh, double metres) {
  std::string bytes(stl_header, '\0');
  const std::string title = "written by kinetostat";
  std::copy(title.begin(), title.end(), bytes.begin());
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  std::memcpy(bytes.data() + 80, &count, sizeof count);
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    std::array<float, 12> values{};
    const auto put = [&values](std::size_t at, const Vector3& v) {
      for (std::size_t d = 0; d < 3; ++d)
        values[at + d] = static_cast<float>(v[static_cast<Eigen::Index>(d)]);
    };
    put(0, mesh.area_vector(f).normalized());
    for (std::size_t k = 0; k < 3; ++k) put(3 + 3 * k, mesh.corner(f, k) / metres);
    bytes.append(reinterpret_cast<const char*>(values.data()), sizeof values);
    bytes.append(2, '\0');
  }
  return bytes;
}

}  // namespace kinetostat::fea

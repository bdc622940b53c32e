#include "kinetostat/fea/mesh/primitive_surface.h"

#include <cmath>
#include <initializer_list>
#include <numbers>

namespace kinetostat::fea {
namespace primitive_surface {
namespace {

constexpr int sides = 48;
constexpr double step = 2 * std::numbers::pi / sides;

// Of corners, over that of the circle with the area of their polygon.
double corner_radius() { return std::sqrt(step / std::sin(step)); }

struct Ring {
  double radius, z;
};

// From the lowest to the highest ring between two points on the axis.
SurfaceMesh turned(double low, const std::vector<Ring>& rings, double high) {
  SurfaceMesh mesh;
  mesh.points.emplace_back(0, 0, low);
  for (const Ring& ring : rings)
    for (int i = 0; i < sides; ++i)
      mesh.points.emplace_back(ring.radius * std::cos(step * i), ring.radius * std::sin(step * i),
                               ring.z);
  mesh.points.emplace_back(0, 0, high);
  const int count = static_cast<int>(rings.size()), top = 1 + sides * count;
  const auto corner = [](int ring, int i) { return 1 + sides * ring + i % sides; };
  for (int i = 0; i < sides; ++i) {
    mesh.triangles.push_back({0, corner(0, i + 1), corner(0, i)});
    for (int r = 0; r + 1 < count; ++r) {
      const int a = corner(r, i), b = corner(r, i + 1), c = corner(r + 1, i + 1),
                d = corner(r + 1, i);
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
    mesh.triangles.push_back({top, corner(count - 1, i), corner(count - 1, i + 1)});
  }
  return mesh;
}

}  // namespace
}  // namespace primitive_surface

SurfaceMesh box_surface(const Vector3& low, const Vector3& high) {
  SurfaceMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.points.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(),
                             i & 4 ? high.z() : low.z());
  for (const auto& [a, b, c, d] : std::initializer_list<std::array<int, 4>>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  }
  return mesh;
}

SurfaceMesh cylinder_surface(double radius, double length) {
  using namespace primitive_surface;
  const double corner = corner_radius() * radius;
  return turned(-length / 2, {{corner, -length / 2}, {corner, length / 2}}, length / 2);
}

SurfaceMesh capsule_surface(double radius, double length) {
  using namespace primitive_surface;
  const double corner = corner_radius() * radius;
  constexpr int quarter = sides / 4;
  std::vector<Ring> rings;
  const auto add = [&](int k, double z) {
    rings.push_back(
        {corner * corner_radius() * std::cos(step * k), z + corner * std::sin(step * k)});
  };
  for (int k = 1 - quarter; k <= 0; ++k) add(k, -length / 2);
  for (int k = length > 0 ? 0 : 1; k < quarter; ++k) add(k, length / 2);  // a ball has one equator
  return turned(-length / 2 - corner, rings, length / 2 + corner);
}

}  // namespace kinetostat::fea

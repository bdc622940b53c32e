#include "kinetostat/fea/interface/stiff_body.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {
namespace {

using common::at;

constexpr int most_halvings = 12;
constexpr double least_shrinkage = 0.25;  // of the area of a facet from bottom to top

// The triangles of an interface with corners numbered from 0, in the order of the mesh's nodes.
struct Patch {
  std::vector<int> corners;  // nodes of the mesh, ascending
  std::vector<Triangle> triangles;
  std::vector<Vector3> points, normals;  // of the corners

  Vector3 area_vector(const Triangle& t, double height) const {
    const auto p = [&](std::size_t k) -> Vector3 {
      const auto corner = at(t[k]);
      return points[corner] + height * normals[corner];
    };
    return 0.5 * (p(1) - p(0)).cross(p(2) - p(0));
  }
};

std::vector<int> corners_of(const TetMesh& mesh, const Interface& interface) {
  std::vector<int> corners;
  for (const BoundaryFace& face : mesh.boundary)
    if (face.tag == interface.tag)
      corners.insert(corners.end(), face.nodes.begin(), face.nodes.begin() + 3);
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  return corners;
}

Patch patch_of(const TetMesh& mesh, const Interface& interface) {
  Patch patch;
  patch.corners = corners_of(mesh, interface);
  for (const int corner : patch.corners) patch.points.push_back(mesh.nodes[at(corner)]);
  patch.normals.assign(patch.corners.size(), Vector3::Zero());
  for (const BoundaryFace& face : mesh.boundary) {
    if (face.tag != interface.tag) continue;
    Triangle& t = patch.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k)
      t[k] = static_cast<int>(
          std::lower_bound(patch.corners.begin(), patch.corners.end(), face.nodes[k]) -
          patch.corners.begin());
  }
  for (const Triangle& t : patch.triangles)
    for (const int corner : t) patch.normals[at(corner)] += patch.area_vector(t, 0);
  for (Vector3& normal : patch.normals) normal.normalize();
  return patch;
}

double thickness_on(const Patch& patch, const Interface& interface) {
  double thickness = interface.gyration.norm();
  for (int halving = 0; halving <= most_halvings; ++halving, thickness /= 2)
    if (std::all_of(patch.triangles.begin(), patch.triangles.end(), [&](const Triangle& t) {
          const Vector3 bottom = patch.area_vector(t, 0);
          return bottom.dot(patch.area_vector(t, thickness)) >=
                 least_shrinkage * bottom.squaredNorm();
        }))
      return thickness;
  throw NoStiffBody("no body can be grown on an interface that folds back on itself");
}

// Appends nodes and elements; knows the middles of the edges that have one.
class Grower {
 public:
  Grower(TetMesh& mesh, const Interface& interface) : mesh_(mesh) {
    if (mesh.order == 1) return;
    for (const BoundaryFace& face : mesh.boundary)
      if (face.tag == interface.tag)
        for (std::size_t k = 0; k < 3; ++k)
          middles_[std::minmax(face.nodes[k], face.nodes[(k + 1) % 3])] = face.nodes[3 + k];
  }

  int add_node(const Vector3& point) {
    mesh_.nodes.push_back(point);
    return static_cast<int>(mesh_.nodes.size()) - 1;
  }

  void add_tetrahedron(std::array<int, 4> tet) {
    const auto p = [&](std::size_t k) { return mesh_.nodes[at(tet[k])]; };
    if (volume({p(0), p(1), p(2), p(3)}) < 0) std::swap(tet[2], tet[3]);
    mesh_.connectivity.insert(mesh_.connectivity.end(), tet.begin(), tet.end());
    if (mesh_.order == 1) return;
    for (const auto& [a, b] : tet_edges)
      mesh_.connectivity.push_back(middle(tet[at(a)], tet[at(b)]));
  }

 private:
  int middle(int a, int b) {
    const auto [known, is_new] = middles_.try_emplace(std::minmax(a, b), 0);
    if (is_new) known->second = add_node(0.5 * (mesh_.nodes[at(a)] + mesh_.nodes[at(b)]));
    return known->second;
  }

  TetMesh& mesh_;
  std::map<std::pair<int, int>, int> middles_;
};

}  // namespace

void grow_stiff_body(TetMesh& mesh, const Interface& interface, int material) {
  const Patch patch = patch_of(mesh, interface);
  const double thickness = thickness_on(patch, interface);
  mesh.materials.resize(mesh.element_count(), 0);
  Grower grower(mesh, interface);
  std::vector<int> top;
  for (std::size_t c = 0; c < patch.corners.size(); ++c)
    top.push_back(grower.add_node(patch.points[c] + thickness * patch.normals[c]));
  for (Triangle t : patch.triangles) {
    // Prisms with a common side cut it along the same diagonal, from the lower corner below to the
    // higher one above.
    std::sort(t.begin(), t.end());
    const auto low = [&](std::size_t k) { return patch.corners[at(t[k])]; };
    const auto high = [&](std::size_t k) { return top[at(t[k])]; };
    grower.add_tetrahedron({low(0), low(1), low(2), high(2)});
    grower.add_tetrahedron({low(0), low(1), high(1), high(2)});
    grower.add_tetrahedron({low(0), high(0), high(1), high(2)});
  }
  mesh.materials.resize(mesh.element_count(), material);
}

}  // namespace kinetostat::fea

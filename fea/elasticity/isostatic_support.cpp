#include "kinetostat/fea/elasticity/isostatic_support.h"

#include <cmath>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {
namespace {

using common::at;

// The free corner of an element for which distance(point) is largest.
template <class Distance>
int farthest_corner(const TetMesh& mesh, const DofMap& unknowns, Distance distance) {
  int farthest = mesh.connectivity.front();
  double most = -1;
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    for (std::size_t k = 0; k < 4; ++k) {
      const int node = mesh.element(e)[k];
      if (unknowns.block_of(node) < 0) continue;
      const double d = distance(mesh.nodes[at(node)]);
      if (d > most) {
        most = d;
        farthest = node;
      }
    }
  return farthest;
}

}  // namespace

std::vector<GroundSpring> isostatic_support(const TetMesh& mesh, const DofMap& unknowns,
                                            double young) {
  const auto point = [&mesh](int node) { return mesh.nodes[at(node)]; };
  const Vector3 middle = bounding_box(mesh.nodes).center();
  const int a =
      farthest_corner(mesh, unknowns, [&](const Vector3& p) { return (p - middle).norm(); });
  const int b =
      farthest_corner(mesh, unknowns, [&](const Vector3& p) { return (p - point(a)).norm(); });
  const Vector3 line = (point(b) - point(a)).normalized();
  const int c = farthest_corner(mesh, unknowns,
                                [&](const Vector3& p) { return line.cross(p - point(a)).norm(); });
  const Vector3 normal = line.cross(point(c) - point(a)).normalized();
  // About the stiffness of one element.
  const auto elements = static_cast<double>(mesh.element_count());
  const double stiffness = young * std::cbrt(bounding_box(mesh.nodes).volume() / elements);
  return {{a, stiffness * Matrix3::Identity()},
          {b, stiffness * (Matrix3::Identity() - line * line.transpose())},
          {c, stiffness * normal * normal.transpose()}};
}

}  // namespace kinetostat::fea

#include "kinetostat/fea/interface/face_integral.h"

#include <array>
#include <cmath>

#include "kinetostat/common/index.h"

namespace kinetostat::fea::face_integral {
namespace {

struct GaussPoint {
  double place, weight;
};

// Gauss and Legendre's rule of four points on [0, 1].
std::array<GaussPoint, 4> gauss() {
  const double near = std::sqrt(3.0 / 7 - 2.0 / 7 * std::sqrt(1.2));
  const double far = std::sqrt(3.0 / 7 + 2.0 / 7 * std::sqrt(1.2));
  const double heavy = (18 + std::sqrt(30.0)) / 72, light = (18 - std::sqrt(30.0)) / 72;
  return {{{0.5 * (1 - far), light},
           {0.5 * (1 - near), heavy},
           {0.5 * (1 + near), heavy},
           {0.5 * (1 + far), light}}};
}

// Barycentric coordinates l; corners l_k (2 l_k - 1), middles 4 l_k l_(k+1).
FaceShapes shapes_at(const Vector3& l) {
  FaceShapes shapes;
  for (Eigen::Index k = 0; k < 3; ++k) {
    shapes[k] = l[k] * (2 * l[k] - 1);
    shapes[3 + k] = 4 * l[k] * l[(k + 1) % 3];
  }
  return shapes;
}

// Derivatives by the barycentric coordinates, one column each.
Eigen::Matrix<double, 6, 3> slopes_at(const Vector3& l) {
  Eigen::Matrix<double, 6, 3> slopes = Eigen::Matrix<double, 6, 3>::Zero();
  for (Eigen::Index k = 0; k < 3; ++k) {
    slopes(k, k) = 4 * l[k] - 1;
    slopes(3 + k, k) = 4 * l[(k + 1) % 3];
    slopes(3 + k, (k + 1) % 3) = 4 * l[k];
  }
  return slopes;
}

}  // namespace
}  // namespace kinetostat::fea::face_integral

namespace kinetostat::fea {

void integrate_face(
    const TetMesh& mesh, const BoundaryFace& face,
    const std::function<void(const FaceShapes& shapes, const Vector3& point, double area)>& visit) {
  using namespace face_integral;
  Eigen::Matrix<double, 3, 6> nodes;
  for (std::size_t k = 0; k < 6; ++k)
    nodes.col(static_cast<Eigen::Index>(k)) = mesh.nodes[common::at(face.nodes[k])];
  for (const GaussPoint& u : gauss())
    for (const GaussPoint& v : gauss()) {
      const Vector3 l(1 - u.place - v.place * (1 - u.place), u.place, v.place * (1 - u.place));
      const Matrix3 by_l = nodes * slopes_at(l);
      const Vector3 area = (by_l.col(1) - by_l.col(0)).cross(by_l.col(2) - by_l.col(0));
      const FaceShapes shapes = shapes_at(l);
      visit(shapes, nodes * shapes, u.weight * v.weight * (1 - u.place) * area.norm());
    }
}

bool has_curved_faces(const TetMesh& mesh) { return mesh.curved && !mesh.gaps.empty(); }

}  // namespace kinetostat::fea

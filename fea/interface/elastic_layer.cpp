#include "kinetostat/fea/interface/elastic_layer.h"

#include "kinetostat/common/index.h"
#include "kinetostat/fea/interface/face_integral.h"

namespace kinetostat::fea::elastic_layer {
namespace {

double area_of(const TetMesh& mesh, const BoundaryFace& face, const Vector3& flat) {
  if (!has_curved_faces(mesh)) return flat.norm();
  double sum = 0;
  integrate_face(mesh, face,
                 [&sum](const FaceShapes&, const Vector3&, double area) { sum += area; });
  return sum;
}

}  // namespace
}  // namespace kinetostat::fea::elastic_layer

namespace kinetostat::fea {

std::map<int, Matrix3> layer_springs(const TetMesh& mesh, const Interface& interface,
                                     const ElasticLayer& layer) {
  using namespace elastic_layer;
  std::map<int, Matrix3> springs;
  for (const BoundaryFace& face : mesh.boundary) {
    if (face.tag != interface.tag) continue;
    const auto p = [&](std::size_t k) { return mesh.nodes[common::at(face.nodes[k])]; };
    const Vector3 flat = 0.5 * (p(1) - p(0)).cross(p(2) - p(0));
    const Vector3 normal = flat.normalized();
    const Matrix3 across = normal * normal.transpose();
    const Matrix3 stiffness =
        layer.normal * across + layer.tangential * (Matrix3::Identity() - across);
    const std::size_t first = mesh.order == 2 ? 3 : 0;
    for (std::size_t k = first; k < first + 3; ++k)
      springs.try_emplace(face.nodes[k], Matrix3::Zero()).first->second +=
          area_of(mesh, face, flat) / 3 * stiffness;
  }
  return springs;
}

}  // namespace kinetostat::fea

#include "kinetostat/fea/elasticity/contact_stiffness.h"

#include <Eigen/LU>

#include "kinetostat/common/index.h"

namespace kinetostat::fea::contact_stiffness_terms {
namespace {

using common::at;
using Eigen::Index;

// One of the two elements, and its share in the mean traction.
struct Half {
  std::size_t element = 0;
  const Material& material;
  double limit = 0;  // [N/m^3] (lambda + 2 mu) times the trace
  double share = 0;  // of the mean traction
};

Eigen::VectorXd shapes_at(const Eigen::Vector4d& l, int order) {
  if (order == 1) return l;
  Eigen::VectorXd shapes(10);
  for (Index k = 0; k < 4; ++k) shapes[k] = l[k] * (2 * l[k] - 1);
  for (std::size_t e = 0; e < tet_edges.size(); ++e)
    shapes[4 + static_cast<Index>(e)] = 4 * l[tet_edges[e][0]] * l[tet_edges[e][1]];
  return shapes;
}

Eigen::Matrix3Xd gradients_at(const TetMesh& mesh, std::size_t element, const Eigen::Vector4d& l) {
  Eigen::Matrix3Xd straight =
      shape_gradients(barycentric_gradients(mesh.corners(element)), mesh.order, l);
  if (!mesh.curved) return straight;
  const std::array<Vector3, 10> nodes = mesh.all_nodes(element);
  const Eigen::Map<const Eigen::Matrix<double, 3, 10>> places(nodes[0].data());
  // From the straight element with these corners to the curved one.
  return Matrix3(places * straight.transpose()).inverse().transpose() * straight;
}

// Adds the traction on a plane with this normal, per displacement of the nodes.
void add_traction(const Half& half, const Eigen::Matrix3Xd& gradients, const Vector3& normal,
                  Eigen::Ref<Eigen::Matrix3Xd> traction) {
  const double lambda = half.material.lambda(), mu = half.material.mu();
  for (Index i = 0; i < gradients.cols(); ++i) {
    const Vector3 g = gradients.col(i);
    traction.middleCols<3>(3 * i) +=
        half.share * (lambda * normal * g.transpose() +
                      mu * (g.dot(normal) * Matrix3::Identity() + g * normal.transpose()));
  }
}

void add_jump(const Eigen::VectorXd& shapes, double sign, Eigen::Ref<Eigen::Matrix3Xd> jump) {
  for (Index i = 0; i < shapes.size(); ++i)
    jump.middleCols<3>(3 * i).diagonal().array() += sign * shapes[i];
}

}  // namespace
}  // namespace kinetostat::fea::contact_stiffness_terms

namespace kinetostat::fea {

std::vector<int> contact_nodes(const TetMesh& mesh, const FaceContact& contact) {
  std::vector<int> nodes;
  for (const int e : contact.elements) {
    const auto own = mesh.element(common::at(e));
    nodes.insert(nodes.end(), own.begin(), own.end());
  }
  return nodes;
}

Eigen::MatrixXd contact_stiffness(const TetMesh& mesh, const std::vector<Material>& materials,
                                  const FaceContact& contact) {
  using namespace contact_stiffness_terms;
  const auto half = [&](std::size_t s) {
    const std::size_t e = at(contact.elements[s]);
    const Material& material = materials[mesh.material_of(e)];
    return Half{e, material, (material.lambda() + 2 * material.mu()) * contact.trace[s]};
  };
  Half a = half(0), b = half(1);
  a.share = b.limit / (a.limit + b.limit);
  b.share = a.limit / (a.limit + b.limit);
  const double small = (a.limit + b.limit) / (4 * a.limit * b.limit);
  const Index own = 3 * static_cast<Index>(mesh.nodes_per_element());
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(2 * own, 2 * own);
  Eigen::Matrix3Xd jump(3, 2 * own), traction(3, 2 * own);
  for (const ContactPoint& point : contact.points) {
    jump.setZero();
    traction.setZero();
    add_jump(shapes_at(point.in_first, mesh.order), 1, jump.leftCols(own));
    add_jump(shapes_at(point.in_second, mesh.order), -1, jump.rightCols(own));
    add_traction(a, gradients_at(mesh, a.element, point.in_first), point.normal,
                 traction.leftCols(own));
    add_traction(b, gradients_at(mesh, b.element, point.in_second), point.normal,
                 traction.rightCols(own));
    jump -= small * traction;
    const Matrix3 along = point.normal * point.normal.transpose();
    const Matrix3 spring = along / (contact.normal_flexibility + small) +
                           (Matrix3::Identity() - along) / (contact.tangential_flexibility + small);
    stiffness.noalias() += point.area * jump.transpose() * (spring * jump).eval();
    stiffness.noalias() -= point.area * small * traction.transpose() * traction;
  }
  return stiffness;
}

}  // namespace kinetostat::fea

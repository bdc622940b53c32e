#include "kinetostat/fea/elasticity/prestress.h"

#include <cmath>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {
namespace {

using common::at;

// Barycentric coordinates of the points, one column each, all of the same weight: those at which
// the stiffness is integrated (elasticity.h).
Eigen::Matrix4Xd points_of(int order) {
  if (order == 1) return Eigen::Vector4d::Constant(0.25);
  const double near = (5 + 3 * std::sqrt(5.0)) / 20, far = (5 - std::sqrt(5.0)) / 20;
  Eigen::Matrix4d points = Eigen::Matrix4d::Constant(far);
  points.diagonal().setConstant(near);
  return points;
}

Matrix3 stress_of(const Matrix3& gradient, const Material& material) {
  return material.lambda() * gradient.trace() * Matrix3::Identity() +
         material.mu() * (gradient + gradient.transpose());
}

}  // namespace

// Calls visit(element, number of the point in the mesh, its share of the volume, gradients).
template <class Visit>
void Prestress::for_each_point(Visit visit) const {
  const Eigen::Matrix4Xd points = points_of(mesh_.order);
  std::size_t number = 0;
  for (std::size_t e = 0; e < mesh_.element_count(); ++e) {
    const std::array<Vector3, 4> corners = mesh_.corners(e);
    const BarycentricGradients barycentric = barycentric_gradients(corners);
    const double share = volume(corners) / static_cast<double>(points.cols());
    for (Eigen::Index q = 0; q < points.cols(); ++q)
      visit(e, number++, share, shape_gradients(barycentric, mesh_.order, points.col(q)));
  }
}

Prestress::Prestress(const TetMesh& mesh, const std::vector<Material>& materials,
                     const Eigen::Matrix3Xd& displacements)
    : mesh_(mesh) {
  for_each_point([&](std::size_t e, std::size_t, double, const Eigen::Matrix3Xd& gradients) {
    const Eigen::Matrix3Xd u = displacements(Eigen::all, mesh.element(e));
    stresses_.push_back(stress_of(u * gradients.transpose(), materials[mesh.material_of(e)]));
  });
}

Eigen::Matrix3Xd Prestress::times(const Eigen::Matrix3Xd& displacements) const {
  Eigen::Matrix3Xd forces = Eigen::Matrix3Xd::Zero(3, displacements.cols());
  for_each_point(
      [&](std::size_t e, std::size_t number, double share, const Eigen::Matrix3Xd& gradients) {
        const auto nodes = mesh_.element(e);
        const Eigen::Matrix3Xd u = displacements(Eigen::all, nodes);
        const Matrix3 flux = share * u * gradients.transpose() * stresses_[number];
        forces(Eigen::all, nodes) += flux * gradients;
      });
  return forces;
}

Eigen::Matrix3Xd Prestress::nodal_forces() const {
  Eigen::Matrix3Xd forces =
      Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(mesh_.nodes.size()));
  for_each_point(
      [&](std::size_t e, std::size_t number, double share, const Eigen::Matrix3Xd& gradients) {
        forces(Eigen::all, mesh_.element(e)) += share * stresses_[number] * gradients;
      });
  return forces;
}

Matrix3 body_stress_stiffness(const TetMesh& mesh, const ReferenceBody& body,
                              const Eigen::Matrix3Xd& nodal_forces) {
  Matrix3 virial = Matrix3::Zero();
  for (const int n : body.nodes)
    virial += nodal_forces.col(n) * (mesh.nodes[at(n)] - body.point).transpose();
  // r x (r x a) = r (r . a) - a (r . r).
  return 0.5 * (virial + virial.transpose()) - virial.trace() * Matrix3::Identity();
}

PrestressProduct::PrestressProduct(const TetMesh& mesh, const DofMap& unknowns,
                                   const Prestress& prestress)
    : mesh_(mesh), unknowns_(unknowns), prestress_(prestress) {
  const Eigen::Matrix3Xd forces = prestress.nodal_forces();
  for (const ReferenceBody& body : unknowns.bodies())
    bodies_.push_back(body_stress_stiffness(mesh, body, forces));
}

Eigen::VectorXd PrestressProduct::on_unknowns(const Eigen::Matrix3Xd& forces) const {
  Eigen::VectorXd values = Eigen::VectorXd::Zero(Eigen::Index{3} * unknowns_.blocks());
  for (std::size_t n = 0; n < mesh_.nodes.size(); ++n) {
    const int node = static_cast<int>(n);
    if (const int block = unknowns_.block_of(node); block >= 0) {
      values.segment<3>(Eigen::Index{3} * block) += forces.col(node);
    } else if (const int body = unknowns_.body_of(node); body >= 0) {
      const auto b = at(body);
      values.segment<6>(Eigen::Index{3} * unknowns_.body_block(b)) +=
          spatial::rigid_motion(mesh_.nodes[n] - unknowns_.bodies()[b].point).transpose() *
          forces.col(node);
    }
  }
  return values;
}

Eigen::VectorXd PrestressProduct::operator*(const Eigen::VectorXd& values) const {
  Eigen::VectorXd product = on_unknowns(prestress_.times(unknowns_.displacements(mesh_, values)));
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Eigen::Index rotation = 3 * unknowns_.body_block(b) + 3;
    product.segment<3>(rotation) += bodies_[b] * values.segment<3>(rotation);
  }
  return product;
}

}  // namespace kinetostat::fea

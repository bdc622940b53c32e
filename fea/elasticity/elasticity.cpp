#include "kinetostat/fea/elasticity/elasticity.h"

#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/fea/mesh/tet_mesh.h"

namespace kinetostat::fea {
namespace {

using Gradients = BarycentricGradients;

Gradients gradients_and_volume(const std::array<Vector3, 4>& p, double& volume_out) {
  Matrix3 edges;
  edges << p[1] - p[0], p[2] - p[0], p[3] - p[0];
  const Vector3 a = edges.col(1).cross(edges.col(2)), b = edges.col(2).cross(edges.col(0)),
                c = edges.col(0).cross(edges.col(1));
  const double six_volumes = edges.col(0).dot(a);
  volume_out = six_volumes / 6;
  Gradients g;
  g.col(1) = a / six_volumes;
  g.col(2) = b / six_volumes;
  g.col(3) = c / six_volumes;
  g.col(0) = -(g.col(1) + g.col(2) + g.col(3));
  return g;
}

// With D(3i+a, 3j+b) the integral of dN_i/dx_a dN_j/dx_b, the stiffness between node i in direction
// a and node j in direction b is lambda D_ab + mu D_ba + mu delta_ab tr D.
template <int Nodes>
ElementStiffness<Nodes> stiffness_from(const ElementStiffness<Nodes>& d, const Material& material) {
  const double lambda = material.lambda(), mu = material.mu();
  ElementStiffness<Nodes> k;
  for (int j = 0; j < Nodes; ++j)
    for (int i = 0; i < Nodes; ++i) {
      const Matrix3 block = d.template block<3, 3>(3 * i, 3 * j);
      Matrix3 stiffness = lambda * block + mu * block.transpose();
      stiffness.diagonal().array() += mu * block.trace();
      k.template block<3, 3>(3 * i, 3 * j) = stiffness;
    }
  return k;
}

// Gradients of the ten shape functions, one below the other, at a point given by its barycentric
// coordinates: corners L_k (2 L_k - 1), middles 4 L_a L_b.
Eigen::Matrix<double, 30, 1> quadratic_gradients(const Gradients& g, const Eigen::Vector4d& l) {
  Eigen::Matrix<double, 30, 1> all;
  for (Eigen::Index k = 0; k < 4; ++k) all.segment<3>(3 * k) = (4 * l[k] - 1) * g.col(k);
  for (std::size_t e = 0; e < tet_edges.size(); ++e) {
    const auto [a, b] = tet_edges[e];
    all.segment<3>(12 + 3 * static_cast<Eigen::Index>(e)) = 4 * (l[b] * g.col(a) + l[a] * g.col(b));
  }
  return all;
}

constexpr double four_point_near = 0.58541019662496845446;  // (5 + 3 sqrt 5) / 20
constexpr double four_point_far = 0.13819660112501051518;   // (5 - sqrt 5) / 20

// Barycentric coordinates of point q of the four of equal weight, exact to second degree.
Eigen::Vector4d four_point(int q) {
  Eigen::Vector4d l = Eigen::Vector4d::Constant(four_point_far);
  l[q] = four_point_near;
  return l;
}

}  // namespace

Material::Material(double young, double poisson, std::optional<double> density)
    : young_(young), poisson_(poisson), density_(density) {
  if (!(young > 0) || !std::isfinite(young))
    throw std::invalid_argument(fmt::format("Young's modulus {} Pa is not above zero", young));
  if (!(poisson > -1 && poisson < 0.5))
    throw std::invalid_argument(
        fmt::format("Poisson's ratio {} is not between -1 and 0.5", poisson));
  if (density && !(*density > 0))
    throw std::invalid_argument(fmt::format("density {} kg/m^3 is not above zero", *density));
}

BarycentricGradients barycentric_gradients(const std::array<Vector3, 4>& corners) {
  double volume = 0;
  return gradients_and_volume(corners, volume);
}

Eigen::Matrix3Xd shape_gradients(const BarycentricGradients& gradients, int order,
                                 const Eigen::Vector4d& point) {
  if (order == 1) return gradients;
  return quadratic_gradients(gradients, point).reshaped(3, 10);
}

ElementStiffness<4> stiffness_tet4(const std::array<Vector3, 4>& corners,
                                   const Material& material) {
  double volume = 0;
  const Gradients g = gradients_and_volume(corners, volume);
  const Eigen::Map<const Eigen::Matrix<double, 12, 1>> all(g.data());
  return stiffness_from<4>(volume * all * all.transpose(), material);
}

ElementStiffness<10> stiffness_tet10(const std::array<Vector3, 4>& corners,
                                     const Material& material) {
  double volume = 0;
  const Gradients g = gradients_and_volume(corners, volume);
  Eigen::Matrix<double, 30, 4> at_points;
  for (int q = 0; q < 4; ++q) at_points.col(q) = quadratic_gradients(g, four_point(q));
  return stiffness_from<10>(volume / 4 * at_points * at_points.transpose(), material);
}

ElementStiffness<10> stiffness_curved_tet10(const std::array<Vector3, 10>& nodes,
                                            const Material& material) {
  // On the unit tetrahedron the barycentric coordinates 1 to 3 are the coordinates.
  Gradients unit = Gradients::Zero();
  unit.rightCols<3>().setIdentity();
  unit.col(0).setConstant(-1);
  Eigen::Matrix<double, 30, 4> at_points;
  for (int q = 0; q < 4; ++q) {
    const Eigen::Matrix<double, 30, 1> local = quadratic_gradients(unit, four_point(q));
    const Eigen::Map<const Eigen::Matrix<double, 3, 10>> by_node(local.data());
    Matrix3 map = Matrix3::Zero();  // d place / d local
    for (std::size_t k = 0; k < 10; ++k)
      map += nodes[k] * by_node.col(static_cast<Eigen::Index>(k)).transpose();
    const Eigen::Matrix<double, 3, 10> gradients = map.inverse().transpose() * by_node;
    at_points.col(q) = std::sqrt(map.determinant() / 24) *
                       Eigen::Map<const Eigen::Matrix<double, 30, 1>>(gradients.data());
  }
  return stiffness_from<10>(at_points * at_points.transpose(), material);
}

}  // namespace kinetostat::fea

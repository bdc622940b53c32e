#include "kinetostat/fea/elasticity/element_mass.h"

#include <array>
#include <cmath>

#include <Eigen/LU>

namespace kinetostat::fea::element_mass {
namespace {

// Of the linear element with volume 1: V / 20, on the diagonal twice that.
Eigen::MatrixXd linear_products() {
  Eigen::MatrixXd products = Eigen::MatrixXd::Constant(4, 4, 1.0 / 20);
  products.diagonal().setConstant(2.0 / 20);
  return products;
}

bool has(const std::array<int, 2>& edge, int corner) {
  return edge[0] == corner || edge[1] == corner;
}

// Between two mid nodes, times 420 / V: the same, of edges that meet, and of opposite ones.
double between(const std::array<int, 2>& a, const std::array<int, 2>& b) {
  if (a == b) return 32;
  return has(a, b[0]) || has(a, b[1]) ? 16 : 8;
}

// Of the quadratic element with straight edges and volume 1, from the integral of products of
// barycentric coordinates, 6 V a! b! c! d! / (3 + a + b + c + d)!.
Eigen::MatrixXd quadratic_products() {
  Eigen::MatrixXd products = Eigen::MatrixXd::Constant(10, 10, 1);
  products.diagonal().setConstant(6);
  for (Eigen::Index e = 0; e < 6; ++e) {
    const auto& edge = tet_edges[static_cast<std::size_t>(e)];
    for (int corner = 0; corner < 4; ++corner)
      products(4 + e, corner) = products(corner, 4 + e) = has(edge, corner) ? -4 : -6;
    for (Eigen::Index f = 0; f < 6; ++f)
      products(4 + e, 4 + f) = between(edge, tet_edges[static_cast<std::size_t>(f)]);
  }
  return products / 420;
}

struct Point {
  Eigen::Vector4d barycentric;
  double weight;  // they sum to 1/6, the volume of the unit tetrahedron
};

// Gauss's five points on each side of a cube that is folded to the unit tetrahedron: exact to
// seventh degree, the fourth of N_i N_j and the third of the volume of a curved element.
std::vector<Point> points_of_seventh_degree() {
  const double near = std::sqrt(5 - 2 * std::sqrt(10.0 / 7)) / 3,
               far = std::sqrt(5 + 2 * std::sqrt(10.0 / 7)) / 3, root = 13 * std::sqrt(70.0);
  const std::array<double, 5> place{-far, -near, 0, near, far};
  const std::array<double, 5> weight{(322 - root) / 900, (322 + root) / 900, 128.0 / 225,
                                     (322 + root) / 900, (322 - root) / 900};
  std::vector<Point> points;
  for (std::size_t i = 0; i < 5; ++i)
    for (std::size_t j = 0; j < 5; ++j)
      for (std::size_t k = 0; k < 5; ++k) {
        const double u = (1 + place[i]) / 2, v = (1 + place[j]) / 2, w = (1 + place[k]) / 2;
        const Vector3 p(u, (1 - u) * v, (1 - u) * (1 - v) * w);
        points.push_back(
            {.barycentric = {1 - p.sum(), p.x(), p.y(), p.z()},
             .weight = weight[i] * weight[j] * weight[k] / 8 * (1 - u) * (1 - u) * (1 - v)});
      }
  return points;
}

Eigen::Matrix<double, 10, 1> quadratic_shapes(const Eigen::Vector4d& l) {
  Eigen::Matrix<double, 10, 1> shapes;
  for (Eigen::Index k = 0; k < 4; ++k) shapes[k] = l[k] * (2 * l[k] - 1);
  for (std::size_t e = 0; e < tet_edges.size(); ++e)
    shapes[4 + static_cast<Eigen::Index>(e)] = 4 * l[tet_edges[e][0]] * l[tet_edges[e][1]];
  return shapes;
}

Eigen::MatrixXd curved_products(const std::array<Vector3, 10>& nodes) {
  static const std::vector<Point> points = points_of_seventh_degree();
  const Eigen::Map<const Eigen::Matrix<double, 3, 10>> places(nodes[0].data());
  BarycentricGradients unit = BarycentricGradients::Zero();
  unit.rightCols<3>().setIdentity();
  unit.col(0).setConstant(-1);
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(10, 10);
  for (const Point& point : points) {
    const Matrix3 map = places * shape_gradients(unit, 2, point.barycentric).transpose();
    const Eigen::Matrix<double, 10, 1> shapes = quadratic_shapes(point.barycentric);
    products += point.weight * map.determinant() * shapes * shapes.transpose();
  }
  return products;
}

}  // namespace
}  // namespace kinetostat::fea::element_mass

namespace kinetostat::fea {

Eigen::MatrixXd shape_products(const TetMesh& mesh, std::size_t element) {
  static const Eigen::MatrixXd linear = element_mass::linear_products(),
                               quadratic = element_mass::quadratic_products();
  if (mesh.curved) return element_mass::curved_products(mesh.all_nodes(element));
  return volume(mesh.corners(element)) * (mesh.order == 2 ? quadratic : linear);
}

Eigen::Matrix3Xd inertial_forces(const TetMesh& mesh, const std::vector<Material>& materials,
                                 const Eigen::Matrix3Xd& accelerations) {
  Eigen::Matrix3Xd forces = Eigen::Matrix3Xd::Zero(3, accelerations.cols());
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const std::optional<double>& density = materials[mesh.material_of(e)].density();
    if (!density) continue;
    const auto nodes = mesh.element(e);
    forces(Eigen::all, nodes) +=
        *density * Eigen::Matrix3Xd(accelerations(Eigen::all, nodes)) * shape_products(mesh, e);
  }
  return forces;
}

std::optional<RigidMass> rigid_mass(const TetMesh& mesh, const std::vector<Material>& materials) {
  struct Part {
    double mass;
    Vector3 center;
  };
  RigidMass all;
  std::vector<Part> parts;
  for (std::size_t m = 0; m < materials.size(); ++m) {
    if (!materials[m].density()) return {};
    const MassProperties own = mass_properties(mesh, m);
    parts.push_back({*materials[m].density() * own.volume, own.centroid});
    all.mass += parts.back().mass;
    all.center += parts.back().mass * own.centroid;
    all.inertia += inertia(own, *materials[m].density());
  }
  all.center /= all.mass;
  for (const Part& part : parts) {
    const Vector3 arm = part.center - all.center;
    all.inertia += part.mass * (arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose());
  }
  return all;
}

}  // namespace kinetostat::fea

#include "kinetostat/fea/elasticity/potential.h"

#include <Eigen/SparseCholesky>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {
namespace {

using common::at;

constexpr int held = -2, unused = -1;

// Numbers of the free corner nodes; `held` for those with a given value.
std::vector<int> number_unknowns(const TetMesh& mesh, const std::vector<int>& low,
                                 const std::vector<int>& high, int& count) {
  std::vector<int> number(mesh.nodes.size(), unused);
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    for (const int node : mesh.element(e).first(4)) number[at(node)] = 0;
  for (const auto* nodes : {&low, &high})
    for (const int node : *nodes) number[at(node)] = held;
  count = 0;
  for (int& n : number)
    if (n == 0) n = count++;
  return number;
}

// Slopes of the four linear shape functions, one row each.
Eigen::Matrix<double, 4, 3> slopes(const std::array<Vector3, 4>& c) {
  Matrix3 sides;
  sides << c[1] - c[0], c[2] - c[0], c[3] - c[0];
  Eigen::Matrix<double, 4, 3> result;
  result.bottomRows<3>() = sides.inverse();
  result.row(0) = -result.bottomRows<3>().colwise().sum();
  return result;
}

}  // namespace

Eigen::VectorXd potential(const TetMesh& mesh, const std::vector<int>& low,
                          const std::vector<int>& high) {
  int count = 0;
  const std::vector<int> number = number_unknowns(mesh, low, high, count);
  Eigen::VectorXd value = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(mesh.nodes.size()));
  for (const int node : high) value[node] = 1;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd load = Eigen::VectorXd::Zero(count);
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto element = mesh.element(e);
    const Eigen::Matrix<double, 4, 3> g = slopes(mesh.corners(e));
    const Eigen::Matrix4d stiffness = volume(mesh.corners(e)) * g * g.transpose();
    for (int i = 0; i < 4; ++i) {
      const int row = number[at(element[at(i)])];
      if (row < 0) continue;
      for (int j = 0; j < 4; ++j) {
        const int column = number[at(element[at(j)])];
        if (column == held)
          load[row] -= stiffness(i, j) * value[element[at(j)]];
        else if (row >= column)
          entries.emplace_back(row, column, stiffness(i, j));
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXd inner =
      Eigen::SimplicialLLT<Eigen::SparseMatrix<double>>(matrix).solve(load);
  for (std::size_t n = 0; n < number.size(); ++n)
    if (number[n] >= 0) value[static_cast<Eigen::Index>(n)] = inner[number[n]];
  return value;
}

Vector3 flow_centre(const TetMesh& mesh, const Eigen::VectorXd& field,
                    const std::vector<int>& nodes) {
  std::vector<bool> wanted(mesh.nodes.size(), false);
  for (const int node : nodes) wanted[at(node)] = true;
  double flow = 0;
  Vector3 moment = Vector3::Zero();
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const std::array<Vector3, 4> corners = mesh.corners(e);
    const Eigen::Vector4d shares = volume(corners) * slopes(corners) * gradient(mesh, e, field);
    for (std::size_t k = 0; k < 4; ++k) {
      if (!wanted[at(mesh.element(e)[k])]) continue;
      flow += shares[static_cast<Eigen::Index>(k)];
      moment += shares[static_cast<Eigen::Index>(k)] * corners[k];
    }
  }
  return moment / flow;
}

Vector3 gradient(const TetMesh& mesh, std::size_t e, const Eigen::VectorXd& values) {
  const auto element = mesh.element(e);
  const Eigen::Vector4d corners(values[element[0]], values[element[1]], values[element[2]],
                                values[element[3]]);
  return slopes(mesh.corners(e)).transpose() * corners;
}

}  // namespace kinetostat::fea

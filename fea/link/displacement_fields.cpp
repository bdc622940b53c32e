#include "kinetostat/fea/link/displacement_fields.h"

#include <cmath>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/elasticity/stress_recovery.h"

namespace kinetostat::fea {
namespace {

using common::at;

constexpr const char* wrench_names[] = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"};

double von_mises(const Vector6& s) {
  const double normal =
      (s[0] - s[1]) * (s[0] - s[1]) + (s[1] - s[2]) * (s[1] - s[2]) + (s[2] - s[0]) * (s[2] - s[0]);
  return std::sqrt(0.5 * normal + 3 * s.tail<3>().squaredNorm());
}

// Of one load case, from six rows of the stresses at the nodes [Pa].
void add_stresses(const Eigen::MatrixXd& stresses, const std::string& name, io::VtuGrid& grid) {
  io::VtuField tensor{.name = "stress " + name, .components = 6},
      equivalent{.name = "von Mises " + name};
  for (Eigen::Index n = 0; n < stresses.cols(); ++n) {
    const Vector6 s = stresses.col(n);
    tensor.values.insert(tensor.values.end(), s.begin(), s.end());
    equivalent.values.push_back(von_mises(s));
  }
  grid.point_fields.push_back(std::move(tensor));
  grid.point_fields.push_back(std::move(equivalent));
}

io::VtuGrid grid_of(const TetMesh& mesh) {
  io::VtuGrid grid{.cell = mesh.order == 2 ? io::VtuCell::quadratic_tetra : io::VtuCell::tetra,
                   .nodes_per_cell = static_cast<int>(mesh.nodes_per_element()),
                   .connectivity = mesh.connectivity};
  for (const Vector3& p : mesh.nodes) grid.points.insert(grid.points.end(), {p.x(), p.y(), p.z()});
  return grid;
}

void add_displacements(const std::string& name, const Eigen::Matrix3Xd& u, io::VtuGrid& grid) {
  grid.point_fields.push_back({name, 3, {u.data(), u.data() + u.size()}});
}

void add_parts(const TetMesh& mesh, const std::vector<CoupledInterface>& interfaces,
               const Accuracy& accuracy, io::VtuGrid& grid) {
  io::VtuField parts{.name = "interface", .values = std::vector<double>(mesh.nodes.size(), 0)};
  for (const CoupledInterface& interface : interfaces)
    for (const int node : interface.geometry.nodes) parts.values[at(node)] = interface.geometry.tag;
  grid.point_fields.push_back(std::move(parts));
  grid.cell_fields.push_back({.name = "error_indicator", .values = accuracy.indicator});
}

}  // namespace

io::VtuGrid displacement_fields(const LinkResult& result) {
  const TetMesh& mesh = result.mesh;
  io::VtuGrid grid = grid_of(mesh);
  common::ThreadPool alone(1);
  const Stresses at_corners =
      corner_stresses(mesh, result.materials, result.response.fields, alone);
  // Bodies have no node in common, and away from its own the stresses of each are 0.
  Stresses stresses = recovered_stresses(mesh, at_corners, 0, alone);
  for (std::size_t m = 1; m < result.materials.size(); ++m)
    stresses += recovered_stresses(mesh, at_corners, m, alone);
  for (std::size_t j = 0; j < result.response.fields.size(); ++j) {
    const std::string interface =
        result.interfaces.size() == 2 ? "" : result.interfaces[1 + j / 6].name + " ";
    add_displacements(interface + wrench_names[j % 6], result.response.fields[j], grid);
    add_stresses(stresses.middleRows<6>(6 * static_cast<Eigen::Index>(j)),
                 interface + wrench_names[j % 6], grid);
  }
  add_parts(mesh, result.interfaces, result.accuracy, grid);
  return grid;
}

io::VtuGrid mode_shapes(const ModalResult& result) {
  io::VtuGrid grid = grid_of(result.mesh);
  const double shown = 0.1 * bounding_box(result.mesh.nodes).diagonal().norm();
  for (std::size_t k = 0; k < result.shapes.shapes.size(); ++k) {
    const Eigen::Matrix3Xd& shape = result.shapes.shapes[k];
    add_displacements("mode " + std::to_string(k + 1),
                      shown / shape.colwise().norm().maxCoeff() * shape, grid);
  }
  add_parts(result.mesh, result.interfaces, result.accuracy, grid);
  return grid;
}

}  // namespace kinetostat::fea

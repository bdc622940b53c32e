#include "kinetostat/fea/elasticity/geometry_error.h"

#include <cmath>
#include <map>

#include "kinetostat/common/index.h"

namespace kinetostat::fea::boundary_gaps {
namespace {

using common::at;

// Volumes [m^3] between faces and those of the file, by the corners of the face, ascending.
std::map<Triangle, double> gaps_of(const TetMesh& mesh) {
  std::map<Triangle, double> gaps;
  for (std::size_t f = 0; f < mesh.boundary.size(); ++f) {
    if (!(mesh.gaps[f] > 0)) continue;
    const auto& nodes = mesh.boundary[f].nodes;
    const Vector3& origin = mesh.nodes[at(nodes[0])];
    const double area =
        0.5 * (mesh.nodes[at(nodes[1])] - origin).cross(mesh.nodes[at(nodes[2])] - origin).norm();
    gaps[sorted({nodes[0], nodes[1], nodes[2]})] = mesh.gaps[f] * area;
  }
  return gaps;
}

// The upper triangle of s_i : D^-1 s_j, column by column.
Eigen::VectorXd energies(const Eigen::VectorXd& stress, const Material& material) {
  const Eigen::Index cases = stress.size() / 6;
  Eigen::VectorXd all(cases * (cases + 1) / 2);
  Eigen::Index entry = 0;
  for (Eigen::Index j = 0; j < cases; ++j) {
    const Vector6 strain = strain_of(stress.segment<6>(6 * j), material);
    for (Eigen::Index i = 0; i <= j; ++i) all[entry++] = stress.segment<6>(6 * i).dot(strain);
  }
  return all;
}

void add_away_from_zero(const Eigen::VectorXd& parts, Eigen::Ref<Eigen::VectorXd> sum) {
  for (Eigen::Index k = 0; k < parts.size(); ++k)
    sum[k] += std::copysign(std::abs(parts[k]), sum[k]);
}

}  // namespace
}  // namespace kinetostat::fea::boundary_gaps

namespace kinetostat::fea {

Eigen::MatrixXd geometry_error(const TetMesh& mesh, const std::vector<Material>& materials,
                               const Stresses& at_corners, Eigen::MatrixXd& by_element) {
  using namespace boundary_gaps;
  const std::map<Triangle, double> gaps = gaps_of(mesh);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(by_element.rows());
  for (std::size_t e = 0; e < mesh.element_count() && !gaps.empty(); ++e) {
    const auto tet = mesh.element(e);
    for (std::size_t k = 0; k < 4; ++k) {
      const auto gap = gaps.find(sorted({tet[(k + 1) % 4], tet[(k + 2) % 4], tet[(k + 3) % 4]}));
      if (gap == gaps.end()) continue;
      const auto corners = at_corners.middleCols<4>(4 * static_cast<Eigen::Index>(e));
      const Eigen::VectorXd stress =
          (corners.rowwise().sum() - corners.col(static_cast<Eigen::Index>(k))) / 3;
      const Eigen::VectorXd parts = gap->second * energies(stress, materials[mesh.material_of(e)]);
      sum += parts;
      add_away_from_zero(parts, by_element.col(static_cast<Eigen::Index>(e)));
    }
  }
  const Eigen::Index cases = at_corners.rows() / 6;
  Eigen::MatrixXd total(cases, cases);
  Eigen::Index entry = 0;
  for (Eigen::Index j = 0; j < cases; ++j)
    for (Eigen::Index i = 0; i <= j; ++i) total(i, j) = total(j, i) = sum[entry++];
  return total;
}

}  // namespace kinetostat::fea

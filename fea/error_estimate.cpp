#include "kinetostat/fea/error_estimate.h"

#include <Eigen/Cholesky>

namespace kinetostat::fea {
namespace {

// How many corners two edges share.
int shared(const std::array<int, 2>& s, const std::array<int, 2>& t) {
  int count = 0;
  for (const int a : s)
    for (const int b : t) count += a == b ? 1 : 0;
  return count;
}

// Integrals of the products of two shape functions over an element of volume 1.
Eigen::MatrixXd mass_matrix(int order) {
  if (order == 1) {
    Eigen::MatrixXd m = Eigen::MatrixXd::Constant(4, 4, 1.0 / 20);
    m.diagonal().setConstant(1.0 / 10);
    return m;
  }
  Eigen::MatrixXd m(10, 10);
  m.topLeftCorner<4, 4>().setConstant(1);
  m.topLeftCorner<4, 4>().diagonal().setConstant(6);
  constexpr double between_middles[] = {8, 16, 32};
  for (std::size_t s = 0; s < tet_edges.size(); ++s) {
    const auto i = 4 + static_cast<Eigen::Index>(s);
    for (int corner = 0; corner < 4; ++corner) {
      const bool is_end = tet_edges[s][0] == corner || tet_edges[s][1] == corner;
      m(corner, i) = m(i, corner) = is_end ? -4 : -6;
    }
    for (std::size_t t = 0; t < tet_edges.size(); ++t)
      m(i, 4 + static_cast<Eigen::Index>(t)) = between_middles[shared(tet_edges[s], tet_edges[t])];
  }
  return m / 420;
}

// D^-1 : s, with the shear components doubled, because each counts twice in a product of stresses.
Eigen::MatrixXd strains(const Eigen::MatrixXd& stresses, const Material& material) {
  const double direct = (1 + material.poisson()) / material.young();
  const double lateral = material.poisson() / material.young();
  Eigen::MatrixXd result(stresses.rows(), stresses.cols());
  for (Eigen::Index c = 0; c < stresses.cols(); ++c)
    for (Eigen::Index r = 0; r < stresses.rows(); r += 6) {
      const auto s = stresses.block<6, 1>(r, c);
      result.block<3, 1>(r, c) = direct * s.head<3>().array() - lateral * s.head<3>().sum();
      result.block<3, 1>(r + 3, c) = 2 * direct * s.tail<3>();
    }
  return result;
}

// Recovered minus computed stresses at the nodes of an element: both are in the span of the shape
// functions.
Eigen::MatrixXd stress_defect(const TetMesh& mesh, std::size_t e, const Stresses& at_corners,
                              const Stresses& recovered) {
  const auto element = mesh.element(e);
  const auto corners = at_corners.middleCols<4>(4 * static_cast<Eigen::Index>(e));
  Eigen::MatrixXd defect(at_corners.rows(), static_cast<Eigen::Index>(element.size()));
  for (std::size_t n = 0; n < element.size(); ++n) {
    auto column = defect.col(static_cast<Eigen::Index>(n));
    column = recovered.col(element[n]);
    if (n < 4)
      column -= corners.col(static_cast<Eigen::Index>(n));
    else
      column -= 0.5 * (corners.col(tet_edges[n - 4][0]) + corners.col(tet_edges[n - 4][1]));
  }
  return defect;
}

// Adds the elements of one material.
void add_elements(const TetMesh& mesh, std::size_t number, const Material& material,
                  const Stresses& at_corners, ErrorEstimate& error) {
  const Stresses recovered = recovered_stresses(mesh, at_corners, number);
  const Eigen::MatrixXd root = mass_matrix(mesh.order).llt().matrixL();
  const Eigen::Index cases = error.total.rows();
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    if (mesh.material_of(e) != number) continue;
    const Eigen::MatrixXd stress = stress_defect(mesh, e, at_corners, recovered) * root;
    const Eigen::MatrixXd strain = volume(mesh.corners(e)) * strains(stress, material);
    Eigen::Index entry = 0;
    for (Eigen::Index j = 0; j < cases; ++j)
      for (Eigen::Index i = 0; i <= j; ++i) {
        const double part =
            stress.middleRows<6>(6 * i).cwiseProduct(strain.middleRows<6>(6 * j)).sum();
        error.by_element(entry++, static_cast<Eigen::Index>(e)) = part;
        error.total(i, j) += part;
      }
  }
}

}  // namespace

ErrorEstimate estimate_error(const TetMesh& mesh, const std::vector<Material>& materials,
                             const std::vector<Eigen::Matrix3Xd>& displacements) {
  const auto cases = static_cast<Eigen::Index>(displacements.size());
  ErrorEstimate error{
      .total = Eigen::MatrixXd::Zero(cases, cases),
      .by_element = Eigen::MatrixXd(cases * (cases + 1) / 2,
                                    static_cast<Eigen::Index>(mesh.element_count()))};
  const Stresses at_corners = corner_stresses(mesh, materials, displacements);
  for (std::size_t m = 0; m < materials.size(); ++m)
    add_elements(mesh, m, materials[m], at_corners, error);
  error.total.triangularView<Eigen::StrictlyLower>() = error.total.transpose();
  return error;
}

}  // namespace kinetostat::fea

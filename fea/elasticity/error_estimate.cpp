#include "kinetostat/fea/elasticity/error_estimate.h"

#include <Eigen/Cholesky>

#include "kinetostat/fea/elasticity/geometry_error.h"

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
Eigen::MatrixXd linear_mass_matrix() {
  Eigen::MatrixXd m = Eigen::MatrixXd::Constant(4, 4, 1.0 / 20);
  m.diagonal().setConstant(1.0 / 10);
  return m;
}

Eigen::MatrixXd quadratic_mass_matrix() {
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

// One row per node of the element, one column per stress.
using AtNodes = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Recovered minus computed stresses at the nodes of an element: both are in the span of the shape
// functions.
void stress_defect(const TetMesh& mesh, std::size_t e, const Stresses& at_corners,
                   const Stresses& recovered, AtNodes& defect) {
  const auto element = mesh.element(e);
  const auto corners = at_corners.middleCols<4>(4 * static_cast<Eigen::Index>(e));
  defect.resize(static_cast<Eigen::Index>(element.size()), at_corners.rows());
  for (std::size_t n = 0; n < element.size(); ++n) {
    auto row = defect.row(static_cast<Eigen::Index>(n));
    if (n < 4)
      row = (recovered.col(element[n]) - corners.col(static_cast<Eigen::Index>(n))).transpose();
    else
      row = (recovered.col(element[n]) -
             0.5 * (corners.col(tet_edges[n - 4][0]) + corners.col(tet_edges[n - 4][1])))
                .transpose();
  }
}

// The elements of one material.
class Contributions {
 public:
  Contributions(const TetMesh& mesh, const Material& material, const Stresses& at_corners,
                const Stresses& recovered)
      : mesh_(mesh),
        material_(material),
        at_corners_(at_corners),
        recovered_(recovered),
        root_((mesh.order == 1 ? linear_mass_matrix() : quadratic_mass_matrix()).llt().matrixU()) {}

  // What element e adds to the upper triangle of the error matrix, column by column.
  void of(std::size_t e, Eigen::Ref<Eigen::VectorXd> parts) {
    stress_defect(mesh_, e, at_corners_, recovered_, defect_);
    parts.setZero();
    const Eigen::Index cases = defect_.cols() / 6;
    for (Eigen::Index a = 0; a < root_.rows(); ++a) {
      stress_.setZero(defect_.cols());
      for (Eigen::Index b = a; b < root_.cols(); ++b)
        stress_ += root_(a, b) * defect_.row(b).transpose();
      Eigen::Index entry = 0;
      for (Eigen::Index j = 0; j < cases; ++j) {
        const Vector6 strain_j = strain_of(stress_.segment<6>(6 * j), material_);
        for (Eigen::Index i = 0; i <= j; ++i)
          parts[entry++] += stress_.segment<6>(6 * i).dot(strain_j);
      }
    }
    parts *= volume(mesh_.corners(e));
  }

 private:
  const TetMesh& mesh_;
  const Material& material_;
  const Stresses &at_corners_, &recovered_;
  const Eigen::MatrixXd root_;
  AtNodes defect_;
  Eigen::VectorXd stress_;
};

void add_elements(const TetMesh& mesh, std::size_t number, const Material& material,
                  const Stresses& at_corners, ErrorEstimate& error, common::ThreadPool& pool) {
  constexpr std::size_t at_once = 1024;
  const Stresses recovered = recovered_stresses(mesh, at_corners, number, pool);
  pool.for_each_piece(mesh.element_count(), at_once, [&](int, std::size_t begin, std::size_t end) {
    Contributions contributions(mesh, material, at_corners, recovered);
    for (std::size_t e = begin; e < end; ++e)
      if (mesh.material_of(e) == number)
        contributions.of(e, error.by_element.col(static_cast<Eigen::Index>(e)));
  });
}

}  // namespace

ErrorEstimate estimate_error(const TetMesh& mesh, const std::vector<Material>& materials,
                             const std::vector<Eigen::Matrix3Xd>& displacements,
                             common::ThreadPool& pool) {
  const auto cases = static_cast<Eigen::Index>(displacements.size());
  ErrorEstimate error{
      .total = Eigen::MatrixXd(cases, cases),
      .by_element = Eigen::MatrixXd(cases * (cases + 1) / 2,
                                    static_cast<Eigen::Index>(mesh.element_count()))};
  const Stresses at_corners = corner_stresses(mesh, materials, displacements, pool);
  for (std::size_t m = 0; m < materials.size(); ++m)
    add_elements(mesh, m, materials[m], at_corners, error, pool);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(error.by_element.rows());
  for (Eigen::Index e = 0; e < error.by_element.cols(); ++e) sum += error.by_element.col(e);
  Eigen::Index entry = 0;
  for (Eigen::Index j = 0; j < cases; ++j)
    for (Eigen::Index i = 0; i <= j; ++i) error.total(i, j) = error.total(j, i) = sum[entry++];
  if (!mesh.gaps.empty())
    error.geometry = geometry_error(mesh, materials, at_corners, error.by_element);
  return error;
}

}  // namespace kinetostat::fea

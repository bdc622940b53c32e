#include "kinetostat/fea/link/reduced_model.h"

#include <optional>
#include <span>

#include "kinetostat/fea/elasticity/element_mass.h"
#include "kinetostat/fea/interface/reduced_stiffness.h"
#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::fea::reduced_model {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Displacements that span those of the reduced model: rigid motions at the point of the first
// interface, answers to the unit wrenches, and modes.
class Fields {
 public:
  Fields(const TetMesh& mesh, const Vector3& point, const LinkResponse& response,
         const LinkModes& modes)
      : mesh_(mesh), point_(point) {
    for (const auto* list : {&response.fields, &modes.shapes})
      for (const Eigen::Matrix3Xd& field : *list) fields_.push_back(&field);
  }

  Index count() const { return 6 + static_cast<Index>(fields_.size()); }

  // Component `axis` at the nodes of an element, a column for each field.
  void at_nodes(std::span<const int> nodes, Index axis, MatrixXd& values) const {
    values.resize(static_cast<Index>(nodes.size()), count());
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      const auto row = static_cast<Index>(n);
      const Vector3 arm = mesh_.nodes[static_cast<std::size_t>(nodes[n])] - point_;
      values.row(row).head<6>() = spatial::rigid_motion(arm).row(axis);
      for (std::size_t k = 0; k < fields_.size(); ++k)
        values(row, 6 + static_cast<Index>(k)) = (*fields_[k])(axis, nodes[n]);
    }
  }

 private:
  const TetMesh& mesh_;
  Vector3 point_;
  std::vector<const Eigen::Matrix3Xd*> fields_;
};

// F' M F.
MatrixXd mass_between(const TetMesh& mesh, const std::vector<Material>& materials,
                      const Fields& fields) {
  MatrixXd mass = MatrixXd::Zero(fields.count(), fields.count()), values;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const std::optional<double>& density = materials[mesh.material_of(e)].density();
    if (!density) continue;
    const MatrixXd products = *density * shape_products(mesh, e);
    for (Index axis = 0; axis < 3; ++axis) {
      fields.at_nodes(mesh.element(e), axis, values);
      mass.noalias() += values.transpose() * (products * values).eval();
    }
  }
  return mass;
}

// The fields in unit motions of each interface with the others at rest, and the modes alone. The
// wrenches on the loaded interfaces leave the first at rest: what that moves by, all do.
MatrixXd shares_of_fields(const MatrixXd& stiffness, Index modes) {
  const Index motions = stiffness.rows(), loaded = motions - 6;
  MatrixXd shares = MatrixXd::Zero(motions + modes, motions + modes);
  shares.topLeftCorner<6, 6>().setIdentity();
  shares.block(6, 0, loaded, motions) = stiffness.bottomRows(loaded);
  shares.bottomRightCorner(modes, modes).setIdentity();
  return shares;
}

MatrixXd symmetric(const MatrixXd& matrix) { return 0.5 * (matrix + matrix.transpose()); }

}  // namespace
}  // namespace kinetostat::fea::reduced_model

namespace kinetostat::fea {

Eigen::MatrixXd guyan_mass(const TetMesh& mesh, const std::vector<Material>& materials,
                           const std::vector<CoupledInterface>& interfaces,
                           const LinkResponse& response) {
  return craig_bampton(mesh, materials, interfaces, response, {}).mass;
}

ReducedModel craig_bampton(const TetMesh& mesh, const std::vector<Material>& materials,
                           const std::vector<CoupledInterface>& interfaces,
                           const LinkResponse& response, const LinkModes& held) {
  using namespace reduced_model;
  const MatrixXd stiffness = reduced_stiffness(response.flexibility, interfaces);
  const Index motions = stiffness.rows(), modes = static_cast<Index>(held.shapes.size());
  const Fields fields(mesh, interfaces.front().point, response, held);
  const MatrixXd shares = shares_of_fields(stiffness, modes);
  ReducedModel model{
      .stiffness = MatrixXd::Zero(motions + modes, motions + modes),
      .mass = symmetric(shares.transpose() * mass_between(mesh, materials, fields) * shares),
      .interface_motions = motions};
  model.stiffness.topLeftCorner(motions, motions) = stiffness;
  if (modes > 0) model.stiffness.diagonal().tail(modes) = held.omega_squared;
  return model;
}

Eigen::VectorXd natural_frequencies_squared(const Eigen::MatrixXd& stiffness,
                                            const Eigen::MatrixXd& mass) {
  // Lengths, angles and modes differ by orders of magnitude: with a diagonal of ones first.
  const Eigen::VectorXd scale = mass.diagonal().cwiseSqrt().cwiseInverse();
  const spatial::SymmetricEigen unit =
      spatial::symmetric_eigen(scale.asDiagonal() * mass * scale.asDiagonal());
  const Eigen::MatrixXd to_unit_mass =
      scale.asDiagonal() * unit.vectors * unit.values.cwiseSqrt().cwiseInverse().asDiagonal();
  return spatial::symmetric_eigen(
             reduced_model::symmetric(to_unit_mass.transpose() * stiffness * to_unit_mass))
      .values;
}

}  // namespace kinetostat::fea

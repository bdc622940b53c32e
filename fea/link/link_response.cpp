#include "kinetostat/fea/link/link_response.h"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>

#include <Eigen/Cholesky>

#include "kinetostat/fea/elasticity/isostatic_support.h"
#include "kinetostat/fea/interface/average_motion.h"
#include "kinetostat/fea/interface/elastic_layer.h"
#include "kinetostat/fea/interface/stiff_body.h"

namespace kinetostat::fea {
namespace {

// Motion [translation; rotation] at `to` of a body that has the motion q at `from`: shift * q.
Matrix6 shift(const Vector3& from, const Vector3& to) {
  Matrix6 matrix = Matrix6::Identity();
  matrix.topRightCorner<3, 3>() = -spatial::skew(to - from);
  return matrix;
}

// Where the first rigid interface is held, it needs no unknowns; the others are bodies. Without a
// rigid one, the body behind the first elastic layer is held. The bodies behind other layers move.
struct Holding {
  std::optional<std::size_t> held;
  std::vector<std::size_t> body_of;  // of each interface: number of its reference body, if rigid
  std::vector<ReferenceBody> bodies;
  std::vector<std::size_t> elastic;  // interfaces whose bodies move
};

Holding holding_of(const std::vector<CoupledInterface>& interfaces) {
  Holding holding{.held = {},
                  .body_of = std::vector<std::size_t>(interfaces.size()),
                  .bodies = {},
                  .elastic = {}};
  for (std::size_t i = 0; i < interfaces.size(); ++i) {
    if (interfaces[i].coupling != Coupling::rigid) continue;
    if (!holding.held) {
      holding.held = i;
    } else {
      holding.body_of[i] = holding.bodies.size();
      holding.bodies.push_back({interfaces[i].point, interfaces[i].geometry.nodes});
    }
  }
  for (std::size_t i = 0; i < interfaces.size(); ++i) {
    if (interfaces[i].coupling != Coupling::elastic) continue;
    if (holding.held)
      holding.elastic.push_back(i);
    else
      holding.held = i;
  }
  return holding;
}

std::vector<GroundSpring> springs_of_layers(const TetMesh& mesh,
                                            const std::vector<CoupledInterface>& interfaces) {
  std::vector<GroundSpring> springs;
  for (const CoupledInterface& interface : interfaces)
    if (interface.coupling == Coupling::elastic)
      for (const auto& [node, stiffness] : layer_springs(mesh, interface.geometry, interface.layer))
        springs.push_back({node, stiffness});
  return springs;
}

DofMap unknowns_of(const TetMesh& mesh, const std::vector<Material>& materials,
                   const std::vector<CoupledInterface>& interfaces, const Holding& holding) {
  const bool is_clamped = holding.held && interfaces[*holding.held].coupling == Coupling::rigid;
  DofMap unknowns(mesh, is_clamped ? interfaces[*holding.held].geometry.nodes : std::vector<int>{},
                  holding.bodies);
  unknowns.set_springs(springs_of_layers(mesh, interfaces));
  if (!holding.held)
    unknowns.set_springs(isostatic_support(mesh, unknowns, materials.front().young()));
  return unknowns;
}

// How loads and motions of the interfaces become those of the unknowns.
class Couplings {
 public:
  Couplings(const TetMesh& mesh, const std::vector<Material>& materials,
            const std::vector<CoupledInterface>& interfaces)
      : mesh_(mesh),
        interfaces_(interfaces),
        holding_(holding_of(interfaces)),
        unknowns_(unknowns_of(mesh, materials, interfaces, holding_)) {
    for (const CoupledInterface& interface : interfaces)
      average_motions_.emplace_back(mesh, interface.geometry, interface.point);
    add_layers();
  }

  const DofMap& unknowns() const { return unknowns_; }

  // Of the equations: behind each layer whose body moves, the forces of the layer in its six unit
  // motions come after the load cases.
  Eigen::MatrixXd right_hand_sides() const {
    if (motion_rows() == 0) return loads();
    const Eigen::MatrixXd all = loads();
    Eigen::MatrixXd sides(unknown_rows(), all.cols() + motion_rows());
    sides << all.topRows(unknown_rows()), layer_forces_;
    return sides;
  }

  // The unknowns and the motions of bodies behind layers in each load case, from the solutions for
  // right_hand_sides(): layers hold these bodies with D, and what the link gives way to.
  Eigen::MatrixXd solutions(Eigen::MatrixXd x) const {
    const Eigen::Index bodies = motion_rows(), cases = x.cols() - bodies;
    if (bodies == 0) return x;
    const auto held = x.leftCols(cases), moved = x.rightCols(bodies);
    const Eigen::MatrixXd stiffness = layer_stiffness_ - layer_forces_.transpose() * moved;
    Eigen::MatrixXd all(unknown_rows() + bodies, cases);
    all.bottomRows(bodies) =
        (0.5 * (stiffness + stiffness.transpose()))
            .llt()
            .solve(loads().bottomRows(bodies) + layer_forces_.transpose() * held);
    all.topRows(unknown_rows()) = held + moved * all.bottomRows(bodies);
    return all;
  }

  // One column for each load case; below the unknowns the wrenches on bodies behind layers.
  Eigen::MatrixXd loads() const {
    const std::size_t loaded = interfaces_.size() - 1;
    Eigen::MatrixXd loads = Eigen::MatrixXd::Zero(unknown_rows() + motion_rows(),
                                                  6 * static_cast<Eigen::Index>(loaded));
    for (std::size_t i = 1; i <= loaded; ++i) {
      auto columns = loads.middleCols<6>(6 * static_cast<Eigen::Index>(i - 1));
      add_wrenches(i, Matrix6::Identity(), columns);
      // A wrench and its reaction together do no work in a rigid motion.
      add_wrenches(0, -from_first(i).transpose(), columns);
    }
    return loads;
  }

  // Displacements of all nodes, and the motions of all interfaces, with the first one at rest.
  struct Motions {
    Eigen::Matrix3Xd nodes;
    std::vector<Vector6> interfaces;
  };
  Motions motions(const Eigen::VectorXd& solution) const {
    Motions all{.nodes = unknowns_.displacements(mesh_, solution), .interfaces = {}};
    for (std::size_t i = 0; i < interfaces_.size(); ++i)
      all.interfaces.push_back(motion(i, solution, all.nodes));
    if (holding_.held == std::size_t{0}) return all;
    const Vector6 first = all.interfaces.front();
    for (std::size_t i = 0; i < interfaces_.size(); ++i) all.interfaces[i] -= from_first(i) * first;
    for (std::size_t n = 0; n < mesh_.nodes.size(); ++n)
      all.nodes.col(static_cast<Eigen::Index>(n)) -=
          spatial::rigid_motion(mesh_.nodes[n] - interfaces_.front().point) * first;
    return all;
  }

  // Root mean square departure of each interface from its rigid motion, beside the largest root
  // mean square displacement of any.
  std::vector<double> fit_residuals(const Motions& motions) const {
    std::vector<double> residuals;
    double most = 0;
    for (std::size_t i = 0; i < interfaces_.size(); ++i) {
      const bool rigid = interfaces_[i].coupling == Coupling::rigid;
      most = std::max(most, average_motions_[i].departure(motions.nodes, Vector6::Zero()));
      residuals.push_back(
          rigid ? 0 : average_motions_[i].departure(motions.nodes, motions.interfaces[i]));
    }
    for (double& residual : residuals) residual /= most;
    return residuals;
  }

 private:
  Eigen::Index unknown_rows() const { return Eigen::Index{3} * unknowns_.blocks(); }
  Eigen::Index motion_rows() const {
    return 6 * static_cast<Eigen::Index>(holding_.elastic.size());
  }
  // First of the rows below the unknowns of the body behind the layer of interface i; none where
  // there is no such body.
  std::optional<Eigen::Index> motion_row(std::size_t i) const {
    const auto found = std::find(holding_.elastic.begin(), holding_.elastic.end(), i);
    if (found == holding_.elastic.end()) return {};
    return unknown_rows() + 6 * (found - holding_.elastic.begin());
  }

  // Forces on the unknowns in unit motions of the bodies behind layers, and the wrenches that the
  // motions take while the link rests.
  void add_layers() {
    layer_forces_.setZero(unknown_rows(), motion_rows());
    layer_stiffness_.setZero(motion_rows(), motion_rows());
    for (std::size_t k = 0; k < holding_.elastic.size(); ++k) {
      const CoupledInterface& interface = interfaces_[holding_.elastic[k]];
      const auto first = 6 * static_cast<Eigen::Index>(k);
      for (const auto& [node, spring] : layer_springs(mesh_, interface.geometry, interface.layer)) {
        const auto motion = spatial::rigid_motion(
            Vector3(mesh_.nodes[static_cast<std::size_t>(node)] - interface.point));
        layer_forces_.block<3, 6>(3 * Eigen::Index{unknowns_.block_of(node)}, first) +=
            spring * motion;
        layer_stiffness_.block<6, 6>(first, first) += motion.transpose() * spring * motion;
      }
    }
  }

  Matrix6 from_first(std::size_t i) const {
    return shift(interfaces_.front().point, interfaces_[i].point);
  }

  // Adds wrenches at the point of interface i, one column each.
  void add_wrenches(std::size_t i, const Matrix6& wrenches,
                    Eigen::Ref<Eigen::MatrixXd> loads) const {
    if (holding_.held == i) return;
    if (const auto row = motion_row(i)) {
      loads.middleRows<6>(*row) += wrenches;
      return;
    }
    if (interfaces_[i].coupling == Coupling::rigid) {
      loads.middleRows<6>(3 * Eigen::Index{unknowns_.body_block(holding_.body_of[i])}) += wrenches;
      return;
    }
    const std::vector<int>& nodes = average_motions_[i].nodes();
    const Eigen::MatrixXd forces = average_motions_[i].nodal_forces() * wrenches;
    for (std::size_t n = 0; n < nodes.size(); ++n)
      loads.middleRows<3>(3 * Eigen::Index{unknowns_.block_of(nodes[n])}) +=
          forces.middleRows<3>(3 * static_cast<Eigen::Index>(n));
  }

  Vector6 motion(std::size_t i, const Eigen::VectorXd& solution,
                 const Eigen::Matrix3Xd& nodes) const {
    if (holding_.held == i) return Vector6::Zero();
    if (const auto row = motion_row(i)) return solution.segment<6>(*row);
    if (interfaces_[i].coupling == Coupling::rigid)
      return solution.segment<6>(3 * Eigen::Index{unknowns_.body_block(holding_.body_of[i])});
    return average_motions_[i].of(nodes);
  }

  const TetMesh& mesh_;
  const std::vector<CoupledInterface>& interfaces_;
  Holding holding_;
  DofMap unknowns_;
  std::vector<AverageMotion> average_motions_;
  Eigen::MatrixXd layer_forces_, layer_stiffness_;
};

}  // namespace

Solid with_stiff_bodies(const TetMesh& mesh, const std::vector<Material>& materials,
                        const std::vector<CoupledInterface>& interfaces) {
  Solid solid{mesh, materials};
  for (const CoupledInterface& interface : interfaces) {
    if (interface.coupling != Coupling::body) continue;
    grow_stiff_body(solid.mesh, interface.geometry, static_cast<int>(solid.materials.size()));
    const Material& stiffest = *std::max_element(
        materials.begin(), materials.end(),
        [](const Material& a, const Material& b) { return a.young() < b.young(); });
    solid.materials.emplace_back(interface.modulus_ratio * stiffest.young(), stiffest.poisson());
  }
  return solid;
}

spatial::Compliance6 compliance_of(const Eigen::MatrixXd& flexibility,
                                   const std::vector<CoupledInterface>& interfaces, std::size_t i) {
  const auto first = 6 * static_cast<Eigen::Index>(i - 1);
  const Matrix6 block = flexibility.block<6, 6>(first, first);
  return spatial::Compliance6(0.5 * (block + block.transpose()), {.point = interfaces[i].point});
}

LinkResponse respond(const TetMesh& mesh, const std::vector<Material>& materials,
                     const std::vector<CoupledInterface>& interfaces, const SolverOptions& options,
                     common::Progress& progress) {
  if (interfaces.size() < 2) throw std::invalid_argument("respond: two interfaces at least");
  const Solid solid = with_stiff_bodies(mesh, materials, interfaces);
  const Couplings couplings(solid.mesh, solid.materials, interfaces);
  Solution solution = solve(solid.mesh, solid.materials, couplings.unknowns(),
                            couplings.right_hand_sides(), options, progress);
  const Eigen::MatrixXd solutions = couplings.solutions(std::move(solution.x));
  LinkResponse response;
  response.solver = solution.stats;
  const Eigen::Index cases = solutions.cols();
  response.flexibility.resize(cases, cases);
  response.fit_residuals.assign(interfaces.size(), 0.0);
  for (Eigen::Index j = 0; j < cases; ++j) {
    Couplings::Motions motions = couplings.motions(solutions.col(j));
    for (std::size_t i = 1; i < interfaces.size(); ++i)
      response.flexibility.col(j).segment<6>(6 * static_cast<Eigen::Index>(i - 1)) =
          motions.interfaces[i];
    const std::vector<double> residuals = couplings.fit_residuals(motions);
    std::transform(residuals.begin(), residuals.end(), response.fit_residuals.begin(),
                   response.fit_residuals.begin(),
                   [](double a, double b) { return std::max(a, b); });
    response.fields.push_back(motions.nodes.leftCols(static_cast<Eigen::Index>(mesh.nodes.size())));
  }
  return response;
}

}  // namespace kinetostat::fea

#include "kinetostat/fea/link/link_response.h"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>

#include "kinetostat/fea/elasticity/isostatic_support.h"
#include "kinetostat/fea/interface/average_motion.h"
#include "kinetostat/fea/interface/stiff_body.h"

namespace kinetostat::fea {
namespace {

// Motion [translation; rotation] at `to` of a body that has the motion q at `from`: shift * q.
Matrix6 shift(const Vector3& from, const Vector3& to) {
  Matrix6 matrix = Matrix6::Identity();
  matrix.topRightCorner<3, 3>() = -spatial::skew(to - from);
  return matrix;
}

// Where the first rigid interface is held, it needs no unknowns; the others are bodies.
struct Holding {
  std::optional<std::size_t> held;
  std::vector<std::size_t> body_of;  // of each interface: number of its reference body, if rigid
  std::vector<ReferenceBody> bodies;
};

Holding holding_of(const std::vector<CoupledInterface>& interfaces) {
  Holding holding{.held = {}, .body_of = std::vector<std::size_t>(interfaces.size()), .bodies = {}};
  for (std::size_t i = 0; i < interfaces.size(); ++i) {
    if (interfaces[i].coupling != Coupling::rigid) continue;
    if (!holding.held) {
      holding.held = i;
    } else {
      holding.body_of[i] = holding.bodies.size();
      holding.bodies.push_back({interfaces[i].point, interfaces[i].geometry.nodes});
    }
  }
  return holding;
}

DofMap unknowns_of(const TetMesh& mesh, const std::vector<Material>& materials,
                   const std::vector<CoupledInterface>& interfaces, const Holding& holding) {
  DofMap unknowns(mesh,
                  holding.held ? interfaces[*holding.held].geometry.nodes : std::vector<int>{},
                  holding.bodies);
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
  }

  const DofMap& unknowns() const { return unknowns_; }

  // One column for each load case.
  Eigen::MatrixXd loads() const {
    const std::size_t loaded = interfaces_.size() - 1;
    Eigen::MatrixXd loads =
        Eigen::MatrixXd::Zero(3 * unknowns_.blocks(), 6 * static_cast<Eigen::Index>(loaded));
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
  Matrix6 from_first(std::size_t i) const {
    return shift(interfaces_.front().point, interfaces_[i].point);
  }

  // Adds wrenches at the point of interface i, one column each.
  void add_wrenches(std::size_t i, const Matrix6& wrenches,
                    Eigen::Ref<Eigen::MatrixXd> loads) const {
    if (holding_.held == i) return;
    if (interfaces_[i].coupling == Coupling::rigid) {
      loads.middleRows<6>(3 * unknowns_.body_block(holding_.body_of[i])) += wrenches;
      return;
    }
    const std::vector<int>& nodes = average_motions_[i].nodes();
    const Eigen::MatrixXd forces = average_motions_[i].nodal_forces() * wrenches;
    for (std::size_t n = 0; n < nodes.size(); ++n)
      loads.middleRows<3>(3 * unknowns_.block_of(nodes[n])) +=
          forces.middleRows<3>(3 * static_cast<Eigen::Index>(n));
  }

  Vector6 motion(std::size_t i, const Eigen::VectorXd& solution,
                 const Eigen::Matrix3Xd& nodes) const {
    if (holding_.held == i) return Vector6::Zero();
    if (interfaces_[i].coupling == Coupling::rigid)
      return solution.segment<6>(3 * unknowns_.body_block(holding_.body_of[i]));
    return average_motions_[i].of(nodes);
  }

  const TetMesh& mesh_;
  const std::vector<CoupledInterface>& interfaces_;
  Holding holding_;
  DofMap unknowns_;
  std::vector<AverageMotion> average_motions_;
};

}  // namespace

Solid with_stiff_bodies(const TetMesh& mesh, const std::vector<Material>& materials,
                        const std::vector<CoupledInterface>& interfaces) {
  Solid solid{mesh, materials};
  for (const CoupledInterface& interface : interfaces) {
    if (interface.coupling != Coupling::body) continue;
    grow_stiff_body(solid.mesh, interface.geometry, static_cast<int>(solid.materials.size()));
    const Material& link = materials.front();
    solid.materials.emplace_back(interface.modulus_ratio * link.young(), link.poisson());
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
  const Solution solution = solve(solid.mesh, solid.materials, couplings.unknowns(),
                                  couplings.loads(), options, progress);
  LinkResponse response;
  response.solver = solution.stats;
  const Eigen::Index cases = solution.x.cols();
  response.flexibility.resize(cases, cases);
  response.fit_residuals.assign(interfaces.size(), 0.0);
  for (Eigen::Index j = 0; j < cases; ++j) {
    Couplings::Motions motions = couplings.motions(solution.x.col(j));
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

#include "kinetostat/fea/link/modes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include <Eigen/Cholesky>

#include "kinetostat/common/index.h"
#include "kinetostat/common/memory.h"
#include "kinetostat/fea/elasticity/isostatic_support.h"
#include "kinetostat/fea/interface/average_motion.h"
#include "kinetostat/fea/interface/elastic_layer.h"
#include "kinetostat/fea/linear_algebra/block_lanczos.h"
#include "kinetostat/fea/link/link_response.h"

namespace kinetostat::fea::vibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

bool is_rigid(const CoupledInterface& interface) { return interface.coupling == Coupling::rigid; }
bool is_elastic(const CoupledInterface& interface) {
  return interface.coupling == Coupling::elastic;
}

// The unknowns, and which of the interfaces that are held give the nodes of theirs none.
struct Freedoms {
  DofMap unknowns;
  std::vector<const CoupledInterface*> held_evenly;  // not rigid: their mean motion is none
  bool floats;                                       // on springs

  Freedoms(const TetMesh& mesh, const std::vector<Material>& materials,
           const std::vector<CoupledInterface>& interfaces, Support support)
      : unknowns(mesh, fixed_nodes(interfaces, support), bodies(interfaces, support)),
        floats(fixed_nodes(interfaces, support).empty()) {
    for (std::size_t i = 0; i < interfaces.size(); ++i)
      if (is_held(i, support) && !is_rigid(interfaces[i]) && !is_elastic(interfaces[i]))
        held_evenly.push_back(&interfaces[i]);
    std::vector<GroundSpring> springs = layers(mesh, interfaces, support);
    floats = floats && springs.empty();
    if (floats) springs = isostatic_support(mesh, unknowns, materials.front().young());
    unknowns.set_springs(std::move(springs));
  }

 private:
  static bool is_held(std::size_t interface, Support support) {
    return support == Support::all_interfaces ||
           (support == Support::first_interface && interface == 0);
  }
  static std::vector<int> fixed_nodes(const std::vector<CoupledInterface>& interfaces,
                                      Support support) {
    std::vector<int> nodes;
    for (std::size_t i = 0; i < interfaces.size(); ++i)
      if (is_held(i, support) && is_rigid(interfaces[i]))
        nodes.insert(nodes.end(), interfaces[i].geometry.nodes.begin(),
                     interfaces[i].geometry.nodes.end());
    return nodes;
  }
  // Those to bodies that are held. Behind other layers nothing has mass, and they carry nothing.
  static std::vector<GroundSpring> layers(const TetMesh& mesh,
                                          const std::vector<CoupledInterface>& interfaces,
                                          Support support) {
    std::vector<GroundSpring> springs;
    for (std::size_t i = 0; i < interfaces.size(); ++i)
      if (is_held(i, support) && is_elastic(interfaces[i]))
        for (const auto& [node, stiffness] :
             layer_springs(mesh, interfaces[i].geometry, interfaces[i].layer))
          springs.push_back({node, stiffness});
    return springs;
  }
  static std::vector<ReferenceBody> bodies(const std::vector<CoupledInterface>& interfaces,
                                           Support support) {
    std::vector<ReferenceBody> bodies;
    for (std::size_t i = 0; i < interfaces.size(); ++i)
      if (!is_held(i, support) && is_rigid(interfaces[i]))
        bodies.push_back({interfaces[i].point, interfaces[i].geometry.nodes});
    return bodies;
  }
};

// The unknowns of the six rigid motions [translation; rotation] at a point.
MatrixXd rigid_motions(const TetMesh& mesh, const DofMap& unknowns, const Vector3& point) {
  MatrixXd motions(Index{3} * unknowns.blocks(), 6);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    if (const int block = unknowns.block_of(static_cast<int>(n)); block >= 0)
      motions.middleRows<3>(Index{3} * block) = spatial::rigid_motion(mesh.nodes[n] - point);
  for (std::size_t b = 0; b < unknowns.bodies().size(); ++b) {
    auto rows = motions.middleRows<6>(Index{3} * unknowns.body_block(b));
    rows.setIdentity();
    rows.topRows<3>() = spatial::rigid_motion(unknowns.bodies()[b].point - point);
  }
  return motions;
}

// G of average_motion.h on the unknowns.
MatrixXd mean_motion(const TetMesh& mesh, const DofMap& unknowns,
                     const CoupledInterface& interface) {
  const AverageMotion average(mesh, interface.geometry, interface.point);
  MatrixXd columns = MatrixXd::Zero(Index{3} * unknowns.blocks(), 6);
  for (std::size_t n = 0; n < average.nodes().size(); ++n)
    columns.middleRows<3>(Index{3} * unknowns.block_of(average.nodes()[n])) =
        average.nodal_forces().middleRows<3>(3 * static_cast<Index>(n));
  return columns;
}

// Products with the mass, eight columns at a time.
class MassProduct {
 public:
  MassProduct(BlockMatrix mass, common::ThreadPool& pool)
      : mass_(std::move(mass)), product_(mass_, pool) {}

  MatrixXd operator()(const MatrixXd& x) {
    MatrixXd y(x.rows(), x.cols());
    for (Index first = 0; first < x.cols(); first += lane_count) {
      const Index width = std::min<Index>(lane_count, x.cols() - first);
      MultiVector in = to_multi_vector(x.middleCols(first, width)), out(in.size());
      product_(in, out, [](int) {});
      from_multi_vector(out, y.middleCols(first, width));
    }
    return y;
  }

 private:
  BlockMatrix mass_;
  MultiVectorProduct product_;
};

// f -> x with K x = f as far as the supports let it, and x as they allow.
class SupportedFlexibility {
 public:
  SupportedFlexibility(const TetMesh& mesh, const Freedoms& freedoms, const Vector3& point,
                       const Factorisation& factors, MassProduct& mass)
      : factors_(factors) {
    std::vector<const CoupledInterface*> held = freedoms.held_evenly;
    if (freedoms.floats) {
      const Vector3 at = held.empty() ? point : held.front()->point;
      rigid_ = rigid_motions(mesh, freedoms.unknowns, at);
      if (held.empty()) {
        const MatrixXd momentum = mass(rigid_);
        reaction_ = momentum * (rigid_.transpose() * momentum).inverse();
      } else {
        reaction_ = mean_motion(mesh, freedoms.unknowns, *held.front());
        held.erase(held.begin());
      }
    }
    hold(mesh, freedoms.unknowns, held);
  }

  MatrixXd operator()(const MatrixXd& forces) const {
    MatrixXd x = floating(forces);
    if (held_.cols() > 0) x -= yielding_ * between_.solve(held_.transpose() * x);
    return x;
  }

 private:
  // With its springs K is regular, and a load in equilibrium leaves them without force: what would
  // move the whole is taken by the reaction, and the rigid motion goes that it resists.
  MatrixXd floating(const MatrixXd& forces) const {
    if (rigid_.size() == 0) return factors_.solve(forces);
    MatrixXd x = factors_.solve(forces - reaction_ * (rigid_.transpose() * forces));
    x -= rigid_ * (reaction_.transpose() * x).eval();
    return x;
  }

  void hold(const TetMesh& mesh, const DofMap& unknowns,
            const std::vector<const CoupledInterface*>& held) {
    held_.resize(Index{3} * unknowns.blocks(), 6 * static_cast<Index>(held.size()));
    for (std::size_t i = 0; i < held.size(); ++i)
      held_.middleCols<6>(6 * static_cast<Index>(i)) = mean_motion(mesh, unknowns, *held[i]);
    if (held.empty()) return;
    yielding_ = floating(held_);
    between_.compute(held_.transpose() * yielding_);
  }

  const Factorisation& factors_;
  MatrixXd rigid_, reaction_;  // R and W, with W'R = 1
  MatrixXd held_, yielding_;   // the mean motions that are none, and what their reactions do
  Eigen::LDLT<MatrixXd> between_;
};

void require_memory(const BlockMatrix& stiffness, const Factorisation& factors, int count,
                    const SolverOptions& options) {
  const double limit = options.memory > 0 ? options.memory : common::memory_share();
  const double columns = 3.0 * count + 10 * lane_count;  // of Lanczos' method
  const double needed = common::resident_memory() + 2 * static_cast<double>(stiffness.bytes()) +
                        factors.stats().bytes +
                        1.5 * columns * sizeof(double) * static_cast<double>(stiffness.size());
  if (needed > limit) throw MemoryLimit(SolverMethod::direct, needed, limit);
}

Eigen::Matrix3Xd upright(Eigen::Matrix3Xd shape) {
  Index row = 0, column = 0;
  shape.cwiseAbs().maxCoeff(&row, &column);
  return shape(row, column) < 0 ? Eigen::Matrix3Xd(-shape) : shape;
}

LinkModes modes_of(const TetMesh& mesh, const DofMap& unknowns, const EigenPairs& pairs,
                   Index shown) {
  LinkModes modes{.omega_squared = pairs.values.cwiseInverse(), .shapes = {}};
  for (Index k = 0; k < pairs.values.size(); ++k)
    modes.shapes.push_back(
        upright(unknowns.displacements(mesh, pairs.vectors.col(k)).leftCols(shown)));
  modes.unknowns = 3 * common::at(unknowns.blocks());
  return modes;
}

}  // namespace
}  // namespace kinetostat::fea::vibration

namespace kinetostat::fea {

const char* name(Support support) {
  switch (support) {
    case Support::none:
      return "free";
    case Support::all_interfaces:
      return "held";
    default:
      return "clamped";
  }
}

double LinkModes::frequency(std::size_t mode) const {
  return std::sqrt(omega_squared[static_cast<Eigen::Index>(mode)]) / (2 * std::numbers::pi);
}

LinkModes link_modes(const TetMesh& mesh, const std::vector<Material>& materials,
                     const std::vector<CoupledInterface>& interfaces, Support support, int count,
                     const SolverOptions& options, common::Progress& progress) {
  using namespace vibration;
  if (!std::all_of(materials.begin(), materials.end(),
                   [](const Material& m) { return m.density().has_value(); }))
    throw std::invalid_argument("link_modes: no density");
  const Solid solid = with_stiff_bodies(mesh, materials, interfaces);
  const Freedoms freedoms(solid.mesh, solid.materials, interfaces, support);
  common::ThreadPool pool(std::max(options.threads, 1));
  const BlockMatrix stiffness =
      assemble(solid.mesh, solid.materials, freedoms.unknowns, pool, progress);
  Factorisation factors(stiffness.pattern, static_cast<int>(freedoms.unknowns.bodies().size()));
  require_memory(stiffness, factors, count, options);
  progress.report("factorisation", 0);
  factors.factorise(stiffness);
  MassProduct mass(assemble_mass(solid.mesh, solid.materials, freedoms.unknowns, pool, progress),
                   pool);
  const SupportedFlexibility flexibility(solid.mesh, freedoms, interfaces.front().point, factors,
                                         mass);
  const EigenPairs pairs = largest_eigenpairs(std::cref(flexibility), std::ref(mass),
                                              stiffness.size(), count, {}, progress);
  LinkModes modes =
      modes_of(solid.mesh, freedoms.unknowns, pairs, static_cast<Eigen::Index>(mesh.nodes.size()));
  modes.factor = factors.stats();
  return modes;
}

}  // namespace kinetostat::fea

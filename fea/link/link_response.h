// How the interfaces of a link move under unit wrenches on them.
#pragma once

#include <vector>

#include "kinetostat/common/progress.h"
#include "kinetostat/fea/elasticity/assembly.h"
#include "kinetostat/fea/elasticity/solver.h"
#include "kinetostat/fea/interface/coupling.h"
#include "kinetostat/spatial/stiffness.h"

namespace kinetostat::fea {

/// For m loaded interfaces; load case 6 (i - 1) + j is unit wrench j = Fx Fy Fz Mx My Mz at the
/// point of interface i = 1 to m, mesh axes, and its reaction on interface 0, which does not move.
struct LinkResponse {
  /// 6m x 6m. Rows as columns: [translation; rotation] of the loaded interfaces at their points
  /// [m/N, m/(N m); rad/N, rad/(N m)]. As computed, not made symmetric.
  Eigen::MatrixXd flexibility;
  /// Displacements of all nodes [m] in each load case.
  std::vector<Eigen::Matrix3Xd> fields;
  /// Warping of every interface: root mean square, over its area, of the difference between its
  /// displacement and its rigid motion, relative to the root mean square displacement of the
  /// interface that moves most; the largest of all load cases. 0 where the coupling is rigid.
  std::vector<double> fit_residuals;

  SolverStats solver;

  /// Compliance of the first loaded interface.
  Matrix6 compliance() const { return flexibility.topLeftCorner<6, 6>(); }
};

/// Compliance of loaded interface i = 1 to m at its point, mesh axes: its block of a flexibility
/// between all of them, made symmetric.
spatial::Compliance6 compliance_of(const Eigen::MatrixXd& flexibility,
                                   const std::vector<CoupledInterface>& interfaces, std::size_t i);

/// The elements of the link and those of the bodies on its interfaces.
struct Solid {
  TetMesh mesh;
  std::vector<Material> materials;
};

/// Grows the bodies of `body` couplings, of the stiffest material with its modulus multiplied.
/// Throws NoStiffBody.
Solid with_stiff_bodies(const TetMesh& mesh, const std::vector<Material>& materials,
                        const std::vector<CoupledInterface>& interfaces);

/// One set of equations, 6m right-hand sides. `interfaces` are two or more that share no node, the
/// first is held. The elements of the mesh name `materials` by number. With any coupling the
/// equations stay positive definite: a link without a rigid interface is held by six springs that
/// carry nothing, because every load case is in equilibrium, and moved back afterwards so that the
/// held interface has no (mean) motion. A `body` has the stiffest material with its modulus
/// multiplied. Throws NoStiffBody and what `solve` throws.
LinkResponse respond(const TetMesh& mesh, const std::vector<Material>& materials,
                     const std::vector<CoupledInterface>& interfaces, const SolverOptions& options,
                     common::Progress& progress);

}  // namespace kinetostat::fea

// The link as one element with inertia between its interfaces.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "kinetostat/fea/link/link_response.h"
#include "kinetostat/fea/link/modes.h"

namespace kinetostat::fea {

/// Mass of the free link by Guyan's condensation, 6(m + 1) square, in the order of
/// reduced_stiffness(): accelerations [translation; rotation] of all interfaces at their points to
/// wrenches on them [kg, kg m; kg m, kg m^2]. The link deforms as in rest, so the frequencies that
/// follow are too high; rigid motions have their exact mass, centre of mass and inertia. `response`
/// is that of the same model. Guyan 1965, AIAA Journal 3:380.
Eigen::MatrixXd guyan_mass(const TetMesh& mesh, const std::vector<Material>& materials,
                           const std::vector<CoupledInterface>& interfaces,
                           const LinkResponse& response);

/// K q + M q'' = w in the motions of all interfaces, then the modes with these held. K and M are
/// symmetric, M is positive definite where every material has a density.
struct ReducedModel {
  Eigen::MatrixXd stiffness, mass;
  Eigen::Index interface_motions = 0;  // the first freedoms; the others are modes
};

/// By Craig and Bampton 1968, AIAA Journal 6:1313: the deformations of rest and `held`, modes with
/// Support::all_interfaces of the same model.
ReducedModel craig_bampton(const TetMesh& mesh, const std::vector<Material>& materials,
                           const std::vector<CoupledInterface>& interfaces,
                           const LinkResponse& response, const LinkModes& held);

/// omega^2 [rad^2/s^2] of K x = omega^2 M x, ascending, those of rigid motions near zero.
Eigen::VectorXd natural_frequencies_squared(const Eigen::MatrixXd& stiffness,
                                            const Eigen::MatrixXd& mass);

}  // namespace kinetostat::fea

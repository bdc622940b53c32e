// What the flexibility owes to a boundary that is not where the CAD file has it.
#pragma once

#include "kinetostat/fea/elasticity/stress_recovery.h"

namespace kinetostat::fea {

/// A boundary that moves outward by g changes the flexibility C_ij by minus the integral of
/// g s_i : D^-1 s_j over it, to first order (shape derivative of the compliance; Allaire, Jouve and
/// Toader 2004, J. Comput. Phys. 194:363). Here with the gaps of the mesh for |g|, so that faces
/// outside and faces inside do not cancel: positive semidefinite, rows and columns as those of the
/// flexibility. Adds what each element has to `by_element` (ErrorEstimate), away from zero.
/// Requires gaps.
Eigen::MatrixXd geometry_error(const TetMesh& mesh, const std::vector<Material>& materials,
                               const Stresses& at_corners, Eigen::MatrixXd& by_element);

}  // namespace kinetostat::fea

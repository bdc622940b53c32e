// The stiffness of what joins two bodies where their faces touch: a bond or an elastic layer.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "kinetostat/fea/elasticity/elasticity.h"
#include "kinetostat/fea/mesh/tet_mesh.h"

namespace kinetostat::fea {

/// The nodes of both elements of a contact, those of the first one first.
std::vector<int> contact_nodes(const TetMesh& mesh, const FaceContact& contact);

/// Stiffness [N/m] between contact_nodes(), x, y, z of each in turn, by Nitsche's method for faces
/// with the flexibility E per area between them, bonded ones included (Juntunen and Stenberg 2009,
/// Math. Comp. 78:1353): with the jump J of the displacements, the mean traction T and a small g,
///
///     integral of (J - g T)' (E + g)^-1 (J - g T) - g T'T.
///
/// It asks nothing of how the meshes fit, and the exact solution, with J = -E t, fulfils it: no
/// penalty is left as an error, and any field of constant strain that both bodies can have is
/// reproduced. The more flexible element gives more of T (Annavarapu et al. 2012, Comput. Methods
/// Appl. Mech. Engng 225:44). g is a quarter of what would take all the energy of the two elements,
/// 1/g = 4 c d / (c + d) with c, d = (lambda + 2 mu) trace, so the equations stay positive
/// definite.
Eigen::MatrixXd contact_stiffness(const TetMesh& mesh, const std::vector<Material>& materials,
                                  const FaceContact& contact);

}  // namespace kinetostat::fea

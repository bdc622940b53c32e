// Inertia of one tetrahedron, and of a whole mesh.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "kinetostat/fea/elasticity/elasticity.h"
#include "kinetostat/fea/mesh/tet_mesh.h"

namespace kinetostat::fea {

/// Integrals of N_i N_j over an element [m^3], 4 x 4 or 10 x 10, exact for straight and for curved
/// edges. Times the density it is the consistent mass between two nodes, the same in each
/// direction.
Eigen::MatrixXd shape_products(const TetMesh& mesh, std::size_t element);

/// M a [N]: the nodal forces that give all nodes these accelerations [m/s^2], one column each.
/// Materials without a density have no mass.
Eigen::Matrix3Xd inertial_forces(const TetMesh& mesh, const std::vector<Material>& materials,
                                 const Eigen::Matrix3Xd& accelerations);

/// Mass [kg], centre of mass [m], and inertia [kg m^2] about it, mesh axes.
struct RigidMass {
  double mass = 0;
  Vector3 center = Vector3::Zero();
  Matrix3 inertia = Matrix3::Zero();
};

/// Of the elements that name `materials` by number; none where one of these has no density.
std::optional<RigidMass> rigid_mass(const TetMesh& mesh, const std::vector<Material>& materials);

}  // namespace kinetostat::fea

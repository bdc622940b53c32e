// Stress (geometric) stiffness: the stiffness that is added by an existing stress.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "kinetostat/fea/elasticity/assembly.h"
#include "kinetostat/fea/elasticity/elasticity.h"
#include "kinetostat/fea/mesh/tet_mesh.h"

namespace kinetostat::fea {

/// The stress stiffness K_sigma of a mesh under the stress that small displacements leave in it:
/// u' K_sigma v is the integral of (grad u sigma) : grad v. It is integrated at the points of the
/// stiffness itself, so that a rigid rotation turns the internal forces exactly.
class Prestress {
 public:
  /// `displacements` [m] of all nodes, one column each.
  Prestress(const TetMesh& mesh, const std::vector<Material>& materials,
            const Eigen::Matrix3Xd& displacements);

  /// K_sigma u [N] for displacements of all nodes.
  Eigen::Matrix3Xd times(const Eigen::Matrix3Xd& displacements) const;
  /// The internal forces of the stress at all nodes [N]: what holds them in equilibrium.
  Eigen::Matrix3Xd nodal_forces() const;

 private:
  template <class Visit>
  void for_each_point(Visit visit) const;

  const TetMesh& mesh_;
  std::vector<Matrix3> stresses_;  // at the points of the elements in turn [Pa]
};

/// Energy that the stress adds to a reference body at `point` that follows the forces
/// `nodal_forces` on its nodes: in a rotation by the vector r, 1/2 r' A r [N m]. The nodes move by
/// r x a + 1/2 r x (r x a), and the forces do work in the second part too.
Matrix3 body_stress_stiffness(const TetMesh& mesh, const ReferenceBody& body,
                              const Eigen::Matrix3Xd& nodal_forces);

/// K_sigma seen through the free motions: T' K_sigma T of assembly.h, bodies included.
class PrestressProduct {
 public:
  PrestressProduct(const TetMesh& mesh, const DofMap& unknowns, const Prestress& prestress);

  Eigen::VectorXd operator*(const Eigen::VectorXd& values) const;
  /// T' of forces on all nodes.
  Eigen::VectorXd on_unknowns(const Eigen::Matrix3Xd& forces) const;

 private:
  const TetMesh& mesh_;
  const DofMap& unknowns_;
  const Prestress& prestress_;
  std::vector<Matrix3> bodies_;
};

}  // namespace kinetostat::fea

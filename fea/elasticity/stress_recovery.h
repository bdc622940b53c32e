// Stresses of a finite-element solution, and smoother, better ones fitted to them.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "kinetostat/common/thread_pool.h"
#include "kinetostat/fea/elasticity/elasticity.h"
#include "kinetostat/fea/mesh/tet_mesh.h"

namespace kinetostat::fea {

/// Stresses of several load cases: 6 rows per load case, xx yy zz xy yz zx [Pa].
using Stresses = Eigen::MatrixXd;

/// The stresses that follow from the displacements [m], at the corners of the elements: column
/// 4 e + k belongs to corner k of element e. Within an element they are linear at second order and
/// constant at first, so that the corners say everything.
Stresses corner_stresses(const TetMesh& mesh, const std::vector<Material>& materials,
                         const std::vector<Eigen::Matrix3Xd>& displacements,
                         common::ThreadPool& pool);

/// The strain D^-1 s [1] of a stress xx yy zz xy yz zx [Pa], with the shear components doubled,
/// because each counts twice in a product with a stress.
Vector6 strain_of(const Eigen::Ref<const Vector6>& stress, const Material& material);

/// Continuous stresses at the nodes of the elements of one material, one column per node of the
/// mesh (zero at others); between the nodes, the shape functions. Around every corner node a
/// polynomial of the order of the elements is fitted by least squares to the stresses of the
/// surrounding elements where they are most accurate (superconvergent patch recovery: Zienkiewicz
/// and Zhu 1992, Int. J. Numer. Meth. Engng 33:1331). On boundary faces with tag 0, which carry no
/// load, the traction of the polynomial is asked to vanish; the interfaces ask nothing. A mid node
/// has the mean of its two corners' polynomials.
Stresses recovered_stresses(const TetMesh& mesh, const Stresses& at_corners, std::size_t material,
                            common::ThreadPool& pool);

}  // namespace kinetostat::fea

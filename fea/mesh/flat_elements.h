// Elements without volume, taken out of a mesh of tetrahedra.
#pragma once

#include <cstddef>

#include "kinetostat/fea/mesh/tet_mesh.h"

namespace kinetostat::fea {

/// Volume over the cube of the longest edge: 0.118 for a regular tetrahedron, 0 for a flat one.
double fullness(const std::array<Vector3, 4>& corners);

/// Fullness below which an element makes the stiffness as good as singular.
inline constexpr double flat_fullness = 1e-9;

/// Is any element flatter than flat_fullness?
bool has_flat_elements(const TetMesh& mesh);

/// Takes out elements flatter than `bar`, where that makes the flattest around them fuller: those
/// at the boundary are peeled off (its faces take the tag of those that go), within, the tetrahedra
/// around an edge are connected anew (edge removal by dynamic programming, Shewchuk 2002, "Two
/// discrete optimization algorithms for the topological improvement of tetrahedral meshes"), or a
/// node is moved or joined with its neighbour. Nodes of the boundary stay where they are. Returns
/// how many elements below the bar are left. Requires order 1.
std::size_t remove_flat_elements(TetMesh& mesh, double bar = 1e-6);

}  // namespace kinetostat::fea

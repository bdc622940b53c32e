// Integrals over boundary faces whose edges are curved.
#pragma once

#include <functional>

#include "kinetostat/fea/mesh/tet_mesh.h"

namespace kinetostat::fea {

using FaceShapes = Eigen::Matrix<double, 6, 1>;

/// The six shape functions of a face at sixteen points, each with the point [m] and its part of the
/// area [m^2]. The rule is exact for polynomials of sixth degree in the local coordinates: products
/// of two shape functions over a flat face. Requires order 2.
void integrate_face(
    const TetMesh& mesh, const BoundaryFace& face,
    const std::function<void(const FaceShapes& shapes, const Vector3& point, double area)>& visit);

/// The faces of the mesh are integrated so: their nodes lie on the faces of a CAD file.
bool has_curved_faces(const TetMesh& mesh);

}  // namespace kinetostat::fea

// A harmonic field between two interfaces: how far through the link a point is.
#pragma once

#include "kinetostat/fea/mesh/tet_mesh.h"

namespace kinetostat::fea {

/// Laplace's equation on the corner nodes: 0 on the nodes `low`, 1 on the nodes `high`, no flux
/// elsewhere. Like heat or current it finds its way through any shape, straight, curved or
/// branched. One value per node of the mesh (nodes that are no corner of an element: 0). Requires
/// a mesh in one piece and nodes in both sets.
Eigen::VectorXd potential(const TetMesh& mesh, const std::vector<int>& low,
                          const std::vector<int>& high);

/// Where the field's flow enters or leaves through these nodes: their mean position [m], weighted
/// with their share of the flow.
Vector3 flow_centre(const TetMesh& mesh, const Eigen::VectorXd& field,
                    const std::vector<int>& nodes);

/// The gradient of a field of nodal values in element `e`, from its corners [1/m].
Vector3 gradient(const TetMesh& mesh, std::size_t e, const Eigen::VectorXd& values);

}  // namespace kinetostat::fea

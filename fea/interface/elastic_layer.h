// The elastic layer between an interface and a rigid body that it is fastened to.
#pragma once

#include <map>

#include "kinetostat/fea/interface/coupling.h"

namespace kinetostat::fea {

/// Springs [N/m] at nodes of the interface that hold what the layer holds: normal stiffness along
/// the normal of each face, tangential in its plane, both per area. They integrate the energy over
/// the faces, at second order by the middles of their sides, which is exact for the rigid motions
/// of flat interfaces (compliances 1/(k A), 1/(k I)) and leaves an error of the order of the
/// elements' own; at first order by the corners, too stiff in rotation by h^2.
std::map<int, Matrix3> layer_springs(const TetMesh& mesh, const Interface& interface,
                                     const ElasticLayer& layer);

}  // namespace kinetostat::fea

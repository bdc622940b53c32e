// A free body held just enough for its equations to have one solution.
#pragma once

#include <vector>

#include "kinetostat/fea/elasticity/assembly.h"

namespace kinetostat::fea {

/// Springs at three corners of the mesh that are free and far apart, in six directions in all:
/// statically determinate, so under loads in equilibrium they carry nothing and change no stress,
/// whatever their stiffness. `young` [Pa] sets it, so that the matrix is evenly scaled. Requires a
/// mesh whose free corners are not all on one line.
std::vector<GroundSpring> isostatic_support(const TetMesh& mesh, const DofMap& unknowns,
                                            double young);

}  // namespace kinetostat::fea

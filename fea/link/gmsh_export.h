// A volume mesh as Gmsh's .msh file.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/fea/interface/coupling.h"
#include "kinetostat/fea/mesh/tet_mesh.h"

namespace kinetostat::fea {

/// Format 2.2, text, coordinates in metres. Physical groups: one volume per material ("link", then
/// "body 1" ...), and the faces of each interface under its name.
std::string gmsh_mesh(const TetMesh& mesh, const std::vector<CoupledInterface>& interfaces);

}  // namespace kinetostat::fea

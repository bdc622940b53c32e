// The pseudo-rigid body of JAMRIS09 section 4.3: real elements of a much higher modulus, grown on
// an interface in the place of the neighbouring part.
#pragma once

#include <stdexcept>

#include "kinetostat/fea/interface/interface_selection.h"
#include "kinetostat/fea/mesh/tet_mesh.h"

namespace kinetostat::fea {

/// No body can be grown on the interface: it folds back on itself.
class NoStiffBody : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Appends a layer of elements to the mesh, outward from the interface and bonded to its nodes;
/// they have the material with number `material`. The body is as thick as the interface is wide
/// (its radius of gyration), halved until no facet shrinks to less than a quarter of its area: in a
/// bore it is a ring inside, on a boss a ring around. It exists for the energy alone and may share
/// space with the link or with another body. Nodes and elements of the mesh keep their numbers.
/// Throws NoStiffBody.
void grow_stiff_body(TetMesh& mesh, const Interface& interface, int material);

}  // namespace kinetostat::fea

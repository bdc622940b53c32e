// The link result file as those read it who take a link as a spring with a mass: all that passes
// from finite elements to robots. report/links writes it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "kinetostat/spatial/stiffness.h"

namespace kinetostat::io {

/// A link between two interfaces, mesh axes; the fixed interface does not move.
struct IdentifiedLink {
  spatial::Compliance6 compliance;                             // at the loaded interface's point
  std::optional<double> mass;                                  // [kg]; none without a density
  spatial::Vector3 center_of_mass = spatial::Vector3::Zero();  // [m], when it has a mass
  std::string mesh_sha256 = {};  // of the mesh that it was identified from; empty: not stated
};

/// Throws what read_compliance() throws, and InputError naming the key when the mass is not above
/// zero or has no centre.
IdentifiedLink read_identified_link(const std::filesystem::path& file);

}  // namespace kinetostat::io

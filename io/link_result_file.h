// The link result file as those read it who take a link as a spring with a mass: all that passes
// from finite elements to robots. report/links writes it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "kinetostat/spatial/stiffness.h"

namespace kinetostat::io {

/// What `identify` knows of the error of its mesh; rows and columns of the compliance.
struct LinkErrorBars {
  spatial::Matrix6 bar;       // half widths
  spatial::Matrix6 recovery;  // signed estimate of exact minus computed
};

/// The compliance with all interfaces rigid, and with all of them distributing: any clamping is
/// between.
struct LinkBracket {
  spatial::Matrix6 rigid, distributing;
};

/// A link between two interfaces, mesh axes; the fixed interface does not move.
struct IdentifiedLink {
  spatial::Compliance6 compliance;                             // at the loaded interface's point
  std::optional<double> mass;                                  // [kg]; none without a density
  spatial::Vector3 center_of_mass = spatial::Vector3::Zero();  // [m], when it has a mass
  std::optional<LinkErrorBars> error = {};                     // where stated
  std::optional<LinkBracket> bracket = {};                     // where computed
  std::string mesh_sha256 = {};  // of the mesh that it was identified from; empty: not stated
};

/// Throws what read_compliance() throws, and InputError naming the key when the mass is not above
/// zero or has no centre, when error bars are no 6x6 of numbers, and when a bound of the bracket is
/// not positive definite or the rigid one yields more.
IdentifiedLink read_identified_link(const std::filesystem::path& file);

}  // namespace kinetostat::io

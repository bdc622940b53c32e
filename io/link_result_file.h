// The link result file as those read it who take a link as a spring with a mass: all that passes
// from finite elements to robots. report/links writes it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/spatial/stiffness.h"

namespace kinetostat::io {

/// What `identify` knows of the error of its mesh; rows and columns of the flexibility, of one
/// loaded interface the compliance.
struct LinkErrorBars {
  Eigen::MatrixXd bar;       // half widths
  Eigen::MatrixXd recovery;  // signed estimate of exact minus computed
};

/// The flexibility with all interfaces rigid, and with all of them distributing: any clamping is
/// between.
struct LinkBracket {
  Eigen::MatrixXd rigid, distributing;
};

/// A link between two interfaces, mesh axes; the fixed interface does not move.
struct IdentifiedLink {
  spatial::Compliance6 compliance;                             // at the loaded interface's point
  std::optional<double> mass;                                  // [kg]; none without a density
  spatial::Vector3 center_of_mass = spatial::Vector3::Zero();  // [m], when it has a mass
  std::optional<LinkErrorBars> error = {};                     // where stated
  std::optional<LinkBracket> bracket = {};                     // where computed
  double young_deviation = 0;    // of the modulus of its material, in parts of it; 0: not stated
  std::string mesh_sha256 = {};  // of the mesh that it was identified from; empty: not stated
};

/// Throws what read_compliance() throws, and InputError naming the key when the mass is not above
/// zero or has no centre, when error bars are no 6x6 of numbers, and when a bound of the bracket is
/// not positive definite or the rigid one yields more.
IdentifiedLink read_identified_link(const std::filesystem::path& file);

/// A free link between n interfaces, two or more, mesh axes. Six coordinates [translation;
/// rotation] an interface at its point.
struct ReducedLink {
  std::vector<std::string> interfaces;
  std::vector<spatial::Vector3> points;  // [m]
  Eigen::MatrixXd stiffness;             // 6n square: wrenches by motions [N, m, rad]
  Eigen::MatrixXd inertia = {};          // the same by accelerations; empty without a density
  std::size_t fixed = 0;                 // the interface that the flexibility holds
  Eigen::MatrixXd flexibility = {};      // 6(n - 1) square, of the others; empty where not stated
  std::optional<LinkErrorBars> error = {};
  std::optional<LinkBracket> bracket = {};
  double young_deviation = 0;  // as IdentifiedLink has it
};

/// The `reduced` of a link result. Throws InputError naming the key when one is missing or
/// malformed, when coordinates or units are others than `identify` writes, and when the stiffness
/// is not symmetric to 1e-6, not positive semi-definite, resists one of the six rigid motions, or
/// does not resist a motion beside those.
ReducedLink read_reduced_link(const std::filesystem::path& file);

/// Stiffness of the free link between all its interfaces from its flexibility with `fixed` held.
Eigen::MatrixXd free_stiffness(const ReducedLink& link, const Eigen::MatrixXd& flexibility);

}  // namespace kinetostat::io

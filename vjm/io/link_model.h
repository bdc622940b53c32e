// A link of a robot file: from its start frame to its end frame, with the compliance between them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/spatial/pose.h"
#include "kinetostat/vjm/manipulator/free_motion.h"

namespace kinetostat::vjm {

class ChainBuilder;

/// One rigid offset followed by an optional spring at its end.
struct LinkPart {
  spatial::Pose offset;                                 // start frame to end frame
  std::optional<spatial::Compliance6> compliance = {};  // at the end, in the axes of the end frame
  std::vector<ScrewMotion> free_motions = {};           // there, behind the spring
  bool travels = false;  // the spring goes along with the free motions: they are before it
};

/// The mass of a link.
struct LinkMass {
  double mass = 0;                                     // [kg] of all parts together
  spatial::Vector3 center = spatial::Vector3::Zero();  // [m] of each part, in its start frame
  /// [kg m^2] of all parts, each about its centre, in the axes of its start frame; zero: that of a
  /// uniform rod.
  spatial::Matrix3 inertia = spatial::Matrix3::Zero();
};

/// A link: one part, or as many as it has segments.
struct LinkModel {
  std::vector<LinkPart> parts;
  std::optional<LinkMass> mass = {};
  std::optional<std::filesystem::path> file = {};  // of an identified link

  /// Appends the link to a chain; the springs of several segments are named "name.1", "name.2",
  /// ..., passive joints for free motions "name.free1", ... The mass of a part is halved between
  /// the points one sixth from either end: the half beyond the spring then deflects and turns it
  /// exactly as the distributed weight of a uniform beam does.
  void append_to(ChainBuilder& chain, const std::string& name) const;
};

}  // namespace kinetostat::vjm

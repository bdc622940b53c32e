// A link of a robot file: from its start frame to its end frame, with the compliance between them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/vjm/chain/chain.h"
#include "kinetostat/vjm/manipulator/free_motion.h"

namespace kinetostat::vjm {

/// One rigid offset followed by an optional spring at its end.
struct LinkPart {
  spatial::Pose offset;                                 // start frame to end frame
  std::optional<spatial::Compliance6> compliance = {};  // at the end, in the axes of the end frame
  std::vector<ScrewMotion> free_motions = {};           // there
};

/// The mass of a link.
struct LinkMass {
  double mass = 0;                                     // [kg] of all parts together
  spatial::Vector3 center = spatial::Vector3::Zero();  // [m] of each part, in its start frame
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
  void append_to(Chain& chain, const std::string& name) const;
};

/// Options that override a link of a robot file.
struct LinkOptions {
  int segment_multiple = 1;  // every beam in so many times the segments that the file gives it
  std::vector<std::filesystem::path> within = {};  // robot files of which this one is a part
};

/// Reads `{rigid: ...}`, `{beam: ...}`, `{compliance: file or 6x6, ...}`, `{stiffness: 6x6, ...}`
/// or
/// `{manipulator: file, ...}`. `materials` is the robot file's map of named materials, if it has
/// one.
LinkModel read_link(const io::YamlNode& node, const spatial::UnitSystem& units,
                    const std::optional<io::YamlNode>& materials, const LinkOptions& options = {});

}  // namespace kinetostat::vjm

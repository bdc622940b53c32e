// Links as robot files describe them.
#pragma once

#include <optional>

#include "kinetostat/io/yaml.h"
#include "kinetostat/vjm/io/link_model.h"
#include "kinetostat/vjm/io/link_options.h"

namespace kinetostat::vjm {

/// Reads `{rigid: ...}`, `{beam: ...}`, `{compliance: file or 6x6, ...}`, `{stiffness: 6x6, ...}`
/// or `{manipulator: file, ...}`. `materials` is the robot file's map of named materials, if it has
/// one; `options.sources` is not null; `read` reads the robot file of a link that is a manipulator.
LinkModel read_link(const io::YamlNode& node, const spatial::UnitSystem& units,
                    const std::optional<io::YamlNode>& materials, const LinkOptions& options,
                    const ReadManipulator& read);

/// `[ixx, ixy, ixz, iyy, iyz, izz]` of a body about its centre of mass [kg m^2].
spatial::Matrix3 read_inertia(const io::YamlNode& node, const spatial::UnitSystem& units);

}  // namespace kinetostat::vjm

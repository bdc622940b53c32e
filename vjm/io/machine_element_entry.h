// Bearings, guides and screws as robot files describe them.
#pragma once

#include <string>

#include "kinetostat/io/yaml.h"
#include "kinetostat/spatial/linear_algebra.h"
#include "kinetostat/vjm/chain/stiffness_table.h"
#include "kinetostat/vjm/io/uncertainty_source.h"

namespace kinetostat::vjm {

/// Reads the inside of `{bearing: {balls: 16, ...}}` or `{bearing: {rollers: 30, ...}}`: its
/// stiffness in the axes of the link, SI; nothing resists a turn about its axis. Throws
/// common::InputError.
spatial::Matrix6 read_bearing(const io::YamlNode& node, const spatial::UnitSystem& units,
                              SourceList& sources);

/// Reads the inside of `{guide: {lateral: ..., normal: ..., carriages: [[x, y, z], ...]}}`: its
/// stiffness in the axes of the link, SI; nothing resists a motion along its rail. Throws
/// common::InputError.
spatial::Matrix6 read_guide(const io::YamlNode& node, const spatial::UnitSystem& units,
                            SourceList& sources);

/// Reads the inside of `stiffness: {ball_screw: {...}}` of a drive that slides. Throws
/// common::InputError.
StiffnessTable read_ball_screw(const io::YamlNode& node, const spatial::UnitSystem& units,
                               const std::string& joint, SourceList& sources);

}  // namespace kinetostat::vjm

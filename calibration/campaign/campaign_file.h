// Campaign files: YAML that people write, and a table of readings, to a campaign.
#pragma once

#include <filesystem>
#include <optional>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/vjm/manipulator/manipulator.h"

namespace kinetostat::calibration {

/// The robot file that a campaign file names, if it names one. Throws common::InputError when the
/// campaign cannot be read or the named file does not exist.
std::optional<std::filesystem::path> robot_named_in(const std::filesystem::path& campaign);

/// Reads a campaign file and its readings. The manipulator says which columns are joints. The
/// format is in docs/reference/campaign-file.md. Throws common::InputError naming file, line,
/// column, value and cure.
Campaign read_campaign(const std::filesystem::path& file, const vjm::Manipulator& manipulator);

}  // namespace kinetostat::calibration

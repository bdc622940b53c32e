// Robot files that are written by commands.
#pragma once

#include <filesystem>
#include <string>

#include "kinetostat/io/text_file.h"

namespace kinetostat::apps {

/// Writes a robot file that reads back; else nothing, and throws what reading it throws.
void write_robot(const std::filesystem::path& file, const std::string& text);
/// The same, following no symbolic link; false when something is there that must stay.
bool write_robot_in_place_of(io::Replace replace, const std::filesystem::path& file,
                             const std::string& text);

}  // namespace kinetostat::apps

// Robot files that are written by commands.
#pragma once

#include <filesystem>
#include <string>

namespace kinetostat::apps {

/// Writes a robot file that reads back; else nothing, and throws what reading it throws.
void write_robot(const std::filesystem::path& file, const std::string& text);

}  // namespace kinetostat::apps

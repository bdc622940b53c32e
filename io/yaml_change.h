// Single values of a YAML file replaced in its text, all other bytes and places kept.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace kinetostat::io {

/// The text with `value`, YAML as well, at a path of keys: "links.leg.beam.length". An item of a
/// list goes by its number from 0, or by its name ("chain_types.arm.q1.stiffness", whose item is
/// {actuator: {name: q1, ...}}). A key that its map has not is added to it. Throws InputError
/// naming `file` and the key, with the nearest that is there, when the path leads nowhere, or to a
/// text of several lines, and when the value is no YAML of one line.
std::string with_value(const std::string& text, const std::filesystem::path& file,
                       const std::string& key, const std::string& value);

/// Whether the first key of the path is there; nothing for a text that is no YAML.
bool has_first_key(const std::string& text, const std::string& key);

}  // namespace kinetostat::io

// Text of other programs in the encodings that they write, as UTF-8.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace kinetostat::io {

/// The text as UTF-8 without a byte-order mark. UTF-16 is known by its byte-order mark; what is no
/// UTF-8 is taken as Windows-1252, of which Latin-1 is a part. UTF-8 comes back as it is. Throws
/// InputError when UTF-16 ends within a character.
std::string as_utf8(std::string bytes, const std::filesystem::path& file);

/// Adds a character to UTF-8 text. Requires a code of Unicode, up to 0x10FFFF.
void append_utf8(std::string& text, std::uint32_t code);

}  // namespace kinetostat::io

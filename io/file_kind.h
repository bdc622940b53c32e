// Kind of a file, by its first bytes: a file given in the place of another is named, not parsed.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace kinetostat::io {

/// "a PNG picture", "a mesh (binary STL)", "a gzip archive"; "binary data" for what holds zero
/// bytes; empty for text that may be anything. `bytes` is the start of the file, or all of it.
std::string kind_of_bytes(std::string_view bytes);

/// The text looks like a table: its first line that is no comment has separators and no colon, or
/// starts with a separator.
bool looks_like_table(std::string_view text);

/// Throws InputError when the bytes are of a kind that is not text: "this is a PNG picture, not a
/// robot file. " and the cure.
void refuse_other_kinds(const std::filesystem::path& file, std::string_view bytes,
                        const std::string& wanted, const std::string& cure);

}  // namespace kinetostat::io

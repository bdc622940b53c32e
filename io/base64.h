// Bytes as text (RFC 4648, section 4).
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace kinetostat::io {

std::string base64(std::string_view bytes);

/// The bytes again; padding may be missing. Nothing when there is anything else than the 64
/// letters.
std::optional<std::string> from_base64(std::string_view text);

}  // namespace kinetostat::io

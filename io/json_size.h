// How much a JSON text would take of the stack and of memory.
#pragma once

#include <string_view>

namespace kinetostat::io {

/// Whether its brackets are nested deeper than those of any result: writing such a value out goes
/// as deep into the stack. Quick, and before the text is parsed.
bool is_nested_too_deeply(std::string_view json);

/// Whether its values would take more than about 1 GiB of memory: an empty list is two bytes of
/// text and fifty of memory. Quick, and before the text is parsed.
bool is_too_large(std::string_view json);

}  // namespace kinetostat::io

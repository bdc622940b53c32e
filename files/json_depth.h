// How deep a JSON text goes.
#pragma once

#include <string_view>

namespace kinetostat::files {

/// Whether its brackets are nested deeper than those of any result: writing such a value out goes
/// as deep into the stack. Quick, and before the text is parsed.
bool is_nested_too_deeply(std::string_view json);

}  // namespace kinetostat::files

// Which build of the program runs.
#pragma once

#include <string>

namespace kinetostat::common {

/// Build ID of the program or library that this function is linked into: the hash of its contents
/// that the linker leaves in the ELF note NT_GNU_BUILD_ID, in hexadecimal digits. Empty: it left
/// none.
std::string build_id();

}  // namespace kinetostat::common

// Versions of this program and its libraries, and which build it is.
#pragma once

#include <string>

namespace kinetostat::apps {

/// "0.1.0".
std::string version();

/// Version, parts that are linked with their versions and licences, and the BLAS in use.
std::string version_report();

/// Build ID of the program that runs, or the SHA-256 of its file where the linker left none.
/// Another build may compute otherwise, whatever its version says, so it is part of every key in
/// the cache.
std::string this_program();

}  // namespace kinetostat::apps

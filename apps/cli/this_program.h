// Which build of the program this is.
#pragma once

#include <string>

namespace kinetostat::apps {

/// SHA-256 of the program that runs. Another build may compute otherwise, whatever its version
/// says, so it is part of every key in the cache.
std::string this_program();

}  // namespace kinetostat::apps

// Versions of this program and its libraries.
#pragma once

#include <string>

namespace kinetostat::apps {

/// "0.1.0".
std::string version();

/// Version, parts that are linked with their versions and licences, and the BLAS in use.
std::string version_report();

}  // namespace kinetostat::apps

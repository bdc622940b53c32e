// The study of a robot without readings.
#pragma once

#include <filesystem>

#include "kinetostat/apps/cli/command.h"

namespace kinetostat::apps {

/// Stiffness at home and what yields there, the same about home, the critical force, internal loads
/// of chains that do not close: into run.out(), with a page. Throws common::NoConvergence where the
/// robot cannot stand at home.
io::Json study_design(const std::filesystem::path& file, Run& run);

}  // namespace kinetostat::apps

// Completion of the command line, as a file that a shell reads.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/apps/manual/program_text.h"

namespace kinetostat::apps {

/// The shells that there is a completion for.
const std::vector<std::string>& completed_shells();

/// Completes commands, options, values that are one of a few, folders and files. `shell` is one of
/// completed_shells().
std::string completion(const ProgramText& program, const std::string& shell);

}  // namespace kinetostat::apps

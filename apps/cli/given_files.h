// Files given to a command: those of another kind than it wants are named with the command that
// takes them, and values in the others may be set for one run.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "kinetostat/common/error.h"

namespace kinetostat::apps {

/// The whole message is one sentence and the command.
class MisplacedFile : public common::InputError {
 public:
  using InputError::InputError;
};

/// Throws MisplacedFile for the first of the files that is of a known kind and not of one
/// that `command` takes in its place. Files of unknown kinds, and commands that are not listed,
/// pass.
void refuse_misplaced_files(const std::string& command, const std::vector<std::string>& files);

/// Whether a command reads a robot, link or campaign file, in which --set may set values.
bool takes_set(const std::string& command);

/// KEY and VALUE of --set.
using Setting = std::pair<std::string, std::string>;

/// What the files are to be read as: of the files that the command line names, and of the robot
/// file that a campaign names, the first that has the first key of a setting gets it; where none
/// has it, the first file of all. Throws common::InputError where a key leads nowhere, with the
/// nearest that is there.
std::vector<std::pair<std::filesystem::path, std::string>> changed_files(
    const std::vector<std::string>& files, const std::vector<Setting>& settings);

}  // namespace kinetostat::apps

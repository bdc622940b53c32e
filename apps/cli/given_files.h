// Files given to a command that wants another kind of file: one sentence, and the command that
// takes them.
#pragma once

#include <string>
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

}  // namespace kinetostat::apps

// Where the files that come with the program are.
#pragma once

#include <filesystem>

namespace kinetostat::apps {

/// A shipped file or folder, such as "data/robots/orthoglide.yaml": in the installed share folder
/// beside the program, else in the source folder that the program was built from. Throws
/// common::InputError when it is in neither.
std::filesystem::path shipped(const std::filesystem::path& relative);

}  // namespace kinetostat::apps

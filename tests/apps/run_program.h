// Runs the program as its users do: through the shell, in a folder.
#pragma once

#include <filesystem>
#include <string>

namespace kinetostat::test {

struct Outcome {
  int code;  // -1 when a signal ended the program
  std::string out, err;
};

/// A folder that looks like the source folder, with data and meshes in it. Files that commands
/// write there are thrown away when the test program ends.
const std::filesystem::path& working_folder();

/// `arguments` as they are typed; the working folder is working_folder(). Results that the same
/// program has kept in `cache` are used again; by default those of all tests.
Outcome kinetostat(const std::string& arguments,
                   const std::filesystem::path& cache = KINETOSTAT_TEST_CACHE);

}  // namespace kinetostat::test

#include "run_program.h"

#include <array>
#include <cstdio>
#include <sys/wait.h>

#include <fmt/format.h>

#include "kinetostat/io/text_file.h"

#include "support/temporary_folder.h"

namespace kinetostat::test {
namespace {

class WorkingFolder {
 public:
  WorkingFolder() {
    const std::filesystem::path source = KINETOSTAT_SOURCE_DIR;
    for (const char* name : {"data", "meshes", "CONTRIBUTING.md"})
      std::filesystem::create_symlink(source / name, path() / name);
  }
  const std::filesystem::path& path() const { return folder_.path(); }

 private:
  TemporaryFolder folder_;
};

}  // namespace

const std::filesystem::path& working_folder() {
  static const WorkingFolder folder;
  return folder.path();
}

Outcome kinetostat(const std::string& arguments, const std::filesystem::path& cache) {
  const std::string command =
      fmt::format("cd '{}' && XDG_CACHE_HOME='{}' timeout 500 '{}' {} 2>stderr",
                  working_folder().string(), cache.string(), KINETOSTAT_PROGRAM, arguments);
  std::FILE* pipe = popen(command.c_str(), "r");
  std::string out;
  std::array<char, 4096> buffer{};
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe))
    out.append(buffer.data(), n);
  const int status = pclose(pipe);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, out,
          io::read_text(working_folder() / "stderr")};
}

}  // namespace kinetostat::test

#include "kinetostat/apps/cli/shipped_files.h"

#include "kinetostat/common/error.h"

namespace kinetostat::apps {

std::filesystem::path shipped(const std::filesystem::path& relative) {
  std::error_code ignored;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", ignored);
  for (const std::filesystem::path& root : {program.parent_path() / ".." / KINETOSTAT_SHARE_DIR,
                                            std::filesystem::path(KINETOSTAT_SOURCE_DIR)})
    if (std::filesystem::exists(root / relative)) return (root / relative).lexically_normal();
  throw common::InputError(relative, "is not among the files that came with this program",
                           "Install kinetostat with its data, or run it from its build folder");
}

}  // namespace kinetostat::apps

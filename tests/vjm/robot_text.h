// Robots written as text in a test.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "kinetostat/vjm/io/robot_file.h"

#include "support/temporary_folder.h"

namespace kinetostat::vjm {

/// Robot of a file with this text that lies beside the shipped ones: it may use data/links/.
inline Robot robot_from(const std::string& text) {
  const test::TemporaryFolder folder;
  const std::filesystem::path data = std::filesystem::path(KINETOSTAT_SOURCE_DIR) / "data";
  for (const auto& entry : std::filesystem::directory_iterator(data))
    if (entry.path().filename() != "robots")
      std::filesystem::create_symlink(entry.path(), folder.path() / entry.path().filename());
  std::filesystem::create_directory(folder.path() / "robots");
  for (const auto& entry : std::filesystem::directory_iterator(data / "robots"))
    std::filesystem::create_symlink(entry.path(),
                                    folder.path() / "robots" / entry.path().filename());
  const std::filesystem::path file = folder.path() / "robots" / "from_text.yaml";
  std::ofstream(file) << text;
  return read_robot(file);
}

}  // namespace kinetostat::vjm

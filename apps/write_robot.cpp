#include "kinetostat/apps/write_robot.h"

#include "kinetostat/files/text_file.h"
#include "kinetostat/vjm/robot_file.h"

namespace kinetostat::apps {

void write_robot(const std::filesystem::path& file, const std::string& text) {
  const std::filesystem::path trial = file.string() + ".trial.yaml";
  files::write_atomically(trial, text);
  try {
    (void)vjm::read_robot(trial);
  } catch (...) {
    std::filesystem::remove(trial);
    throw;
  }
  std::filesystem::rename(trial, file);
}

}  // namespace kinetostat::apps

#include "kinetostat/apps/write_robot.h"

#include "kinetostat/files/error.h"
#include "kinetostat/files/text_file.h"
#include "kinetostat/vjm/robot_file.h"

namespace kinetostat::apps {

void write_robot(const std::filesystem::path& file, const std::string& text) {
  const std::filesystem::path trial = file.string() + ".trial.yaml";
  std::error_code ignored;
  files::write_atomically(trial, text);
  try {
    (void)vjm::read_robot(trial);
  } catch (const files::InputError& error) {
    std::filesystem::remove(trial, ignored);
    files::InputError::Details details = error.details();
    if (details.file == trial) details.file = file;
    details.what = "as it would be written, it does not read back: " + details.what;
    throw files::InputError(details);
  }
  std::filesystem::remove(trial, ignored);
  files::write_atomically(file, text);  // through a link, and not in the place of a device
}

}  // namespace kinetostat::apps

#include "kinetostat/apps/write_robot.h"

#include "kinetostat/files/error.h"
#include "kinetostat/files/text_file.h"
#include "kinetostat/vjm/robot_file.h"

namespace kinetostat::apps {
namespace {

void require_that_it_reads_back(const std::filesystem::path& file, const std::string& text) {
  try {
    (void)vjm::parse_robot(text, file);
  } catch (const files::InputError& error) {
    files::InputError::Details details = error.details();
    details.what = "as it would be written, it does not read back: " + details.what;
    throw files::InputError(details);
  }
}

}  // namespace

void write_robot(const std::filesystem::path& file, const std::string& text) {
  require_that_it_reads_back(file, text);
  files::write_atomically(file, text);  // through a link, and not in the place of a device
}

bool write_robot_in_place_of(files::Replace replace, const std::filesystem::path& file,
                             const std::string& text) {
  require_that_it_reads_back(file, text);
  return files::write_in_place_of(replace, file, text);
}

}  // namespace kinetostat::apps

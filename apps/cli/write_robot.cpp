#include "kinetostat/apps/cli/write_robot.h"

#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::apps {
namespace {

void require_that_it_reads_back(const std::filesystem::path& file, const std::string& text) {
  try {
    (void)vjm::parse_robot(text, file);
  } catch (const common::InputError& error) {
    common::InputError::Details details = error.details();
    details.what = "as it would be written, it does not read back: " + details.what;
    throw common::InputError(details);
  }
}

}  // namespace

void write_robot(const std::filesystem::path& file, const std::string& text) {
  require_that_it_reads_back(file, text);
  io::write_atomically(file, text);  // through a link, and not in the place of a device
}

bool write_robot_in_place_of(io::Replace replace, const std::filesystem::path& file,
                             const std::string& text) {
  require_that_it_reads_back(file, text);
  return io::write_in_place_of(replace, file, text);
}

}  // namespace kinetostat::apps

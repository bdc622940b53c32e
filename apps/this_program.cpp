#include "kinetostat/apps/this_program.h"

#include "kinetostat/files/text_file.h"

namespace kinetostat::apps {

std::string this_program() { return files::sha256(files::read_text("/proc/self/exe")); }

}  // namespace kinetostat::apps

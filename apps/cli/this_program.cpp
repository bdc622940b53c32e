#include "kinetostat/apps/cli/this_program.h"

#include "kinetostat/io/text_file.h"

namespace kinetostat::apps {

std::string this_program() { return io::sha256(io::read_text("/proc/self/exe")); }

}  // namespace kinetostat::apps

// Man pages in the macros of man(7).
#pragma once

#include <string>
#include <vector>

#include "kinetostat/apps/manual/program_text.h"

namespace kinetostat::apps {

struct ManPage {
  std::string file;  // "kinetostat-mesh-check.1"
  std::string text;
};

/// One page of the program, and one of each command.
std::vector<ManPage> man_pages(const ProgramText& program);

}  // namespace kinetostat::apps

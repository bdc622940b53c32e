// The commands of the program, one file each.
#pragma once

namespace kinetostat::apps {

class Program;

}  // namespace kinetostat::apps

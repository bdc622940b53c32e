// Preparation of the program's process, before anything else.
#pragma once

namespace kinetostat::apps {

/// Standard streams that are closed become /dev/null, else the next file that is opened would take
/// their number and get their text; writing to standard output fails as it did. Where memory is
/// limited, starts the program anew with one thread of OpenBLAS: each takes 128 MiB of address
/// space at the start, and asks for it for ever where there is none; and below 1 GiB with one of
/// OpenMP. Where memory runs out while that is being said, the program still ends with exit code 6;
/// so it does, before all this, where there is none for the libraries that it is linked to.
void prepare_process(char** argv);

}  // namespace kinetostat::apps

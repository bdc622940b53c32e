// Ctrl-C and termination requests become a flag that computations look at.
#pragma once

namespace kinetostat::apps {

/// From now on the first SIGINT or SIGTERM only sets the flag; a second one ends the process at
/// once, and so do ten seconds after a SIGTERM in which nobody looked at the flag. Files are
/// written atomically, so either way nothing is left half-written.
void catch_signals();

/// The signal that asked the program to stop, or 0.
int cancelling_signal();

}  // namespace kinetostat::apps

// How much memory there is, and how much the process has.
#pragma once

namespace kinetostat::common {

/// Memory that the process could have in all [bytes]: its own and most of what the machine, or the
/// control group that the process is in, still has free. Infinite where the system does not say.
double memory_share();

/// What a limit on its address space (`ulimit -v`) leaves the process [bytes]; infinite without
/// one.
double address_space_left();

/// Resident memory of the process now, and its peak so far [bytes]; 0 where the system does not
/// say.
double resident_memory();
double peak_memory();

/// Gives back to the system what is free inside the heap, where the allocator can do so.
void give_back_free_memory();

}  // namespace kinetostat::common

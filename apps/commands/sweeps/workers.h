// A command in parts on the workers of a Dask cluster, by the Python package kinetostat.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "kinetostat/apps/cli/command.h"

namespace kinetostat::apps {

/// Of the option: a cluster of its own on this machine, instead of the address of a scheduler.
inline constexpr const char* local_cluster = "local";

/// Runs a command (its words, without the name of the program) in parts on workers, each with
/// --part, and writes the table that is joined to `out`, with the bytes of one run. `scheduler`:
/// its address, "tcp://host:8786", or local_cluster. Throws UsageError where Debian's Python, its
/// package distributed or the package kinetostat is missing, or the scheduler does not answer, with
/// the words that say why; common::Cancelled.
void run_on_workers(const std::string& scheduler, const std::vector<std::string>& words,
                    const std::filesystem::path& out, Run& run);

}  // namespace kinetostat::apps

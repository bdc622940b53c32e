#include "kinetostat/apps/commands/sweeps/workers.h"

#include <cstdlib>

#include <fmt/format.h>

#include "kinetostat/common/child_process.h"
#include "kinetostat/common/error.h"

namespace kinetostat::apps {
namespace {

namespace fs = std::filesystem;

// That of Debian, whose packages the Python package needs, whatever else is on the path.
fs::path python() {
  const fs::path debian = "/usr/bin/python3";
  return fs::exists(debian) ? debian : common::find_program("python3");
}

// The package beside a program that was built, not installed, comes first.
std::string module_path() {
  const char* const given = std::getenv("PYTHONPATH");
  std::string path = given == nullptr ? "" : given;
  if (const fs::path built = common::find_helper("python/kinetostat"); !built.empty())
    path = built.parent_path().string() + (path.empty() ? "" : ":" + path);
  return path;
}

// The last line that says something.
std::string last_line(const std::string& words) {
  const std::size_t end = words.find_last_not_of(" \n");
  if (end == std::string::npos) return {};
  const std::size_t begin = words.rfind('\n', end);
  return words.substr(begin == std::string::npos ? 0 : begin + 1, end - (begin + 1) + 1);
}

[[noreturn]] void refuse(const std::string& scheduler, const common::ChildResult& child) {
  const auto said = [&](const char* text) { return child.words.find(text) != std::string::npos; };
  if (said("No module named 'kinetostat'") || said("No module named kinetostat"))
    throw UsageError("--scheduler", "the Python package kinetostat is not installed",
                     "Install python3-kinetostat, or build with -D KINETOSTAT_PYTHON=ON");
  if (said("No module named 'distributed'"))
    throw UsageError("--scheduler", "Dask is not installed", "Install python3-distributed");
  if (said("Timed out") || said("ConnectionRefused") || said("gaierror") || said("CommClosedError"))
    throw UsageError(
        "--scheduler", fmt::format("no scheduler answers at {}", scheduler),
        "Start one with 'dask-scheduler', and workers with 'dask-worker', or give 'local'");
  const std::string refused = fmt::format("a worker was refused: {}", child.words);
  if (child.code == bad_input) throw common::InputError({.file = {}, .what = refused});
  if (child.code == bad_usage) throw UsageError("--scheduler", refused);
  throw UsageError("--scheduler", fmt::format("the workers failed: {}", last_line(child.words)),
                   "Run the sweep without --scheduler to see whether it is the cluster's fault");
}

}  // namespace

void run_on_workers(const std::string& scheduler, const std::vector<std::string>& words,
                    const fs::path& out, Run& run) {
  const fs::path python3 = python();
  if (python3.empty())
    throw UsageError("--scheduler", "there is no python3", "Install python3-distributed");
  common::ChildCall call{.program = "/usr/bin/env",
                         .arguments = {"KINETOSTAT=" + common::find_helper("kinetostat").string(),
                                       "PYTHONPATH=" + module_path(), python3.string(), "-m",
                                       "kinetostat.cluster", "--out", out.string()},
                         .input = {}};
  if (scheduler != local_cluster)
    call.arguments.insert(call.arguments.end(), {"--scheduler", scheduler});
  else
    call.arguments.insert(call.arguments.end(), {"--workers", std::to_string(run.threads())});
  call.arguments.emplace_back("--");
  call.arguments.insert(call.arguments.end(), words.begin(), words.end());
  const common::ChildResult child = common::run_child(call, "parts on workers", run.progress());
  if (child.end != common::ChildResult::End::exited || child.code != 0) refuse(scheduler, child);
}

}  // namespace kinetostat::apps

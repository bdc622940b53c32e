#include "kinetostat/common/memory.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <malloc.h>
#include <string>
#include <sys/resource.h>

// Of jemalloc, where the process has it: the program does, Python does not.
extern "C" __attribute__((weak)) int mallctl(const char* name, void* old, std::size_t* old_size,
                                             void* value, std::size_t size);

namespace kinetostat::common {
namespace {

constexpr double share = 0.9;  // of what is free; the rest is for the others

constexpr double unknown = std::numeric_limits<double>::infinity();

// The number after the word `key` at the start of a line; `otherwise` without one.
double number_after(const char* file, const std::string& key, double otherwise) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);)
    if (line.rfind(key + " ", 0) == 0 || line.rfind(key + ":", 0) == 0) {
      const char* number = line.c_str() + key.size() + 1;
      char* end = nullptr;
      const double value = std::strtod(number, &end);
      if (end != number) return value;
    }
  return otherwise;
}

// What the control group leaves, not counting files that it has read as used.
double free_in_group() {
  std::ifstream stream("/sys/fs/cgroup/memory.max");
  double most = 0;
  if (!(stream >> most)) return unknown;  // no group, or "max"
  return std::max(0.0, most - number_after("/sys/fs/cgroup/memory.stat", "anon", 0));
}

}  // namespace

double memory_share() {
  const double free = 1024 * number_after("/proc/meminfo", "MemAvailable", unknown);
  return resident_memory() + share * std::min(free, free_in_group());
}

double address_space_left() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unknown;
  const double used = 1024 * number_after("/proc/self/status", "VmSize", 0);
  return std::max(0.0, static_cast<double>(limit.rlim_cur) - used);
}

double resident_memory() { return 1024 * number_after("/proc/self/status", "VmRSS", 0); }

double peak_memory() { return 1024 * number_after("/proc/self/status", "VmHWM", 0); }

void give_back_free_memory() {
  if (mallctl != nullptr) {
    mallctl("arena.4096.purge", nullptr, nullptr, nullptr, 0);  // of all arenas
    return;
  }
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace kinetostat::common

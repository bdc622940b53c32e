#include "kinetostat/apps/cli/process.h"

#include <cstdlib>
#include <exception>
#include <fcntl.h>
#include <fstream>
#include <new>
#include <string_view>
#include <sys/resource.h>
#include <unistd.h>

#include "kinetostat/apps/cli/command.h"

// What jemalloc reads before main(). All threads share one heap, so that what one frees another
// uses: the forecast of memory for finite elements counts on it, and they allocate little inside
// parallel loops. What is free for 30 ms goes back to the system, its addresses too, which may be
// limited.
extern "C" {
const char* malloc_conf =
    "narenas:1,dirty_decay_ms:30,muzzy_decay_ms:0,tcache_max:8192,retain:false";
}

namespace kinetostat::apps {
namespace {

void hold_standard_streams() {
  for (const int number : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(number, F_GETFD) < 0)  // opened the wrong way round, so that using it still fails
      (void)open("/dev/null", number == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

bool is_limited(decltype(RLIMIT_AS) resource) {
  rlimit limit{};
  return getrlimit(resource, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
}

// The system promises no more memory than it has.
bool promises_are_kept() {
  int policy = 0;
  std::ifstream("/proc/sys/vm/overcommit_memory") >> policy;
  return policy == 2;
}

// Where memory runs out once more while that is being said, nothing can be built or caught.
[[noreturn]] void end_without_memory() {
  try {
    if (const std::exception_ptr error = std::current_exception()) std::rethrow_exception(error);
  } catch (const std::bad_alloc&) {
    constexpr std::string_view words = "kinetostat: not enough memory\n";
    (void)!write(STDERR_FILENO, words.data(), words.size());
    _exit(out_of_memory);
  } catch (...) {
  }
  std::abort();
}

}  // namespace

void prepare_process(char** argv) {
  constexpr const char* threads = "OPENBLAS_NUM_THREADS";
  hold_standard_streams();
  std::set_terminate(end_without_memory);
  const bool limited = is_limited(RLIMIT_AS) || is_limited(RLIMIT_DATA) || promises_are_kept();
  if (!limited || std::getenv(threads) != nullptr) return;
  setenv(threads, "1", 1);
  execv("/proc/self/exe", argv);  // if it fails, this process does what it can
}

}  // namespace kinetostat::apps

#include "kinetostat/apps/cli/process.h"

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <fcntl.h>
#include <fstream>
#include <new>
#include <string_view>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include "kinetostat/apps/cli/command.h"

// What jemalloc reads before main(). All threads share one heap, so that what one frees another
// uses: the forecast of memory for finite elements counts on it, and they allocate little inside
// parallel loops. What is free for 0.3 s goes back to the system, its addresses too, which may be
// limited. Matrices of up to 256 kB are kept for the next of their size: a diagnosis would be given
// their pages anew again and again.
extern "C" {
const char* malloc_conf =
    "narenas:1,dirty_decay_ms:300,muzzy_decay_ms:0,tcache_max:262144,retain:false";
}

namespace kinetostat::apps {
namespace {

void hold_standard_streams() {
  for (const int number : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(number, F_GETFD) < 0)  // opened the wrong way round, so that using it still fails
      (void)open("/dev/null", number == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

// Of address space or data [bytes]; as many as there can be where there is no limit.
rlim_t memory_limit() {
  rlim_t least = RLIM_INFINITY;
  for (const auto resource : {RLIMIT_AS, RLIMIT_DATA})
    if (rlimit limit{}; getrlimit(resource, &limit) == 0) least = std::min(least, limit.rlim_cur);
  return least;
}

// One, unless the user has said otherwise; whether it is new.
bool limit_threads(const char* variable) {
  return std::getenv(variable) == nullptr && setenv(variable, "1", 1) == 0;
}

// The system promises no more memory than it has.
bool promises_are_kept() {
  int policy = 0;
  std::ifstream("/proc/sys/vm/overcommit_memory") >> policy;
  return policy == 2;
}

constexpr std::string_view no_memory = "kinetostat: not enough memory\n";

// Libraries take memory before main(), and each fails in a way of its own where there is none: by a
// segmentation fault or with the exit code of bad input. Before them all, hence by nothing but the
// system, it is seen whether there is enough for them.
void require_memory_for_libraries() {
  constexpr std::size_t for_libraries = std::size_t{16} << 20;
  void* room = mmap(nullptr, for_libraries, PROT_READ | PROT_WRITE,
                    MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (room != MAP_FAILED && munmap(room, for_libraries) == 0) return;
  (void)!write(STDERR_FILENO, no_memory.data(), no_memory.size());
  _exit(out_of_memory);
}
__attribute__((section(".preinit_array"),
               used)) void (*const first)() = require_memory_for_libraries;

// Where memory runs out once more while that is being said, nothing can be built or caught.
[[noreturn]] void end_without_memory() {
  try {
    if (const std::exception_ptr error = std::current_exception()) std::rethrow_exception(error);
  } catch (const std::bad_alloc&) {
    (void)!write(STDERR_FILENO, no_memory.data(), no_memory.size());
    _exit(out_of_memory);
  } catch (...) {
  }
  std::abort();
}

}  // namespace

void prepare_process(char** argv) {
  // OpenMP ends the program by itself, with code 1, where there is no memory for a thread.
  constexpr rlim_t room_for_openmp = rlim_t{1} << 30;
  hold_standard_streams();
  std::set_terminate(end_without_memory);
  const rlim_t limit = memory_limit();
  const bool is_limited = limit != RLIM_INFINITY || promises_are_kept();
  const bool blas = is_limited && limit_threads("OPENBLAS_NUM_THREADS");
  const bool openmp = limit < room_for_openmp && limit_threads("OMP_THREAD_LIMIT");
  if (blas || openmp) execv("/proc/self/exe", argv);  // if it fails, this process does what it can
}

}  // namespace kinetostat::apps

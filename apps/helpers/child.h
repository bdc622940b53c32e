// Common parts of the helper programs: bytes in, bytes out, and their limits. Nothing but the
// standard library, so that the helpers share no code with the rest.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <string>
#include <sys/resource.h>
#include <unistd.h>
#include <vector>

namespace kinetostat {

inline std::string read_all(int descriptor) {
  std::string bytes;
  std::vector<char> buffer(1 << 20);
  for (ssize_t got; (got = read(descriptor, buffer.data(), buffer.size())) > 0;)
    bytes.append(buffer.data(), static_cast<std::size_t>(got));
  return bytes;
}

inline bool write_all(int descriptor, const std::string& bytes) {
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t put = write(descriptor, bytes.data() + at, bytes.size() - at);
    if (put <= 0) return false;
    at += static_cast<std::size_t>(put);
  }
  return true;
}

/// No core dump, and no more memory than the arguments `--memory BYTES` say. The address sanitizer
/// reserves terabytes of address space: no limit then.
inline void limit_process(int argc, char** argv) {
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
#ifndef __SANITIZE_ADDRESS__
  if (argc != 3 || std::string(argv[1]) != "--memory") return;
  const rlim_t wanted = std::strtoull(argv[2], nullptr, 10);
  rlimit limit{};
  if (wanted == 0 || getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur <= wanted) return;
  limit.rlim_cur = wanted;  // the hard limit stays: raising it is refused
  setrlimit(RLIMIT_AS, &limit);
#else
  (void)argc, (void)argv;
#endif
}

/// What a library cannot do with what it was given.
class Impossible : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Ends the process with the exit code that `work` returns, or with that of memory that is out or
/// of any other exception, whose words go to standard output.
template <class Work>
[[noreturn]] void end_with(const Work& work, int out_of_memory, int impossible) {
  int code = EXIT_FAILURE;
  try {
    code = work();
  } catch (const std::bad_alloc&) {
    code = out_of_memory;
  } catch (const std::exception& error) {
    std::puts(error.what());
    code = impossible;
  }
  std::fflush(stdout);
  _exit(code);
}

}  // namespace kinetostat

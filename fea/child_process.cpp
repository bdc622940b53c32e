#include "kinetostat/fea/child_process.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <system_error>
#include <thread>
#include <unistd.h>

namespace kinetostat::fea {
namespace {

[[noreturn]] void fail(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

// A file in memory without a name.
class MemoryFile {
 public:
  explicit MemoryFile(const char* label) : descriptor_(memfd_create(label, MFD_CLOEXEC)) {
    if (descriptor_ < 0) fail("memfd_create");
    // Out of the way of descriptors 0 to 3, which the child rearranges.
    if (descriptor_ <= 3) {
      const int higher = fcntl(descriptor_, F_DUPFD_CLOEXEC, 4);
      close(descriptor_);
      descriptor_ = higher;
      if (descriptor_ < 0) fail("fcntl");
    }
  }
  ~MemoryFile() { close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  int descriptor() const { return descriptor_; }

  void write_all(const std::string& bytes) const {
    for (std::size_t at = 0; at < bytes.size();) {
      const ssize_t put = write(descriptor_, bytes.data() + at, bytes.size() - at);
      if (put < 0 && errno != EINTR) fail("write");
      if (put > 0) at += static_cast<std::size_t>(put);
    }
    lseek(descriptor_, 0, SEEK_SET);
  }
  std::string read_all() const {
    const off_t size = lseek(descriptor_, 0, SEEK_END);
    std::string bytes(static_cast<std::size_t>(std::max<off_t>(size, 0)), '\0');
    std::size_t at = 0;
    while (at < bytes.size()) {
      const ssize_t got =
          pread(descriptor_, bytes.data() + at, bytes.size() - at, static_cast<off_t>(at));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) break;
      at += static_cast<std::size_t>(got);
    }
    bytes.resize(at);
    return bytes;
  }

 private:
  int descriptor_;
};

// A child that is killed and buried when this goes out of scope before it has ended.
class Child {
 public:
  explicit Child(pid_t pid) : pid_(pid) {}
  ~Child() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    while (waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  bool has_ended(int& status) {
    if (waitpid(pid_, &status, WNOHANG) != pid_) return false;
    pid_ = 0;
    return true;
  }

 private:
  pid_t pid_;
};

// Between fork and exec only calls that are safe when other threads held locks at the fork.
[[noreturn]] void become(const char* program, char* const* arguments, const int* descriptors,
                         pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(127);  // the parent died before the line above
  const int targets[] = {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO, 3};
  for (int i = 0; i < 4; ++i)
    if (dup2(descriptors[i], targets[i]) < 0) _exit(127);
  execv(program, arguments);
  _exit(127);
}

}  // namespace

ChildResult run_child(const ChildCall& call, const std::string& phase, files::Progress& progress) {
  const std::string program = call.program.string();
  if (access(program.c_str(), X_OK) != 0) fail(program.c_str());
  const MemoryFile input("request"), answer("answer"), words("words");
  input.write_all(call.input);
  std::vector<std::string> copies{program};
  copies.insert(copies.end(), call.arguments.begin(), call.arguments.end());
  std::vector<char*> arguments;
  for (std::string& argument : copies) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  const int descriptors[] = {input.descriptor(), words.descriptor(), words.descriptor(),
                             answer.descriptor()};

  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0) fail("fork");
  if (pid == 0) become(program.c_str(), arguments.data(), descriptors, parent);

  Child child(pid);
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  auto nap = std::chrono::microseconds(200);
  int status = 0;
  while (!child.has_ended(status)) {
    const double elapsed = std::chrono::duration<double>(Clock::now() - start).count();
    if (call.time_limit > 0 && elapsed > call.time_limit)
      return {.end = ChildResult::End::timed_out, .answer = {}, .words = words.read_all()};
    progress.report(phase, 0);
    std::this_thread::sleep_for(nap);
    nap = std::min(nap * 2, std::chrono::microseconds(20000));
  }
  ChildResult result{.answer = answer.read_all(), .words = words.read_all()};
  if (WIFSIGNALED(status)) {
    result.end = ChildResult::End::killed_by_signal;
    result.code = WTERMSIG(status);
  } else {
    result.code = WEXITSTATUS(status);
  }
  return result;
}

}  // namespace kinetostat::fea

#include "kinetostat/common/child_process.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <dlfcn.h>
#include <fcntl.h>
#include <sstream>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <system_error>
#include <thread>
#include <unistd.h>

#include "kinetostat/common/out_of_memory.h"

namespace kinetostat::common {
namespace {

constexpr rlim_t isolated_memory = rlim_t{8} << 30;  // [bytes] of address space

[[noreturn]] void fail(const char* what) {
  if (errno == ENOMEM || errno == EAGAIN)
    throw OutOfMemory("there is not enough memory to start another process",
                      "Close other programs");
  throw std::system_error(errno, std::generic_category(), what);
}

constexpr int rearranged = 5;  // descriptors 0 to 4 of a child program

// A file in memory without a name.
class MemoryFile {
 public:
  explicit MemoryFile(const char* label) : descriptor_(memfd_create(label, MFD_CLOEXEC)) {
    if (descriptor_ < 0) fail("memfd_create");
    // Out of the way of the descriptors that the child rearranges.
    if (descriptor_ < rearranged) {
      const int higher = fcntl(descriptor_, F_DUPFD_CLOEXEC, rearranged);
      close(descriptor_);
      descriptor_ = higher;
      if (descriptor_ < 0) fail("fcntl");
    }
  }
  ~MemoryFile() { close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  int descriptor() const { return descriptor_; }
  // While this process lives.
  std::string path() const {
    return "/proc/" + std::to_string(getpid()) + "/fd/" + std::to_string(descriptor_);
  }

  void write_all(const std::string& bytes, const std::vector<std::string_view>& more = {}) const {
    append(bytes);
    for (const std::string_view part : more) append(part);
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
  void append(std::string_view bytes) const {
    for (std::size_t at = 0; at < bytes.size();) {
      const ssize_t put = write(descriptor_, bytes.data() + at, bytes.size() - at);
      if (put < 0 && errno != EINTR) fail("write");
      if (put > 0) at += static_cast<std::size_t>(put);
    }
  }

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

// A list of texts as system calls take it.
class PointerList {
 public:
  explicit PointerList(std::vector<std::string> texts) : texts_(std::move(texts)) {
    for (std::string& text : texts_) pointers_.push_back(text.data());
    pointers_.push_back(nullptr);
  }
  PointerList(const PointerList&) = delete;
  PointerList& operator=(const PointerList&) = delete;
  char* const* get() const { return pointers_.data(); }

 private:
  std::vector<std::string> texts_;
  std::vector<char*> pointers_;
};

// The environment of this process, with what a call gives instead.
std::vector<std::string> environment_of(const ChildCall& call) {
  std::vector<std::string> all = call.environment;
  const auto is_given = [&call](std::string_view variable) {
    const std::string_view name = variable.substr(0, variable.find('=') + 1);
    return std::any_of(call.environment.begin(), call.environment.end(),
                       [name](const std::string& given) { return given.starts_with(name); });
  };
  for (char** variable = environ; *variable != nullptr; ++variable)
    if (!is_given(*variable)) all.emplace_back(*variable);
  return all;
}

// What a child needs between fork and exec, made before the fork.
struct Exec {
  const char* program;
  char* const* arguments;
  char* const* environment;
  const char* folder;  // nullptr: that of the parent
  std::array<int, rearranged> descriptors;
  std::size_t memory_limit;
};

// Lowers the limit on the address space of this process; a lower one stays.
void limit_memory(rlim_t bytes) {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur <= bytes) return;
  limit.rlim_cur = bytes;
  setrlimit(RLIMIT_AS, &limit);
}

// Between fork and exec only calls that are safe when other threads held locks at the fork.
[[noreturn]] void become(const Exec& exec, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(127);  // the parent died before the line above
  if (exec.folder != nullptr && chdir(exec.folder) != 0) _exit(127);
  for (int target = 0; target < rearranged; ++target)
    if (dup2(exec.descriptors[static_cast<std::size_t>(target)], target) < 0) _exit(127);
  if (exec.memory_limit > 0) limit_memory(exec.memory_limit);
  execve(exec.program, exec.arguments, exec.environment);
  _exit(errno == ENOMEM ? exit_out_of_memory : 127);
}

// In the copy: nothing of the parent may run but the work, not even its exit handlers.
[[noreturn]] void work_alone(const std::function<std::string()>& work, const MemoryFile& answer,
                             const MemoryFile& words, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
#ifndef __SANITIZE_ADDRESS__  // which reserves terabytes of address space
  limit_memory(isolated_memory);
#endif
  try {
    answer.write_all(work());
  } catch (const std::bad_alloc&) {
    _exit(exit_out_of_memory);
  } catch (const std::exception& error) {
    words.write_all(error.what());
    _exit(1);
  }
  _exit(0);
}

// In the copy: its streams go to the words, and nothing of the parent runs but the work.
[[noreturn]] void work_as_program(const std::function<int()>& work, const MemoryFile& words,
                                  pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO})
    if (dup2(words.descriptor(), stream) < 0) _exit(1);
  int code = 1;
  try {
    code = work();
  } catch (...) {  // exit code 1
  }
  std::fflush(nullptr);
  _exit(code);
}

ChildResult result_of(int status, std::string answer, std::string words) {
  ChildResult result{.answer = std::move(answer), .words = std::move(words)};
  if (WIFSIGNALED(status)) {
    result.end = ChildResult::End::killed_by_signal;
    result.code = WTERMSIG(status);
  } else {
    result.code = WEXITSTATUS(status);
  }
  return result;
}

// Waits for the child, which must write to the two files.
template <class Tick>
ChildResult finish(pid_t pid, const MemoryFile& answer, const MemoryFile& words, double time_limit,
                   Tick tick) {
  using Clock = std::chrono::steady_clock;
  Child child(pid);
  const auto start = Clock::now();
  auto nap = std::chrono::microseconds(200);
  int status = 0;
  while (!child.has_ended(status)) {
    const double elapsed = std::chrono::duration<double>(Clock::now() - start).count();
    if (time_limit > 0 && elapsed > time_limit)
      return {.end = ChildResult::End::timed_out, .answer = {}, .words = words.read_all()};
    tick();
    std::this_thread::sleep_for(nap);
    nap = std::min(nap * 2, std::chrono::microseconds(20000));
  }
  return result_of(status, answer.read_all(), words.read_all());
}

}  // namespace

bool ChildResult::ran_out_of_memory() const {
  const auto said = [this](const char* text) { return words.find(text) != std::string::npos; };
  if (end == End::timed_out) return false;
  if (end == End::killed_by_signal) return code == SIGKILL || said("std::bad_alloc");
  const bool not_loaded = code == 127 && said("shared");
  constexpr int killed_below = 128 + SIGKILL;  // as shells and mpirun say it
  return code == exit_out_of_memory || code == killed_below ||
         (not_loaded && (said("failed to map") || said("cannot map") || said("annot allocate")));
}

namespace {

// The shared library that has this code; empty where the program itself has it.
std::filesystem::path own_library() {
  static const char here = 0;
  Dl_info found = {};
  if (::dladdr(&here, &found) == 0 || found.dli_fname == nullptr) return {};
  const std::filesystem::path file = found.dli_fname;
  return file.extension() == ".so" ? std::filesystem::absolute(file) : std::filesystem::path();
}

}  // namespace

std::filesystem::path find_helper(const std::string& name) {
  std::error_code ignored;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", ignored);
  std::vector<std::filesystem::path> folders;
  if (!program.empty())  // or the folders below would be those of whoever calls
    folders = {program.parent_path(),
               program.parent_path().parent_path() / "libexec" / "kinetostat"};
  if (const std::filesystem::path library = own_library().parent_path(); !library.empty())
    folders.insert(folders.end(), {library, library.parent_path().parent_path()});
  folders.emplace_back(KINETOSTAT_LIBEXEC_DIR);
  for (const std::filesystem::path& folder : folders)
    if (std::filesystem::exists(folder / name, ignored)) return folder / name;
  return {};
}

std::filesystem::path find_program(const std::string& name) {
  std::error_code ignored;
  if (name.find('/') != std::string::npos)
    return std::filesystem::is_regular_file(name, ignored) ? std::filesystem::path(name)
                                                           : std::filesystem::path();
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');)
    if (auto program = std::filesystem::path(folder) / name;
        !folder.empty() && std::filesystem::is_regular_file(program, ignored))
      return program;
  return {};
}

ChildResult run_child(const ChildCall& call, const std::string& phase, common::Progress& progress) {
  const std::string program = std::filesystem::absolute(call.program).string();
  if (access(program.c_str(), X_OK) != 0) fail(program.c_str());
  const MemoryFile input("request"), second("second request"), answer("answer"), words("words");
  input.write_all(call.input, call.more_input);
  second.write_all(call.second_input);
  std::vector<std::string> copies{program};
  for (const std::string& argument : call.arguments)
    copies.push_back(argument == ChildCall::input_path    ? input.path()
                     : argument == ChildCall::answer_path ? answer.path()
                                                          : argument);
  const PointerList arguments(std::move(copies)), environment(environment_of(call));
  const Exec exec{.program = program.c_str(),
                  .arguments = arguments.get(),
                  .environment = environment.get(),
                  .folder = call.folder.empty() ? nullptr : call.folder.c_str(),
                  .descriptors = {input.descriptor(), words.descriptor(), words.descriptor(),
                                  answer.descriptor(), second.descriptor()},
                  .memory_limit = call.memory_limit};
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0) fail("fork");
  if (pid == 0) become(exec, parent);
  return finish(pid, answer, words, call.time_limit, [&] { progress.report(phase, 0); });
}

struct ProcessCopy::State {
  MemoryFile words{"words"};
  std::optional<Child> child = {};
};

ProcessCopy::ProcessCopy(const std::function<int()>& work) : state_(std::make_unique<State>()) {
  std::fflush(nullptr);  // or the copy would write it again
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0) fail("fork");
  if (pid == 0) work_as_program(work, state_->words, parent);
  state_->child.emplace(pid);
}

ProcessCopy::~ProcessCopy() = default;
ProcessCopy::ProcessCopy(ProcessCopy&& other) noexcept = default;
ProcessCopy& ProcessCopy::operator=(ProcessCopy&& other) noexcept = default;

std::optional<ChildResult> ProcessCopy::result() {
  int status = 0;
  if (!state_->child || !state_->child->has_ended(status)) return std::nullopt;
  return result_of(status, {}, state_->words.read_all());
}

ChildResult run_isolated(const std::function<std::string()>& work, double time_limit) {
  const MemoryFile answer("answer"), words("words");
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0) fail("fork");
  if (pid == 0) work_alone(work, answer, words, parent);
  return finish(pid, answer, words, time_limit, [] {});
}

}  // namespace kinetostat::common

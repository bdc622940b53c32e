// Work done in another process, within limits, without touching the disk.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinetostat/common/progress.h"

namespace kinetostat::common {

struct ChildResult {
  enum class End { exited, killed_by_signal, timed_out };
  End end = End::exited;
  int code = 0;        // exit code, or number of the signal
  std::string answer;  // what it wrote to file descriptor 3
  std::string words;   // what it wrote to standard output and standard error

  /// It said so, by its exit code or the words of a C++ exception or of the system's loader, or the
  /// system killed it, which is what Linux does when memory runs out.
  bool ran_out_of_memory() const;
};

/// Exit code of a helper program, and of run_isolated(), that says so.
inline constexpr int exit_out_of_memory = 65;

struct ChildCall {
  /// Among the arguments, these stand for paths by which any process of the same user on this
  /// machine reads the input and writes the answer: for programs that a launcher starts.
  static constexpr const char* input_path = "@input";
  static constexpr const char* answer_path = "@answer";

  std::filesystem::path program;
  std::vector<std::string> arguments;
  std::string input;              // on its standard input
  double time_limit = 0;          // [s]; then it is killed
  std::string second_input = {};  // on file descriptor 4, which can be read from any place
  std::vector<std::string_view> more_input = {};  // behind `input`, from where it lies
  std::size_t memory_limit = 0;                   // [bytes] of address space; 0: none
  std::filesystem::path folder = {};              // it works in; empty: that of this process
  std::vector<std::string> environment = {};      // "NAME=VALUE", instead of those of this process
};

/// Where a helper program of this name is: beside the running program, else in
/// ../libexec/kinetostat from there (an installation may be moved), else, for Python, which runs
/// another program, beside the library with this code, as a wheel has them, or two folders above
/// it, which is the build folder of python/kinetostat/_core.so; else in the folder that was fixed
/// when kinetostat was configured.
/// Empty when in none.
std::filesystem::path find_helper(const std::string& name);

/// The program that a shell would start by this name: a path, or a name in the folders of PATH.
/// Empty when there is none.
std::filesystem::path find_program(const std::string& name);

/// Runs the program and waits. It is killed when the time is over, when `progress` is cancelled and
/// when this process ends for whatever reason. Data pass through anonymous memory files, which
/// leave nothing behind. Throws OutOfMemory when there is none for another process, and
/// std::system_error when it cannot be started.
ChildResult run_child(const ChildCall& call, const std::string& phase, common::Progress& progress);

/// Work in a copy of this process: its value is the exit code, what it writes to standard output
/// and standard error the words. Nothing is loaded again, so it starts in a millisecond. It is
/// killed when this goes out of scope and when this process ends. This process must have one thread
/// only, beside those of OpenBLAS, which it stops before a fork: locks that others held would never
/// be opened in the copy.
class ProcessCopy {
 public:
  /// Throws OutOfMemory and std::system_error as run_child().
  explicit ProcessCopy(const std::function<int()>& work);
  ~ProcessCopy();
  ProcessCopy(ProcessCopy&& other) noexcept;
  ProcessCopy& operator=(ProcessCopy&& other) noexcept;

  /// None while it runs. Once only.
  std::optional<ChildResult> result();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Runs `work` in a copy of this process and returns its value as the answer: for libraries that
/// may crash or never end on damaged input. The copy may take 8 GiB of address space. An exception
/// of `work` ends it with exit code 1, or exit_out_of_memory, and what() among the words. Throws
/// OutOfMemory and std::system_error as run_child().
ChildResult run_isolated(const std::function<std::string()>& work, double time_limit);

}  // namespace kinetostat::common

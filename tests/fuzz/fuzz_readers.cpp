// Gives every reader of the product files with mistakes in them.
//
//   fuzz_readers [--reader NAME] [--runs N] [--seed S] [--seconds S] [--out DIR]
//   fuzz_readers --reader NAME --replay FILE
//
// Each run must end within the time and in an answer or a documented refusal; anything else (a
// crash, a complaint of a sanitizer, another exception, no end, too much memory) is a fault: its
// file is written to DIR, and the program ends with 1. The same seed gives the same files.
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <new>
#include <optional>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"

#include "fuzz/mutation.h"
#include "fuzz/readers.h"
#include "support/temporary_folder.h"

namespace kinetostat::fuzz {
namespace {

struct Options {
  std::string reader;  // empty: all
  std::string replay;  // a file; empty: mistakes are made
  std::filesystem::path out = "fuzz-faults";
  std::size_t runs = 1000;
  std::uint64_t seed = 1;
  unsigned seconds = 20;  // for one file
};

// Shared with the process that reads, which may die at any time.
struct Shared {
  std::atomic<std::size_t> run, accepted, refused;
};

Shared& shared_memory() {
  void* memory =
      mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  return *new (memory) Shared{};
}

std::uint64_t hash(const std::string& text) {  // FNV-1a
  std::uint64_t h = 0xcbf29ce484222325;
  for (const char c : text) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return h;
}

// The first runs get the sound files.
std::string input_of(const Reader& reader, const Options& options, std::size_t run) {
  if (run < reader.sound.size()) return reader.sound[run];
  Random random(options.seed ^ hash(reader.name) ^ (run * 0x9e3779b97f4a7c15));
  std::vector<std::string> parts = reader.sound;
  if (reader.sealed && random.chance(2)) {
    const auto& contents = reader.contents;
    return reader.sealed(mutated(contents[random.below(contents.size())], contents, random));
  }
  const std::string& base = reader.sound[random.below(reader.sound.size())];
  parts.insert(parts.end(), reader.others.begin(), reader.others.end());
  return mutated(base, parts, random);
}

// Empty, or what is wrong. `accepted` tells whether the reader took it.
std::string fault_of(const Reader& reader, const std::string& input, bool& accepted) {
  accepted = false;
  try {
    reader.read(input);
    accepted = true;
    return {};
  } catch (const common::InputError&) {
  } catch (const common::NoConvergence&) {
  } catch (const common::NotIdentifiable&) {
  } catch (const std::bad_alloc&) {
    return "takes all memory";
  } catch (const std::exception& error) {
    return fmt::format("throws {}", error.what());
  }
  return {};
}

constexpr int found_fault = 3;

// Reads from `first` on, until something is wrong or all is done.
[[noreturn]] void read_on(const Reader& reader, const Options& options, std::size_t first,
                          Shared& shared) {
  for (std::size_t run = first; run < options.runs; ++run) {
    shared.run = run;
    alarm(options.seconds);
    bool accepted = false;
    std::string fault = fault_of(reader, input_of(reader, options, run), accepted);
    if (run < reader.sound.size() && !accepted) fault = "refuses a sound file";
    ++(accepted ? shared.accepted : shared.refused);
    if (fault.empty()) continue;
    std::cerr << reader.name << ": run " << run << ": " << fault << "\n";
    _exit(found_fault);
  }
  _exit(0);
}

std::string end_in_words(int status) {
  if (WIFEXITED(status)) return fmt::format("exit code {}", WEXITSTATUS(status));
  if (WTERMSIG(status) == SIGALRM) return "reading never ends";
  return fmt::format("signal {}", WTERMSIG(status));
}

// How many faults.
std::size_t fuzz(const Reader& reader, const Options& options) {
  constexpr std::size_t most_faults = 20;  // of one reader: the others want their turn
  Shared& shared = shared_memory();
  const auto start = std::chrono::steady_clock::now();
  std::size_t faults = 0;
  for (std::size_t first = 0; first < options.runs && faults < most_faults;
       first = shared.run + 1) {
    const pid_t pid = fork();
    if (pid < 0) throw std::runtime_error("no process can be started");
    if (pid == 0) read_on(reader, options, first, shared);
    int status = 0;
    waitpid(pid, &status, 0);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) break;
    ++faults;
    const std::filesystem::path file =
        options.out / fmt::format("{}-{}-{}", reader.name, options.seed, shared.run.load());
    io::write_atomically(file, input_of(reader, options, shared.run));
    std::cerr << fmt::format("{}: run {}: {}; its file is {}\n", reader.name, shared.run.load(),
                             end_in_words(status), file.string());
  }
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::cout << fmt::format(
                   "{:<12} {:>7} runs, {:>7} accepted, {:>7} refused, {} faults, {:.1f} s\n",
                   reader.name, shared.run + 1, shared.accepted.load(), shared.refused.load(),
                   faults, seconds)
            << std::flush;
  return faults;
}

int replay(const Reader& reader, const std::string& file) {
  bool accepted = false;
  const std::string fault = fault_of(reader, io::read_text(file), accepted);
  std::cout << (!fault.empty() ? fault : accepted ? "accepted" : "refused") << "\n";
  return fault.empty() ? 0 : 1;
}

std::optional<Options> parsed(int argc, char** argv) {
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i], value = argv[i + 1];
    if (name == "--reader")
      options.reader = value;
    else if (name == "--replay")
      options.replay = value;
    else if (name == "--out")
      options.out = value;
    else if (name == "--runs")
      options.runs = std::stoull(value);
    else if (name == "--seed")
      options.seed = std::stoull(value);
    else if (name == "--seconds")
      options.seconds = static_cast<unsigned>(std::stoul(value));
    else
      return std::nullopt;
  }
  if (argc % 2 == 0) return std::nullopt;
  return options;
}

// The address sanitizer reserves terabytes of address space, and has a limit of its own.
void limit_memory() {
#ifndef __SANITIZE_ADDRESS__
  const rlimit limit{rlim_t{4} << 30, RLIM_INFINITY};
  setrlimit(RLIMIT_AS, &limit);
#endif
}

int run(const Options& options) {
  limit_memory();
  const test::TemporaryFolder folder;
  std::size_t faults = 0, known = 0;
  for (const Reader& reader : all_readers(folder.path())) {
    if (!options.reader.empty() && reader.name != options.reader) continue;
    ++known;
    if (!options.replay.empty()) return replay(reader, options.replay);
    faults += fuzz(reader, options);
  }
  if (known == 0) std::cerr << "no reader is called " << options.reader << "\n";
  return faults == 0 && known > 0 ? 0 : 1;
}

}  // namespace
}  // namespace kinetostat::fuzz

// What the sanitizers do unless the environment says otherwise: no more than 4 GB, and an exception
// where a single block is too large.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() {
  return "allocator_may_return_null=1:max_allocation_size_mb=3000:hard_rss_limit_mb=4000:"
         "detect_leaks=0";
}

int main(int argc, char** argv) {
  const auto options = kinetostat::fuzz::parsed(argc, argv);
  if (!options) {
    std::cerr << "fuzz_readers [--reader NAME] [--runs N] [--seed S] [--seconds S] [--out DIR] "
                 "[--replay FILE]\n";
    return 2;
  }
  return kinetostat::fuzz::run(*options);
}

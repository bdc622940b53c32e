// What comes in from outside: files of other kinds, pipes without end, little memory, signals.
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::doors_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::string orthoglide = "data/robots/orthoglide.yaml";

void put(const std::string& name, const std::string& text) {
  io::write_atomically(working_folder() / name, text);
}

std::string robot_called(const std::string& name) {
  std::string text = io::read_text(working_folder() / orthoglide);
  const std::size_t at = text.find("\nname:");
  return text.replace(at, text.find('\n', at + 1) - at, "\nname: " + name);
}

// In a shell, in the working folder, with $K for the program; ended after two minutes.
int shell(const std::string& commands) {
  const std::string call = fmt::format("cd '{}' && K='{}' timeout -s KILL 120 bash -c '{}'",
                                       working_folder().string(), KINETOSTAT_PROGRAM, commands);
  const int status = std::system(("export XDG_CACHE_HOME=/nowhere; " + call).c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::string text_of(const char* file) { return io::read_text(working_folder() / file); }

struct OtherKind {
  std::string name, bytes;
  const char* said;
};

class OtherKinds : public testing::TestWithParam<OtherKind> {};

// One sentence, whatever is given in the place of a robot, and soon.
TEST_P(OtherKinds, AreNamed) {
  put("other.yaml", GetParam().bytes);
  const Outcome outcome = kinetostat("stiffness other.yaml --at 0,0,0");
  EXPECT_EQ(outcome.code, 3) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr(GetParam().said));
  EXPECT_LT(outcome.err.size(), 300u) << outcome.err;
}

INSTANTIATE_TEST_SUITE_P(
    All, OtherKinds,
    testing::Values(OtherKind{"pandas_table", ",id,fx,fy\n0,a,1,2\n1,b,3,4\n", "a table (CSV)"},
                    OtherKind{"comma", ",", "a table (CSV)"},
                    OtherKind{"bracket", "a: 1\n]\n", "not valid YAML"},
                    OtherKind{"picture", "\x89PNG\r\n\x1a\n and more", "a PNG picture"},
                    OtherKind{"workbook", "PK\x03\x04 and more", "a zip archive"},
                    OtherKind{"compressed", "\x1f\x8b\x08 and more", "gzip-compressed data"},
                    OtherKind{"program",
                              "\x7f"
                              "ELF and more",
                              "a program (ELF)"},
                    OtherKind{"bytes", std::string("a: \0\x01\x02", 6), "binary data"}),
    [](const auto& test) { return test.param.name; });

TEST(Devices, AreReadToALimit) {
  const Outcome outcome = kinetostat("stiffness /dev/zero --at 0,0,0");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("/dev/zero"));
}

// What is read again for its checksum would be empty then.
TEST(Pipes, AreNoRobotFiles) {
  EXPECT_EQ(shell("cat " + orthoglide + " | $K stiffness /dev/stdin --at 0,0,0 2>piped"), 3);
  EXPECT_THAT(text_of("piped"), HasSubstr("/dev/stdin: is a pipe"));
}

// Starts the program in the working folder.
pid_t start(const std::vector<std::string>& arguments) {
  std::vector<std::string> words{"bash", "-c",
                                 fmt::format("cd '{}' && exec '{}' \"$@\" 2>started",
                                             working_folder().string(), KINETOSTAT_PROGRAM),
                                 "kinetostat"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  pid_t pid = 0;
  EXPECT_EQ(posix_spawnp(&pid, "bash", nullptr, nullptr, pointers.data(), environ), 0);
  return pid;
}

// The exit code, or 128 + the signal; -1 when it has not ended after some time, and is killed then.
int end_of(pid_t pid, std::chrono::seconds limit) {
  const auto end = std::chrono::steady_clock::now() + limit;
  int status = 0;
  while (waitpid(pid, &status, WNOHANG) == 0) {
    if (std::chrono::steady_clock::now() > end) {
      kill(pid, SIGKILL);
      waitpid(pid, &status, 0);
      return -1;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

TEST(Pipes, EndWithATerminationRequest) {
  const std::filesystem::path pipe = working_folder() / "silent.yaml";
  std::filesystem::remove(pipe);
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const bool has_writer : {false, true}) {
    const pid_t pid = start({"stiffness", "silent.yaml", "--at", "0,0,0"});
    const int writer = has_writer ? open(pipe.c_str(), O_RDWR) : -1;
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    kill(pid, SIGTERM);
    EXPECT_EQ(end_of(pid, std::chrono::seconds(60)), 128 + SIGTERM);
    if (writer >= 0) close(writer);
  }
}

// There is nowhere to report to; the exit code says it, and no file that is opened takes its place.
std::string little_link() {
  std::string link = text_of("meshes/test_bar.yaml");
  link.replace(link.find("size: 3"), 7, "size: 8");
  return link.replace(link.find("test_bar.stl"), 12, "meshes/test_bar.stl");
}

TEST(StandardError, MayBeFullOrClosed) {
  put("little.yaml", little_link());
  for (const char* where : {"2>/dev/full", "2>&-"}) {
    EXPECT_EQ(shell(fmt::format("$K stiffness missing.yaml --at 0,0,0 {}", where)), 3) << where;
    EXPECT_EQ(shell(fmt::format("$K stifness {}", where)), 2) << where;
    EXPECT_EQ(shell(fmt::format("$K identify little.yaml --no-cache -o bar.json {}", where)), 0)
        << where;
    EXPECT_TRUE(io::read_json(working_folder() / "bar.json").contains("compliance")) << where;
  }
}

TEST(StandardOutput, IsNoFileThatIsOpenedLater) {
  EXPECT_EQ(shell("$K stiffness " + orthoglide + " --at 0,0,0 --json closed.json >&-"), 3);
  std::error_code error;
  if (!std::filesystem::exists(working_folder() / "closed.json", error)) return;
  EXPECT_TRUE(io::read_json(working_folder() / "closed.json").contains("tool"));
}

#ifndef __SANITIZE_ADDRESS__  // which reserves terabytes of address space
TEST(LittleMemory, EndsWithAnExitCodeOfItsOwn) {
  put("little.yaml", little_link());
  int ran_out = 0;
  for (const int megabytes : {100, 130, 160, 200, 250, 300, 400, 600}) {
    const int code = shell(
        fmt::format("ulimit -v {}; $K identify little.yaml --no-cache --threads 2 -o little.json "
                    "2>little",
                    1000 * megabytes));
    const std::string said = text_of("little");
    // Before the program itself, the system's loader (127) or OpenBLAS (130) found no memory.
    EXPECT_THAT(code, testing::AnyOf(0, 6, 127, 130)) << megabytes << said;
    if (code == 130) {
      EXPECT_THAT(said, HasSubstr("OpenBLAS"));
    }
    if (code == 6) {
      EXPECT_THAT(said, HasSubstr("memory")) << megabytes;
      ++ran_out;
    }
    EXPECT_THAT(said, Not(HasSubstr("fault of the program"))) << megabytes;
  }
  EXPECT_GT(ran_out, 0);
}

TEST(LittleMemory, IsBadInputToNoCommand) {
  for (const char* command :
       {"mesh check meshes/foot.stl --unit mm", "stiffness data/robots/orthoglide.yaml --at 0,0,0",
        "map data/robots/orthoglide.yaml --grid x=0:10:50,y=0,z=0 --index weakest-translation",
        "compare data/robots/bench.yaml data/measurements/nist_load_cell/campaign.yaml"})
    for (const int megabytes : {60, 80, 90, 92, 94, 96, 98, 100, 120, 140, 170, 200, 300})
      EXPECT_THAT(shell(fmt::format(
                      "export OPENBLAS_NUM_THREADS=1; ulimit -v {}; $K {} --threads 2 >said 2>&1",
                      1000 * megabytes, command)),
                  testing::AnyOf(0, 6, 127))
          << command << ", " << megabytes << " MB: " << text_of("said");
}
#endif

// `timeout` sends the process a signal, and its group another.
TEST(Interruption, OfTwoSignalsAtOnceIsOneAndKeepsWhatIsDone) {
  for (const char* file : {"a", "b", "c"}) {
    EXPECT_EQ(shell(fmt::format(
                  "timeout -s INT 1 $K map data/robots/translational_3puu.yaml --threads 1 -o {} "
                  "--grid x=-60:60:100,y=-60:60:100,z=0:40:100 --wrench 0,0,-200 "
                  "--index weakest-translation >/dev/null 2>&1",
                  file)),
              124);
    EXPECT_THAT(io::read_text(working_folder() / (std::string(file) + ".part")),
                HasSubstr("checkpoint"));
  }
}

TEST(LittleMemory, AModelThatNeedsMoreThanItMayHaveIsNoBadInput) {
  put("allowed.yaml", little_link());
  const Outcome outcome = kinetostat("identify allowed.yaml --no-cache --memory 1MB");
  EXPECT_EQ(outcome.code, 6);
  EXPECT_THAT(outcome.err, HasSubstr("allowed.yaml: the multigrid solver needs"));
  EXPECT_THAT(outcome.err, HasSubstr("or allow more (--memory)"));
}

TEST(Names, CommandNoTerminal) {
  put("evil\x1b[2J.yaml", "a: 1\n");
  const Outcome missing = kinetostat("stiffness 'evil\x1b[2J.yaml' --at 0,0,0");
  EXPECT_EQ(missing.code, 3);
  EXPECT_THAT(missing.err, AllOf(HasSubstr("evil?[2J.yaml"), Not(HasSubstr("\x1b"))));
  put("evil.obj",
      "o part\x1b]0;title\x07\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
      "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
  const Outcome mesh = kinetostat("mesh check evil.obj --unit mm");
  EXPECT_THAT(mesh.out + mesh.err, Not(HasSubstr("\x1b")));
}

TEST(Names, HaveNoLineEnds) {
  put("evil.yaml", robot_called("\"a\\n*INCLUDE, INPUT=/etc/passwd\""));
  const Outcome outcome = kinetostat("stiffness evil.yaml --at 0,0,0");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("control character"));
}

// A table opens in a spreadsheet, which computes what starts with '='.
TEST(Names, AreNoFormulas) {
  put("formula.yaml", robot_called("\"x,=cmd|' /C calc'!A0\""));
  const Outcome outcome =
      kinetostat("trace formula.yaml --at 0,0,0 --along 0,0,0.001 -o formula.csv");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(text_of("formula.csv"), AllOf(HasSubstr("# x,'=cmd"), Not(HasSubstr(",=cmd"))));
}

TEST(LongNames, AreKnownBeforeTheWork) {
  const std::string longest(255, 'x');
  EXPECT_EQ(kinetostat("stiffness " + orthoglide + " --at 0,0,0 --json " + longest).code, 0);
  const Outcome outcome = kinetostat("map " + orthoglide +
                                     " --grid x=-60:60:200,y=-60:60:200,z=0 --index "
                                     "weakest-translation -o " +
                                     longest);
  EXPECT_EQ(outcome.code, 3);  // no space for '.part', which is known before 40,000 poses
  EXPECT_THAT(outcome.err, HasSubstr("Choose a shorter name"));
}

TEST(Results, KeepThePermissionsOfWhatTheyReplace) {
  put("secret.json", "{}");
  const std::filesystem::path file = working_folder() / "secret.json";
  ASSERT_EQ(chmod(file.c_str(), 0600), 0);
  EXPECT_EQ(kinetostat("stiffness " + orthoglide + " --at 0,0,0 --json secret.json").code, 0);
  struct stat status {};
  ASSERT_EQ(stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
}

}  // namespace
}  // namespace kinetostat::doors_test

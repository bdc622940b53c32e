// Diagnoses that are stopped, and asked for again.
#include <cstdlib>
#include <fstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::diagnose_resume_test {
namespace {

using test::Outcome;
using test::working_folder;
using testing::HasSubstr;
using testing::Not;

// With a cache of its own, which is empty when a test starts.
test::Outcome kinetostat(const std::string& arguments) {
  return test::kinetostat(arguments, working_folder() / "cache");
}

const std::string command = "diagnose data/measurements/nist_load_cell/campaign.yaml --json d.json";

class DiagnoseResume : public testing::Test {
 protected:
  DiagnoseResume() { std::filesystem::remove_all(cache()); }
  static std::filesystem::path cache() { return working_folder() / "cache"; }
  static std::filesystem::path result() { return working_folder() / "d.json"; }
  static std::string bytes() { return io::read_text(result()); }
  static std::vector<std::filesystem::path> entries() {
    std::vector<std::filesystem::path> list;
    for (const auto& file : std::filesystem::directory_iterator(cache() / "kinetostat"))
      list.push_back(file.path());
    return list;
  }
  // Sends a signal to a run as soon as so much is kept; it may end before.
  static void stop(const char* signal, int kept) {
    std::ofstream(working_folder() / "stop.sh")
        << "export XDG_CACHE_HOME=$PWD/cache\n"
        << fmt::format("'{}' {} > out 2> err &\n", KINETOSTAT_PROGRAM, command)
        << "run=$!\nset --\ntries=0\nwhile [ $# -lt " << kept << " ] && [ $tries -lt 9999 ]; do\n"
        << "  sleep 0.002\n  tries=$((tries + 1))\n  set -- cache/kinetostat/*.entry\ndone\n"
        << "kill -s " << signal << " $run\nwait $run\n";
    (void)std::system(
        fmt::format("cd '{}' && sh stop.sh > /dev/null 2>&1", working_folder().string()).c_str());
  }
  static std::string said(const char* stream) { return io::read_text(working_folder() / stream); }
};

TEST_F(DiagnoseResume, AskedAgainItSaysTheSameFromTheCache) {
  const Outcome first = kinetostat(command);
  ASSERT_EQ(first.code, 0) << first.err;
  const std::string expected = bytes();
  EXPECT_THAT(first.err, Not(HasSubstr("from the cache")));
  const std::size_t kept = entries().size();
  ASSERT_GT(kept, 20u);
  for (const char* threads : {" --threads 1", " --threads 2"}) {
    const Outcome again = kinetostat(command + threads);
    EXPECT_THAT(again.err,
                HasSubstr(fmt::format("{0} of {0} fits and signatures from the cache", kept)));
    EXPECT_EQ(again.out, first.out);
    EXPECT_EQ(bytes(), expected);
  }
  EXPECT_EQ(entries().size(), kept);
  std::filesystem::remove_all(cache());
  const Outcome without = kinetostat(command + " --no-cache");
  EXPECT_EQ(without.out, first.out);
  EXPECT_EQ(bytes(), expected);
  EXPECT_FALSE(std::filesystem::exists(cache()));
}

// Options that decide no fit share the fits; other readings share none.
TEST_F(DiagnoseResume, TakesWhatIsOfTheSameInput) {
  kinetostat(command);
  const std::size_t kept = entries().size();
  EXPECT_THAT(kinetostat(command + " --draws 99 --seed 7 --effects load_hardening").err,
              HasSubstr("from the cache"));
  EXPECT_EQ(entries().size(), kept);
  std::filesystem::create_directories(working_folder() / "other");
  std::string yaml =
      io::read_text(working_folder() / "data/measurements/nist_load_cell/campaign.yaml");
  const std::string robot = "robot: ../../robots/bench.yaml";
  yaml.replace(yaml.find(robot), robot.size(), "robot: ../data/robots/bench.yaml");
  io::write_atomically(working_folder() / "other/campaign.yaml", yaml);
  io::write_atomically(
      working_folder() / "other/readings.csv",
      io::read_text(working_folder() / "data/measurements/nist_load_cell/readings.csv") + "\n");
  const Outcome other = kinetostat("diagnose other/campaign.yaml");
  EXPECT_EQ(other.code, 0) << other.err;
  EXPECT_THAT(other.err, Not(HasSubstr("from the cache")));
}

TEST_F(DiagnoseResume, PlanTakesTheFitsOfDiagnose) {
  kinetostat(command + " --draws 99");
  const std::size_t kept = entries().size();
  const Outcome plan =
      kinetostat("plan data/measurements/nist_load_cell/campaign.yaml --draws 99 --minutes 5");
  EXPECT_THAT(plan.err,
              HasSubstr(fmt::format("{0} of {0} fits and signatures from the cache", kept)));
}

TEST_F(DiagnoseResume, DamagedEntriesAreComputedAnew) {
  kinetostat(command);
  const std::string expected = bytes();
  const std::vector<std::filesystem::path> kept = entries();
  for (std::size_t i = 0; i < kept.size(); i += 2) {
    std::string content = io::read_text(kept[i]);
    if (i % 4 == 0) {
      content[content.size() / 2] ^= 4;
    } else {
      content.resize(content.size() / 2);
    }
    std::ofstream(kept[i], std::ios::binary) << content;
  }
  const Outcome again = kinetostat(command);
  EXPECT_EQ(again.code, 0);
  EXPECT_THAT(again.err, HasSubstr(fmt::format("{} of {} fits and signatures from the cache",
                                               kept.size() / 2, kept.size())));
  EXPECT_EQ(bytes(), expected);
}

TEST_F(DiagnoseResume, FolderThatCannotBeWrittenIsSaidOnceAndDoesNoHarm) {
  kinetostat(command);
  const std::string expected = bytes();
  std::ofstream(working_folder() / "no_folder") << "a file";
  const std::string program = fmt::format("XDG_CACHE_HOME=$PWD/no_folder '{}'", KINETOSTAT_PROGRAM);
  const std::string line =
      fmt::format("cd '{}' && {} {} -q > out 2> err", working_folder().string(), program, command);
  EXPECT_EQ(std::system(line.c_str()), 0);
  EXPECT_EQ(bytes(), expected);
  const std::string error = said("err");
  EXPECT_THAT(error, HasSubstr("cannot be written to"));
  EXPECT_EQ(error.find("warning:"), error.rfind("warning:"));
}

// Killed outright, interrupted or terminated at any moment: what was found stays, and the next run
// says what one that was left in peace says.
TEST_F(DiagnoseResume, StoppedAtAnyMomentItGoesOn) {
  ASSERT_EQ(kinetostat(command).code, 0);
  const std::string expected = bytes();
  const int all = static_cast<int>(entries().size());
  const char* signals[] = {"KILL", "INT", "TERM"};
  int stopped = 0, said_so = 0, went_on = 0;
  for (int i = 1; i <= 12; ++i) {
    std::filesystem::remove_all(cache());
    std::filesystem::remove(result());
    stop(signals[i % 3], i * all / 13);
    if (std::filesystem::exists(result())) {
      EXPECT_EQ(bytes(), expected) << i;
    } else {
      ++stopped;
    }
    said_so += said("err").find("are in the cache: ask again") != std::string::npos ? 1 : 0;
    const Outcome next = kinetostat(command);
    EXPECT_EQ(next.code, 0) << next.err;
    EXPECT_EQ(bytes(), expected) << i;
    went_on += next.err.find("from the cache") != std::string::npos ? 1 : 0;
  }
  EXPECT_EQ(went_on, 12);
  EXPECT_GE(stopped, 2);
  EXPECT_GE(said_so, 1);
}

TEST_F(DiagnoseResume, ParallelRunsShareItInPeace) {
  kinetostat(command + " --no-cache");
  const std::string expected = bytes();
  std::string all =
      fmt::format("cd '{}' && export XDG_CACHE_HOME=$PWD/cache; ", working_folder().string());
  for (int i = 0; i < 3; ++i)
    all += fmt::format("'{}' {} -q --json p{}.json > /dev/null 2>&1 & ", KINETOSTAT_PROGRAM,
                       command.substr(0, command.find(" --json")), i);
  ASSERT_EQ(std::system((all + "wait").c_str()), 0);
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(io::read_text(working_folder() / fmt::format("p{}.json", i)), expected);
}

}  // namespace
}  // namespace kinetostat::diagnose_resume_test

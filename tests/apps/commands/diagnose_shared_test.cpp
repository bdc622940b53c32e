// One diagnosis by several processes that share a folder.
#include <cstdlib>
#include <fstream>
#include <regex>
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::diagnose_shared_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

const std::string command = "diagnose data/measurements/six_axis_balancer/campaign.yaml --draws 99";

std::string said(const std::string& file) { return io::read_text(working_folder() / file); }

void shell(const std::string& lines) {
  std::ofstream(working_folder() / "share.sh") << lines;
  EXPECT_EQ(std::system(fmt::format("cd '{}' && sh share.sh", working_folder().string()).c_str()),
            0);
}

// Starts the i-th worker.
std::string worker(int i) {
  return fmt::format(
      "'{0}' {1} --threads 1 --share shared --json {2}.json > {2}.out 2> {2}.err &\n",
      KINETOSTAT_PROGRAM, command, i);
}

struct Count {
  int found, asked;
};

Count count(const std::string& error) {
  std::smatch match;
  if (!std::regex_search(error, match, std::regex("(\\d+) of (\\d+) fits and signatures")))
    return {0, 0};
  return {std::stoi(match[1]), std::stoi(match[2])};
}

class DiagnoseShared : public testing::Test {
 protected:
  DiagnoseShared() { std::filesystem::remove_all(folder()); }
  static std::filesystem::path folder() { return working_folder() / "shared"; }
  static std::size_t files(const std::string& extension) {
    std::size_t count = 0;
    for (const auto& file : std::filesystem::directory_iterator(folder()))
      count += file.path().extension() == extension ? 1 : 0;
    return count;
  }
  // What one process says that shares with nobody.
  void expect() {
    const Outcome alone = kinetostat(command + " --no-cache --json alone.json");
    ASSERT_EQ(alone.code, 0) << alone.err;
    text_ = alone.out;
    json_ = said("alone.json");
  }
  void expect_of(int worker) const {
    EXPECT_EQ(said(fmt::format("{}.out", worker)), text_);
    EXPECT_EQ(said(fmt::format("{}.json", worker)), json_);
  }

 private:
  std::string text_, json_;
};

TEST_F(DiagnoseShared, TwoAtOnceDoHalfEachAndSayTheSameAsOne) {
  expect();
  shell(worker(1) + worker(2) + "wait\n");
  const auto kept = static_cast<int>(files(".entry"));
  ASSERT_GT(kept, 100);
  int made = 0;
  for (const int i : {1, 2}) {
    expect_of(i);
    const Count fits = count(said(fmt::format("{}.err", i)));
    EXPECT_EQ(fits.asked, kept);
    EXPECT_GT(fits.found, kept / 10) << "what the other one has made";
    EXPECT_LT(fits.found, kept - kept / 10) << "it made some itself";
    made += fits.asked - fits.found;
  }
  EXPECT_EQ(made, kept) << "nothing was made twice";
  EXPECT_EQ(files(".claim"), 0u);
}

// Stopped where it holds a claim, so that the other one must wait until that has expired.
TEST_F(DiagnoseShared, OneThatIsKilledCostsTimeOnly) {
  expect();
  shell(worker(1) +
        "first=$!\nclaims=0\nwhile [ $claims = 0 ] && kill -s CONT $first; do\n"
        "  sleep 0.05\n  kill -s STOP $first\n  set -- shared/*.entry\n"
        "  [ $# -lt 40 ] || claims=$(ls shared | grep -c claim)\ndone\n"
        "echo $# $claims > stopped\n" +
        worker(2) + "second=$!\nsleep 1\nkill -s KILL $first\nwait $second\n");
  std::istringstream stopped(said("stopped"));
  int kept = 0, claims = 0;
  stopped >> kept >> claims;
  EXPECT_GE(claims, 1);
  expect_of(2);
  const Count fits = count(said("2.err"));
  EXPECT_EQ(fits.found, kept);
  EXPECT_GT(fits.asked, kept);
  EXPECT_EQ(files(".claim"), 0u);
  EXPECT_TRUE(said("1.out").empty());
}

TEST_F(DiagnoseShared, PlanAndStudyFindWhatItHasKept) {
  const std::string campaign = "data/measurements/nist_load_cell/campaign.yaml --share shared";
  ASSERT_EQ(kinetostat("diagnose " + campaign).code, 0);
  const std::string all =
      fmt::format("{0} of {0} fits and signatures from the cache", files(".entry"));
  EXPECT_THAT(kinetostat("plan " + campaign + " --minutes 5").err, HasSubstr(all));
  EXPECT_THAT(kinetostat("study " + campaign + " -o studied").err, HasSubstr(all));
}

TEST_F(DiagnoseShared, FolderThatCannotBeWrittenIsAMistake) {
  std::ofstream(working_folder() / "file") << "no folder";
  const Outcome outcome = kinetostat(command + " --share file");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("file: cannot be written to"));
  EXPECT_EQ(kinetostat(command + " --share shared --no-cache").code, 2);
}

}  // namespace
}  // namespace kinetostat::diagnose_shared_test

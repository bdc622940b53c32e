// Results kept from run to run, and runs that are killed.
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <random>
#include <sys/wait.h>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::identify_cache_test {
namespace {

using test::working_folder;
using testing::HasSubstr;
using testing::Not;

// With a cache of its own, which is empty when a test starts.
test::Outcome kinetostat(const std::string& arguments) {
  return test::kinetostat(arguments, working_folder() / "cache");
}

// A copy of the test bar's link file with coarser elements, and a cache of its own.
class IdentifyCache : public testing::Test {
 protected:
  IdentifyCache() {
    std::filesystem::remove_all(cache());
    std::filesystem::copy_file(working_folder() / "meshes/test_bar.stl",
                               working_folder() / "bar.stl",
                               std::filesystem::copy_options::overwrite_existing);
    write_link("");
  }
  static std::filesystem::path cache() { return working_folder() / "cache"; }
  static void write_link(const std::string& comment, const std::string& size = "size: 8") {
    std::string text = io::read_text(working_folder() / "meshes/test_bar.yaml");
    text.replace(text.find("size: 3"), 7, size);
    text.replace(text.find("test_bar.stl"), 12, "bar.stl");
    std::ofstream(working_folder() / "bar.yaml") << text << comment;
  }
  static test::Outcome identify(const std::string& more = "") {
    return kinetostat("identify bar.yaml -q -o bar.json " + more);
  }
  static std::string result() { return io::read_text(working_folder() / "bar.json"); }
  // Without what may differ between runs on the same input.
  static std::string figures(const std::string& file) {
    io::Json json = io::read_json(working_folder() / file);
    json.erase("timings");
    return io::to_text(json);
  }
  static std::size_t entries() {
    std::size_t count = 0;
    for (const auto& file : std::filesystem::directory_iterator(cache() / "kinetostat"))
      count += file.path().extension() == ".entry" ? 1 : 0;
    return count;
  }
};

TEST_F(IdentifyCache, GivesTheSameBytesAsComputing) {
  const test::Outcome computed = identify("--json first.json");
  ASSERT_EQ(computed.code, 0) << computed.err;
  const std::string first = result();
  EXPECT_THAT(computed.out, Not(HasSubstr("from the cache")));
  const test::Outcome cached = identify("--json second.json");
  EXPECT_EQ(cached.out, computed.out + "from the cache: computed before from the same input\n");
  EXPECT_EQ(result(), first);
  EXPECT_EQ(io::read_text(working_folder() / "first.json"),
            io::read_text(working_folder() / "second.json"));
  identify("--no-cache");
  EXPECT_NE(result(), first);  // the timings at least
  io::write_atomically(working_folder() / "cached.json", first);
  EXPECT_EQ(figures("bar.json"), figures("cached.json"));
}

TEST_F(IdentifyCache, KnowsAnInputByItsMeaning) {
  identify();
  write_link("\n# a comment\n");
  EXPECT_THAT(identify().out, HasSubstr("from the cache"));
  // The result names the link file of this run, not of the one that computed it.
  EXPECT_THAT(result(), HasSubstr(io::sha256(io::read_text(working_folder() / "bar.yaml"))));
  write_link("", "size: 9");
  EXPECT_THAT(identify().out, Not(HasSubstr("from the cache")));
  write_link("");
  std::fstream mesh(working_folder() / "bar.stl", std::ios::in | std::ios::out | std::ios::binary);
  mesh.write("changed", 7);  // in the title of the file: the shape stays
  mesh.close();
  const test::Outcome other_bytes = identify();
  EXPECT_THAT(other_bytes.out, HasSubstr("volume mesh from the cache"));
  EXPECT_THAT(other_bytes.out, Not(HasSubstr("computed before")));
}

TEST_F(IdentifyCache, KeepsNothingWhenAskedNotTo) {
  identify("--no-cache");
  EXPECT_FALSE(std::filesystem::exists(cache()));
}

TEST_F(IdentifyCache, ExportsComeFromTheModelWithTheCachedMesh) {
  identify();
  const test::Outcome outcome = identify("--vtu bar.vtu");
  EXPECT_THAT(outcome.out, HasSubstr("volume mesh from the cache"));
  EXPECT_TRUE(std::filesystem::exists(working_folder() / "bar.vtu"));
}

TEST_F(IdentifyCache, DamagedEntriesAreComputedAnew) {
  identify();
  const std::string before = figures("bar.json");
  ASSERT_EQ(entries(), 2u);
  for (const auto& file : std::filesystem::directory_iterator(cache() / "kinetostat")) {
    std::string bytes = io::read_text(file.path());
    bytes[bytes.size() / 2] ^= 4;
    std::ofstream(file.path(), std::ios::binary) << bytes;
  }
  const test::Outcome outcome = identify();
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.out, Not(HasSubstr("from the cache")));
  EXPECT_EQ(figures("bar.json"), before);
}

// A run that is killed at any moment leaves a whole result or none, and the next one gives the
// same matrix. Half of the runs are killed outright, half are asked to stop.
TEST_F(IdentifyCache, KillingAtTwentyRandomTimesDoesNoHarm) {
  write_link("", "size: 16");
  const auto start = std::chrono::steady_clock::now();
  ASSERT_EQ(identify().code, 0);
  const std::chrono::duration<double> duration = std::chrono::steady_clock::now() - start;
  const std::string expected = figures("bar.json");
  std::mt19937 random(20);
  int stopped = 0;
  for (int run = 0; run < 20; ++run) {
    std::filesystem::remove_all(cache());
    std::filesystem::remove(working_folder() / "bar.json");
    const double delay = std::uniform_real_distribution<double>(0, 1.1 * duration.count())(random);
    const int status = std::system(
        fmt::format("cd '{}' && XDG_CACHE_HOME=$PWD/cache timeout -s {} {:.4f} '{}' identify "
                    "bar.yaml -q -o bar.json > /dev/null 2>&1",
                    working_folder().string(), run % 2 == 0 ? "KILL" : "INT", delay,
                    KINETOSTAT_PROGRAM)
            .c_str());
    stopped += status == 0 ? 0 : 1;
    if (std::filesystem::exists(working_folder() / "bar.json")) {
      EXPECT_EQ(figures("bar.json"), expected) << run;
    }
    const test::Outcome next = identify();
    EXPECT_EQ(next.code, 0) << next.err;
    EXPECT_EQ(figures("bar.json"), expected) << run << ", stopped after " << delay << " s";
  }
  EXPECT_GE(stopped, 5);
}

TEST_F(IdentifyCache, ParallelRunsShareItInPeace) {
  ASSERT_EQ(identify("--no-cache").code, 0);
  const std::string expected = figures("bar.json");
  std::string command =
      fmt::format("cd '{}' && export XDG_CACHE_HOME=$PWD/cache; ", working_folder().string());
  for (int i = 0; i < 4; ++i)
    command += fmt::format("'{}' identify bar.yaml -q -o p{}.json > /dev/null 2>&1 & ",
                           KINETOSTAT_PROGRAM, i);
  ASSERT_EQ(std::system((command + "wait").c_str()), 0);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(figures(fmt::format("p{}.json", i)), expected);
}

}  // namespace
}  // namespace kinetostat::identify_cache_test

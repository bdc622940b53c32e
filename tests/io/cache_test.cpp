#include "kinetostat/io/cache.h"

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "kinetostat/io/text_file.h"

#include "support/temporary_folder.h"

namespace kinetostat::io::cache_test {
namespace {

class CacheTest : public testing::Test {
 protected:
  std::vector<std::filesystem::path> entries() const {
    std::vector<std::filesystem::path> list;
    for (const auto& file : std::filesystem::directory_iterator(folder_.path()))
      list.push_back(file.path());
    return list;
  }
  void overwrite(const std::filesystem::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
  }

  test::TemporaryFolder folder_;
  Cache cache_{folder_.path()};
};

TEST_F(CacheTest, FindsTheSameBytesUnderTheSameKeyOnly) {
  const std::string bytes("a\0b\n\xff", 5);
  EXPECT_FALSE(cache_.find("key"));
  EXPECT_TRUE(cache_.keep("key", bytes));
  EXPECT_EQ(cache_.find("key"), bytes);
  EXPECT_FALSE(cache_.find("other key"));
  EXPECT_TRUE(cache_.keep("key", "newer"));
  EXPECT_EQ(cache_.find("key"), "newer");
}

TEST_F(CacheTest, DamagedEntriesAreIgnoredAndRemoved) {
  const std::string content(1000, 'x');
  cache_.keep("key", content);
  const std::filesystem::path file = entries().front();
  const std::string whole = read_text(file);
  std::string flipped = whole;
  flipped[500] ^= 1;
  for (const std::string& damaged : {flipped, whole.substr(0, 600), whole.substr(0, 10),
                                     std::string(), whole + "y", std::string(2000, 'z')}) {
    overwrite(file, damaged);
    EXPECT_FALSE(cache_.find("key")) << damaged.size();
    EXPECT_FALSE(std::filesystem::exists(file));
  }
}

TEST_F(CacheTest, EntriesOfAnotherKeyAreNoticed) {
  cache_.keep("one", "first");
  const std::filesystem::path one = entries().front();
  cache_.keep("two", "second");
  const std::filesystem::path two = entries()[0] == one ? entries()[1] : entries()[0];
  std::filesystem::rename(one, folder_.path() / "aside");
  std::filesystem::rename(two, one);
  std::filesystem::rename(folder_.path() / "aside", two);
  EXPECT_FALSE(cache_.find("one"));
  EXPECT_FALSE(cache_.find("two"));
}

TEST_F(CacheTest, KeepsWhatWasUsedLastWithinItsLimit) {
  const Cache small(folder_.path(), 5000);
  const std::string content(1000, 'x');
  for (int i = 0; i < 4; ++i) small.keep(std::to_string(i), content);
  // Times of files may be coarse: make entry 0 the oldest but one used now.
  const auto old = std::filesystem::file_time_type::clock::now() - std::chrono::hours(2);
  for (const auto& file : entries()) std::filesystem::last_write_time(file, old);
  EXPECT_TRUE(small.find("0"));
  small.keep("4", content);
  EXPECT_TRUE(small.find("0"));
  EXPECT_TRUE(small.find("4"));
  std::uintmax_t total = 0;
  for (const auto& file : entries()) total += std::filesystem::file_size(file);
  EXPECT_LE(total, 5000u);
  EXPECT_FALSE(small.keep("huge", std::string(2000, 'x')));
}

TEST_F(CacheTest, LeftoversOfKilledProcessesGo) {
  overwrite(folder_.path() / ".1234.tmp", "half");
  std::filesystem::last_write_time(
      folder_.path() / ".1234.tmp",
      std::filesystem::file_time_type::clock::now() - std::chrono::hours(2));
  const Cache small(folder_.path(), 5000);  // so that it is looked through at once
  small.keep("key", std::string(1000, 'x'));
  EXPECT_EQ(entries().size(), 1u);
}

TEST_F(CacheTest, FolderThatCannotBeWrittenIsNoError) {
  overwrite(folder_.path() / "file", "");
  const Cache nowhere(folder_.path() / "file" / "cache");
  EXPECT_FALSE(nowhere.keep("key", "value"));
  EXPECT_FALSE(nowhere.find("key"));
  EXPECT_FALSE(Cache().keep("key", "value"));
  EXPECT_FALSE(Cache().find("key"));
}

TEST_F(CacheTest, ManyAtOnceSeeWholeEntriesOnly) {
  std::vector<std::thread> threads;
  std::atomic<int> wrong = 0;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      const Cache small(folder_.path(), 40'000);
      for (int i = 0; i < 100; ++i) {
        const std::string key = std::to_string((7 * i + t) % 10);
        if (const auto found = small.find(key); found && *found != std::string(5000, key[0]))
          ++wrong;
        if (t % 2 == 0) small.keep(key, std::string(5000, key[0]));
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace kinetostat::io::cache_test

#include "kinetostat/io/claims.h"

#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <ctime>
#include <fcntl.h>
#include <optional>
#include <sys/stat.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "kinetostat/common/error.h"

#include "support/temporary_folder.h"

namespace kinetostat::io::claims_test {
namespace {

using namespace std::chrono_literals;

class ClaimsTest : public testing::Test {
 protected:
  std::vector<std::filesystem::path> files() const {
    std::vector<std::filesystem::path> list;
    for (const auto& file : std::filesystem::directory_iterator(folder_.path()))
      list.push_back(file.path());
    return list;
  }

  test::TemporaryFolder folder_;
};

TEST_F(ClaimsTest, OneHoldsItUntilItGivesItUp) {
  Claims one(folder_.path()), other(folder_.path());
  EXPECT_TRUE(one.claim("item"));
  EXPECT_FALSE(other.claim("item"));
  EXPECT_FALSE(one.claim("item")) << "another thread of the same process";
  EXPECT_TRUE(other.claim("other item"));
  other.give_up("item");  // it is not its own
  EXPECT_FALSE(other.claim("item"));
  one.give_up("item");
  EXPECT_TRUE(other.claim("item"));
  EXPECT_FALSE(one.claim("item"));
}

TEST_F(ClaimsTest, NothingIsLeftInTheFolder) {
  {
    Claims claims(folder_.path() / "new" / "folder");
    EXPECT_TRUE(claims.claim("item"));
    EXPECT_FALSE(std::filesystem::is_empty(folder_.path() / "new" / "folder"));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path() / "new" / "folder"));
}

TEST_F(ClaimsTest, RenewedForAsLongAsItsOwnerLives) {
  Claims one(folder_.path(), 2s), other(folder_.path(), 2s);
  ASSERT_TRUE(one.claim("item"));
  for (int i = 0; i < 6; ++i) {
    std::this_thread::sleep_for(500ms);
    EXPECT_FALSE(other.claim("item")) << i;
  }
}

// What a claim of a killed process looks like: nobody touches its file.
TEST_F(ClaimsTest, OfAKilledProcessItExpires) {
  constexpr auto expiry = 2s;
  const pid_t child = fork();
  if (child == 0) {
    Claims claims(folder_.path(), expiry);
    _exit(claims.claim("item") && ::raise(SIGKILL) == 0 ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  ASSERT_EQ(files().size(), 1u);
  Claims other(folder_.path(), expiry);
  EXPECT_FALSE(other.claim("item"));
  std::this_thread::sleep_for(expiry + 100ms);
  EXPECT_TRUE(other.claim("item"));
  other.give_up("item");
  EXPECT_TRUE(files().empty());
}

// A machine whose clock is wrong: both times that are compared are those of the file system.
TEST_F(ClaimsTest, AgesAreThoseOfTheFileSystem) {
  Claims one(folder_.path(), 60s), other(folder_.path(), 60s);
  ASSERT_TRUE(one.claim("item"));
  const auto made_before = [&](std::chrono::seconds age) {
    const std::array<timespec, 2> times = {timespec{::time(nullptr) - age.count(), 0},
                                           timespec{::time(nullptr) - age.count(), 0}};
    return ::utimensat(AT_FDCWD, files().front().c_str(), times.data(), 0) == 0;
  };
  ASSERT_TRUE(made_before(50s));
  EXPECT_FALSE(other.claim("item"));
  ASSERT_TRUE(made_before(-3600s));
  EXPECT_FALSE(other.claim("item"));
  ASSERT_TRUE(made_before(62s));
  EXPECT_TRUE(other.claim("item"));
  one.give_up("item");  // it was stopped for a minute, and goes on
  EXPECT_EQ(files().size(), 1u);
  EXPECT_FALSE(one.claim("item"));
}

TEST_F(ClaimsTest, OneOfManyGetsIt) {
  std::vector<std::thread> threads;
  std::atomic<int> owners = 0;
  std::vector<std::optional<Claims>> workers(8);
  for (auto& worker : workers) {
    worker.emplace(folder_.path());
    threads.emplace_back([&] { owners += worker->claim("item") ? 1 : 0; });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(owners, 1);
}

TEST_F(ClaimsTest, FolderThatCannotBeWrittenIsNamed) {
  const std::filesystem::path no_folder = folder_.file("file", "");
  try {
    const Claims claims(no_folder);
    ADD_FAILURE() << "it must throw";
  } catch (const common::InputError& error) {
    EXPECT_EQ(error.details().file, no_folder);
    EXPECT_NE(std::string(error.what()).find("cannot be written to"), std::string::npos);
  }
}

TEST_F(ClaimsTest, FolderThatIsGoneKeepsNobodyFromWork) {
  Claims one(folder_.path() / "gone");
  std::filesystem::remove_all(folder_.path() / "gone");
  EXPECT_TRUE(one.claim("item"));
  one.give_up("item");
  EXPECT_TRUE(one.claim("item"));
}

}  // namespace
}  // namespace kinetostat::io::claims_test

#include "kinetostat/io/text_file.h"

#include <chrono>
#include <csignal>
#include <fstream>
#include <sys/resource.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/progress.h"

#include "support/temporary_folder.h"

namespace kinetostat::io::text_file_test {
namespace {

class TextFile : public testing::Test {
 protected:
  std::size_t number_of_files() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder_), {}));
  }

  test::TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

TEST_F(TextFile, WritesAnyBytesAndReadsThemBack) {
  std::string bytes("a\0b\r\n\xff", 6);
  write_atomically(folder_ / "a", bytes);
  EXPECT_EQ(read_text(folder_ / "a"), bytes);
  write_atomically(folder_ / "a", "");
  EXPECT_EQ(read_text(folder_ / "a"), "");
  EXPECT_EQ(number_of_files(), 1u);
}

TEST_F(TextFile, MakesMissingFolders) {
  write_atomically(folder_ / "x" / "y" / "a", "deep");
  EXPECT_EQ(read_text(folder_ / "x" / "y" / "a"), "deep");
}

// A process that may write 4 kB only is as good as a full disk.
void write_beyond_the_limit(const std::filesystem::path& file) {
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{4096, 4096};
  setrlimit(RLIMIT_FSIZE, &limit);
  try {
    write_atomically(file, std::string(100000, 'x'));
  } catch (const common::InputError&) {
    std::exit(3);
  }
  std::exit(0);
}

TEST_F(TextFile, FullDiskLeavesTheOldContentAndNothingElse) {
  const std::filesystem::path file = folder_ / "a";
  write_atomically(file, "old");
  EXPECT_EXIT(write_beyond_the_limit(file), testing::ExitedWithCode(3), "");
  EXPECT_EQ(read_text(file), "old");
  EXPECT_EQ(number_of_files(), 1u);
}

TEST_F(TextFile, FoldersThatCannotBeWrittenToAreNamed) {
  std::ofstream(folder_ / "file") << "x";
  EXPECT_THROW(write_atomically(folder_ / "file" / "a", "x"), common::InputError);
  EXPECT_THROW(write_atomically("/proc/nothing/a", "x"), common::InputError);
  EXPECT_THROW(write_atomically(folder_, "x"), common::InputError);
}

// Renaming a file over a device would replace the device.
TEST_F(TextFile, DevicesAndPipesAreWrittenToNotReplaced) {
  const std::filesystem::path link = folder_ / "null";
  std::filesystem::create_symlink("/dev/null", link);
  write_atomically(link, "gone");
  EXPECT_TRUE(std::filesystem::is_character_file(link));
  EXPECT_EQ(number_of_files(), 1u);
}

TEST_F(TextFile, LinksAreFollowed) {
  write_atomically(folder_ / "real", "old");
  std::filesystem::create_symlink("real", folder_ / "link");
  write_atomically(folder_ / "link", "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "link"));
  EXPECT_EQ(read_text(folder_ / "real"), "new");
}

TEST_F(TextFile, ReadingWhatIsNotAFileIsAnInputError) {
  EXPECT_THROW(read_text(folder_), common::InputError);
  EXPECT_THROW(read_text(folder_ / "missing"), common::InputError);
}

TEST_F(TextFile, OutputsAreNotReadAsLongAsTheyAreOutputs) {
  write_atomically(folder_ / "in", "kept");
  std::filesystem::create_symlink("in", folder_ / "link");
  {
    const Outputs outputs({folder_ / "link", folder_ / "not there yet"});
    EXPECT_THROW(read_text(folder_ / "in"), common::InputError);
    write_atomically(folder_ / "not there yet", "result");
  }
  EXPECT_EQ(read_text(folder_ / "in"), "kept");
  EXPECT_EQ(read_text(folder_ / "not there yet"), "result");
}

TEST_F(TextFile, OutputsThatCannotBeWrittenAreRefusedBeforehand) {
  write_atomically(folder_ / "file", "kept");
  std::filesystem::create_directory(folder_ / "sub");
  EXPECT_THROW(Outputs({folder_ / "sub"}), common::InputError);
  EXPECT_THROW(Outputs({folder_ / "file" / "result"}), common::InputError);
  EXPECT_THROW(Outputs({folder_ / "file" / "new" / "result"}), common::InputError);
  EXPECT_NO_THROW(Outputs({folder_ / "sub" / "new" / "result", "/dev/null"}));
  if (::geteuid() != 0) {  // who may write everywhere
    std::filesystem::permissions(folder_ / "sub", std::filesystem::perms::owner_read);
    EXPECT_THROW(Outputs({folder_ / "sub" / "result"}), common::InputError);
    std::filesystem::permissions(folder_ / "sub", std::filesystem::perms::owner_all);
  }
}

mode_t mode_of(const std::filesystem::path& file) {
  struct stat status {};
  EXPECT_EQ(::stat(file.c_str(), &status), 0);
  return status.st_mode & 0777;
}

TEST_F(TextFile, WhatIsReplacedPassesOnItsPermissions) {
  const std::filesystem::path file = folder_ / "a";
  write_atomically(file, "new");
  const mode_t usual = mode_of(file);
  for (const mode_t mode : {0600, 0640, 0755, 0400}) {
    ASSERT_EQ(::chmod(file.c_str(), mode), 0);
    write_atomically(file, "newer");
    EXPECT_EQ(mode_of(file), mode);
  }
  write_atomically(folder_ / "b", "other");
  EXPECT_EQ(mode_of(folder_ / "b"), usual);
}

// Whoever may write to the folder could otherwise have any file of the user overwritten.
TEST_F(TextFile, TemporaryFilesFollowNoLinks) {
  write_atomically(folder_ / "victim", "kept");
  std::filesystem::create_directory(folder_ / "shared");
  const std::string process = std::to_string(::getpid());
  std::filesystem::create_symlink(folder_ / "victim",
                                  folder_ / "shared" / (".a." + process + ".tmp"));
  for (int i = 0; i < 1000; ++i)
    std::filesystem::create_symlink(
        folder_ / "victim",
        folder_ / "shared" / (".kinetostat-" + process + "-" + std::to_string(i) + ".tmp"));
  write_atomically(folder_ / "shared" / "a", "written");
  EXPECT_EQ(read_text(folder_ / "victim"), "kept");
  EXPECT_EQ(read_text(folder_ / "shared" / "a"), "written");
  EXPECT_FALSE(std::filesystem::is_symlink(folder_ / "shared" / "a"));
}

TEST_F(TextFile, TheLongestNamesAreWrittenAndLongerOnesRefusedBeforehand) {
  const std::string longest(255, 'x');
  EXPECT_NO_THROW(Outputs({folder_ / longest}));
  write_atomically(folder_ / longest, "a");
  EXPECT_EQ(read_text(folder_ / longest), "a");
  EXPECT_THROW(Outputs({folder_ / (longest + "x")}), common::InputError);
  EXPECT_THROW(Outputs({folder_ / "new" / (longest + "x") / "a"}), common::InputError);
}

TEST_F(TextFile, NamesThatOthersChoseAreNotFollowed) {
  write_atomically(folder_ / "victim", "kept");
  std::filesystem::create_symlink("victim", folder_ / "link");
  std::filesystem::create_symlink("nowhere", folder_ / "dangling");
  for (const char* taken : {"victim", "link", "dangling"})
    EXPECT_FALSE(write_in_place_of(Replace::nothing, folder_ / taken, "new")) << taken;
  EXPECT_TRUE(write_in_place_of(Replace::nothing, folder_ / "fresh", "new"));
  EXPECT_EQ(read_text(folder_ / "fresh"), "new");
  EXPECT_TRUE(write_in_place_of(Replace::entry, folder_ / "link", "new"));
  EXPECT_FALSE(std::filesystem::is_symlink(folder_ / "link"));
  EXPECT_EQ(read_text(folder_ / "victim"), "kept");
  EXPECT_EQ(number_of_files(), 4u);
}

TEST_F(TextFile, PipesAreReadToTheirEndAndDevicesToALimit) {
  const std::filesystem::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&pipe] {
    std::ofstream stream(pipe);
    for (int i = 0; i < 1000; ++i) stream << std::string(1000, 'x');
  });
  EXPECT_EQ(read_text(pipe), std::string(1000000, 'x'));
  writer.join();
  EXPECT_EQ(read_text("/dev/null"), "");
  EXPECT_THROW(read_text("/dev/zero"), common::InputError);
  EXPECT_EQ(read_start("/dev/zero", 10), std::string(10, '\0'));
}

TEST_F(TextFile, FilesWithoutEndAreRefusedBeforeTheyAreRead) {
  std::ofstream(folder_ / "sparse").put('x');
  std::filesystem::resize_file(folder_ / "sparse", std::uintmax_t{1} << 42);
  EXPECT_THROW(read_text(folder_ / "sparse"), common::InputError);
  EXPECT_EQ(read_start(folder_ / "sparse", 2), std::string("x\0", 2));
}

// As the program sets its handlers, which restart whatever else waits.
TEST_F(TextFile, ASignalEndsTheWaitForAPipe) {
  const std::filesystem::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  struct sigaction action {};
  action.sa_handler = [](int) {};
  action.sa_flags = SA_RESTART;
  sigaction(SIGUSR1, &action, nullptr);
  const pthread_t reader = pthread_self();
  std::jthread sender([reader](const std::stop_token& over) {
    while (!over.stop_requested()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      pthread_kill(reader, SIGUSR1);
    }
  });
  EXPECT_THROW(read_text(pipe), common::Cancelled);
}

// FIPS 180-2, appendix B.
TEST(Sha256, PublishedVectors) {
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

}  // namespace
}  // namespace kinetostat::io::text_file_test

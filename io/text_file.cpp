#include "kinetostat/io/text_file.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <optional>
#include <poll.h>
#include <sha256.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/progress.h"

namespace kinetostat::io {
namespace {

using std::filesystem::path;

[[noreturn]] void fail_to_write(const path& file, int error) {
  throw common::InputError(
      file, fmt::format("cannot be written ({})", std::strerror(error)),
      error == ENAMETOOLONG ? "Choose a shorter name" : "Choose a folder that you may write to");
}

[[noreturn]] void fail_to_read(const path& file, int error) {
  throw common::InputError(file, fmt::format("cannot be read ({})", std::strerror(error)),
                           "Check the path and that you may read it");
}

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  operator int() const { return number_; }

 private:
  int number_;
};

// Nobody knows whether anything will ever come out of a pipe: a signal ends the wait. Without
// handlers no signal is noticed here.
void wait_for_input(int descriptor, const path& file) {
  pollfd one{descriptor, POLLIN, 0};
  if (::poll(&one, 1, -1) >= 0) return;
  if (errno == EINTR) throw common::Cancelled();
  fail_to_read(file, errno);
}

// At most `most` bytes. The system's own count of bytes may be wrong: files in /proc have none.
std::string read_bytes(int descriptor, const path& file, std::size_t expected, std::size_t most,
                       bool waits) {
  constexpr std::size_t block = std::size_t{1} << 16;
  std::string bytes;
  std::size_t filled = 0;
  while (filled < most) {
    if (bytes.size() - filled < block)
      bytes.resize(std::min(most, std::max({expected + 1, 2 * filled, filled + block})));
    if (waits) wait_for_input(descriptor, file);
    const ssize_t got = ::read(descriptor, bytes.data() + filled, bytes.size() - filled);
    if (got == 0) break;
    if (got < 0 && errno != EINTR && errno != EAGAIN) fail_to_read(file, errno);
    if (got > 0) filled += static_cast<std::size_t>(got);
  }
  bytes.resize(filled);
  return bytes;
}

void write_all(int descriptor, const std::string& content, Flush flush, const path& file) {
  std::size_t done = 0;
  while (done < content.size()) {
    const ssize_t written = ::write(descriptor, content.data() + done, content.size() - done);
    if (written < 0 && errno != EINTR) fail_to_write(file, errno);
    if (written > 0) done += static_cast<std::size_t>(written);
  }
  if (flush == Flush::yes && ::fsync(descriptor) != 0 && errno != EINVAL)
    fail_to_write(file, errno);
}

// A device or a pipe has no content to protect, and must not be replaced by a file.
void write_into(const path& file, const std::string& content, Flush flush) {
  const Descriptor descriptor(::open(file.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY));
  if (descriptor < 0) fail_to_write(file, errno);
  write_all(descriptor, content, flush, file);
}

// Global, because it must hold for whatever reads a file, of which a robot file names others: a
// list that is handed down is one that a reader can lack. Set before anything is read, and only
// read by the threads that read.
std::vector<path>& outputs() {
  static std::vector<path> all;
  return all;
}

// Global as well, for the same reason.
std::vector<ReadAs::Content>& stand_ins() {
  static std::vector<ReadAs::Content> all;
  return all;
}

const std::string* stand_in_for(const path& file) {
  std::error_code error;
  for (const auto& [known, text] : stand_ins())
    if (std::filesystem::equivalent(file, known, error)) return &text;
  return nullptr;
}

void require_no_output(const path& file) {
  std::error_code error;
  for (const path& output : outputs())
    if (std::filesystem::equivalent(file, output, error) &&
        std::filesystem::is_regular_file(file, error))
      throw common::InputError(file, "is read, and the result would replace it",
                               "Name another file for the result");
}

// Of every part of a path that is not there yet: whatever is there has a name that was taken.
void require_names_that_fit(const path& folder, const path& file) {
  const long longest = ::pathconf(folder.c_str(), _PC_NAME_MAX);
  for (const path& part : file)
    if (longest > 0 && part.native().size() > static_cast<std::size_t>(longest))
      fail_to_write(file, ENAMETOOLONG);
}

// A file of a name of its own beside the target, which becomes the target or goes again. Its name
// is short, so that it fits beside every name that the target may have; it is made anew, so that
// nobody can put a link there beforehand.
class TemporaryFile {
 public:
  TemporaryFile(const path& folder, mode_t mode, const path& file) : file_(file) {
    static std::atomic<unsigned> count = 0;
    constexpr int flags = O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC;
    do {
      name_ = folder / fmt::format(".kinetostat-{}-{}.tmp", ::getpid(), count++);
      descriptor_ = ::open(name_.c_str(), flags, mode);
    } while (descriptor_ < 0 && errno == EEXIST);  // left by a killed process of the same number
    if (descriptor_ < 0) fail_to_write(file, errno);
  }
  ~TemporaryFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!name_.empty()) ::unlink(name_.c_str());
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  int descriptor() const { return descriptor_; }
  // False when something is there and must stay.
  bool become(const path& target, bool may_replace) {
    ::close(descriptor_);
    descriptor_ = -1;
    const unsigned flags = may_replace ? 0 : RENAME_NOREPLACE;
    if (::renameat2(AT_FDCWD, name_.c_str(), AT_FDCWD, target.c_str(), flags) == 0) {
      name_.clear();
      return true;
    }
    // Network file systems know no such flag; a second name of the same file does as well.
    if (!may_replace && errno == EINVAL && ::link(name_.c_str(), target.c_str()) == 0) return true;
    if (!may_replace && errno == EEXIST) return false;
    fail_to_write(file_, errno);
  }

 private:
  const path& file_;
  path name_;
  int descriptor_ = -1;
};

// Nobody may read the new content who may not read the old.
void take_permissions(int descriptor, const struct stat& replaced) {
  mode_t mode = replaced.st_mode & (S_IRWXU | S_IRWXG | S_IRWXO);
  if (::fchown(descriptor, replaced.st_uid, replaced.st_gid) != 0 &&
      ::fchown(descriptor, static_cast<uid_t>(-1), replaced.st_gid) != 0)
    mode &= ~static_cast<mode_t>(S_IRWXG);
  ::fchmod(descriptor, mode);
}

std::optional<struct stat> regular_file_at(const path& file) {
  struct stat found {};
  if (::lstat(file.c_str(), &found) != 0 || !S_ISREG(found.st_mode)) return std::nullopt;
  return found;
}

// Through a temporary file; no link is followed.
bool write_beside(const path& target, bool may_replace, const std::string& content, Flush flush,
                  const path& file) {
  const path folder = target.has_parent_path() ? target.parent_path() : ".";
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) fail_to_write(file, error.value());
  const std::optional<struct stat> replaced = regular_file_at(target);
  TemporaryFile temporary(folder, replaced ? 0600 : 0666, file);
  if (replaced) take_permissions(temporary.descriptor(), *replaced);
  write_all(temporary.descriptor(), content, flush, file);
  return temporary.become(target, may_replace);
}

}  // namespace

// Of what is there already, of the nearest folder above it where nothing is.
void require_writable(const path& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) fail_to_write(file, EISDIR);
  if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error))
    return;  // a device or a pipe
  path folder =
      std::filesystem::weakly_canonical(std::filesystem::absolute(file), error).parent_path();
  if (error) fail_to_write(file, error.value());
  while (!std::filesystem::exists(folder, error) && folder.has_relative_path())
    folder = folder.parent_path();
  if (!std::filesystem::is_directory(folder, error)) fail_to_write(file, ENOTDIR);
  if (::access(folder.c_str(), W_OK | X_OK) != 0) fail_to_write(file, errno);
  require_names_that_fit(folder, file);
}

Outputs::Outputs(std::vector<path> files) {
  for (const path& file : files) require_writable(file);
  outputs() = std::move(files);
}

Outputs::~Outputs() { outputs().clear(); }

ReadAs::ReadAs(std::vector<Content> files) { stand_ins() = std::move(files); }

ReadAs::~ReadAs() { stand_ins().clear(); }

std::string read_start(const path& file, std::size_t most) {
  std::error_code error;  // whatever it is, reading says so
  if (std::filesystem::is_directory(file, error))
    throw common::InputError(file, "is a folder, not a file", "Name a file in it");
  require_no_output(file);
  if (const std::string* text = stand_in_for(file)) return text->substr(0, most);
  // Without waiting for the other side of a pipe, which a signal could not end.
  const Descriptor descriptor(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK));
  struct stat status {};
  if (descriptor < 0 || ::fstat(descriptor, &status) != 0) fail_to_read(file, errno);
  if (S_ISREG(status.st_mode))
    return read_bytes(descriptor, file, static_cast<std::size_t>(status.st_size), most, false);
  std::string bytes = read_bytes(descriptor, file, 0, std::min(most, largest_stream + 1), true);
  if (bytes.size() > largest_stream)
    throw common::InputError(file, fmt::format("gives more than {} MiB", largest_stream >> 20),
                             "Save it to a file and name that");
  return bytes;
}

std::string read_text(const path& file) {
  const auto refuse = [&file] {
    throw common::InputError(file, fmt::format("is larger than {} GiB", largest_file >> 30),
                             "No file of kinetostat is so large: check which one you mean");
  };
  struct stat status {};
  if (::stat(file.c_str(), &status) == 0 && S_ISREG(status.st_mode) &&
      static_cast<std::size_t>(status.st_size) > largest_file)
    refuse();  // before memory is taken for it
  std::string bytes = read_start(file, largest_file + 1);
  if (bytes.size() > largest_file) refuse();
  return bytes;
}

void write_atomically(const path& file, const std::string& content, Flush flush) {
  std::error_code error;
  if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error))
    return write_into(file, content, flush);
  // Renaming over a symbolic link would replace the link, so its target is written.
  const bool is_link = std::filesystem::is_symlink(file, error);
  const path target = is_link ? std::filesystem::weakly_canonical(file, error) : file;
  write_beside(target, true, content, flush, file);
}

bool write_in_place_of(Replace replace, const path& file, const std::string& content) {
  std::error_code error;
  const std::filesystem::file_status there = std::filesystem::symlink_status(file, error);
  const bool may_replace = replace == Replace::entry;
  if (std::filesystem::exists(there) && !(may_replace && (std::filesystem::is_regular_file(there) ||
                                                          std::filesystem::is_symlink(there))))
    return false;
  return write_beside(file, may_replace, content, Flush::yes, file);
}

std::string sha256(const std::string& bytes) {
  std::array<char, SHA256_DIGEST_STRING_LENGTH> digest{};
  SHA256Data(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), digest.data());
  return digest.data();
}

}  // namespace kinetostat::io

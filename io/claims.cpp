#include "kinetostat/io/claims.h"

#include <cerrno>
#include <cstring>
#include <ctime>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::io {
namespace {

using std::filesystem::path;

// Of a renewal, so that one that comes late costs no claim.
constexpr int renewals_until_expiry = 6;

int unnamed_file(const path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  std::string name = (folder / ".clock.XXXXXX").string();
  const int descriptor = ::mkostemp(name.data(), O_CLOEXEC);
  if (descriptor < 0)
    throw common::InputError(folder, fmt::format("cannot be written to ({})", std::strerror(errno)),
                             "Name a folder that every worker can write to");
  ::unlink(name.c_str());
  return descriptor;
}

int new_file(const path& file) {
  return ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
}

// By the clock of the file system, which a shared one has elsewhere.
void touch(int descriptor) { (void)::futimens(descriptor, nullptr); }

std::chrono::nanoseconds touched(const struct stat& status) {
  return std::chrono::seconds(status.st_mtim.tv_sec) +
         std::chrono::nanoseconds(status.st_mtim.tv_nsec);
}

}  // namespace

Claims::Claims(path folder, std::chrono::milliseconds expiry)
    : folder_(std::move(folder)),
      expiry_(expiry),
      clock_(unnamed_file(folder_)),
      renewer_([this](const std::stop_token& over) { renew(over); }) {}

Claims::~Claims() {
  renewer_ = {};
  for (const auto& [name, descriptor] : held_) remove(file_of(name), descriptor);
  ::close(clock_);
}

path Claims::file_of(const std::string& name) const { return folder_ / (sha256(name) + ".claim"); }

bool Claims::claim(const std::string& name) {
  const std::lock_guard lock(mutex_);
  if (held_.contains(name)) return false;
  const path file = file_of(name);
  int descriptor = new_file(file);
  if (descriptor < 0 && errno == EEXIST) {
    if (!is_expired(file)) return false;
    ::unlink(file.c_str());
    descriptor = new_file(file);
    if (descriptor < 0 && errno == EEXIST) return false;
  }
  held_[name] = descriptor;
  return true;
}

void Claims::give_up(const std::string& name) {
  const std::lock_guard lock(mutex_);
  if (const auto held = held_.extract(name)) remove(file_of(name), held.mapped());
}

// Opened, because a shared file system may show attributes of some time ago to who does not.
bool Claims::is_expired(const path& file) const {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;  // given up meanwhile
  touch(clock_);
  struct stat claimed = {}, now = {};
  const bool is_known = ::fstat(descriptor, &claimed) == 0 && ::fstat(clock_, &now) == 0;
  ::close(descriptor);
  return is_known && touched(now) - touched(claimed) > expiry_;
}

// Unless the claim expired and is that of somebody else now.
void Claims::remove(const path& file, int descriptor) const {
  if (descriptor < 0) return;
  struct stat own = {}, there = {};
  if (::fstat(descriptor, &own) == 0 && ::stat(file.c_str(), &there) == 0 &&
      own.st_dev == there.st_dev && own.st_ino == there.st_ino)
    ::unlink(file.c_str());
  ::close(descriptor);
}

void Claims::renew(const std::stop_token& over) {
  std::unique_lock lock(mutex_);
  const auto is_over = [&over] { return over.stop_requested(); };
  while (!ends_.wait_for(lock, over, expiry_ / renewals_until_expiry, is_over))
    for (const auto& [name, descriptor] : held_) touch(descriptor);
}

}  // namespace kinetostat::io

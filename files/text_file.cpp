#include "kinetostat/files/text_file.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <sha256.h>
#include <sstream>
#include <sys/types.h>
#include <unistd.h>

#include <fmt/format.h>

#include "kinetostat/files/error.h"

namespace kinetostat::files {
namespace {

[[noreturn]] void fail_to_write(const std::filesystem::path& file, int error) {
  throw InputError(file, fmt::format("cannot be written ({})", std::strerror(error)),
                   "Choose a folder that you may write to");
}

void write_all(int descriptor, const std::string& content, const std::filesystem::path& file) {
  std::size_t done = 0;
  while (done < content.size()) {
    const ssize_t written = ::write(descriptor, content.data() + done, content.size() - done);
    if (written < 0 && errno != EINTR) fail_to_write(file, errno);
    if (written > 0) done += static_cast<std::size_t>(written);
  }
  if (::fsync(descriptor) != 0 && errno != EINVAL) fail_to_write(file, errno);
}

}  // namespace

std::string read_text(const std::filesystem::path& file) {
  if (std::filesystem::is_directory(file))
    throw InputError(file, "is a folder, not a file", "Name a file in it");
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    throw InputError(file, fmt::format("cannot be read ({})", std::strerror(errno)),
                     "Check the path and that you may read it");
  std::ostringstream content;
  content << stream.rdbuf();
  return std::move(content).str();
}

void write_atomically(const std::filesystem::path& file, const std::string& content) {
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) fail_to_write(file, error.value());
  const std::filesystem::path temporary =
      folder / fmt::format(".{}.{}.tmp", file.filename().string(), ::getpid());
  const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) fail_to_write(file, errno);
  try {
    write_all(descriptor, content, file);
  } catch (...) {
    ::close(descriptor);
    ::unlink(temporary.c_str());
    throw;
  }
  ::close(descriptor);
  if (::rename(temporary.c_str(), file.c_str()) != 0) {
    const int rename_error = errno;
    ::unlink(temporary.c_str());
    fail_to_write(file, rename_error);
  }
}

std::string sha256(const std::string& bytes) {
  std::array<char, SHA256_DIGEST_STRING_LENGTH> digest{};
  SHA256Data(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), digest.data());
  return digest.data();
}

}  // namespace kinetostat::files

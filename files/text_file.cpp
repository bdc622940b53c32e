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

void write_all(int descriptor, const std::string& content, Flush flush,
               const std::filesystem::path& file) {
  std::size_t done = 0;
  while (done < content.size()) {
    const ssize_t written = ::write(descriptor, content.data() + done, content.size() - done);
    if (written < 0 && errno != EINTR) fail_to_write(file, errno);
    if (written > 0) done += static_cast<std::size_t>(written);
  }
  if (flush == Flush::yes && ::fsync(descriptor) != 0 && errno != EINVAL)
    fail_to_write(file, errno);
}

// Opens, writes and closes `path`; errors name `file`, which is what the user asked for.
void write_file(const std::filesystem::path& path, int flags, const std::string& content,
                Flush flush, const std::filesystem::path& file) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | flags, 0666);
  if (descriptor < 0) fail_to_write(file, errno);
  try {
    write_all(descriptor, content, flush, file);
  } catch (...) {
    ::close(descriptor);
    throw;
  }
  ::close(descriptor);
}

// Set before anything is read, and only read by the threads that read.
std::vector<std::filesystem::path>& outputs() {
  static std::vector<std::filesystem::path> all;
  return all;
}

void require_no_output(const std::filesystem::path& file) {
  std::error_code error;
  for (const std::filesystem::path& output : outputs())
    if (std::filesystem::equivalent(file, output, error) &&
        std::filesystem::is_regular_file(file, error))
      throw InputError(file, "is read, and the result would replace it",
                       "Name another file for the result");
}

// Of what is there already, of the nearest folder above it where nothing is.
void require_writable(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) fail_to_write(file, EISDIR);
  if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error))
    return;  // a device or a pipe
  std::filesystem::path folder =
      std::filesystem::weakly_canonical(std::filesystem::absolute(file), error).parent_path();
  while (!std::filesystem::exists(folder, error) && folder.has_relative_path())
    folder = folder.parent_path();
  if (!std::filesystem::is_directory(folder, error)) fail_to_write(file, ENOTDIR);
  if (::access(folder.c_str(), W_OK | X_OK) != 0) fail_to_write(file, errno);
}

}  // namespace

Outputs::Outputs(std::vector<std::filesystem::path> files) {
  for (const std::filesystem::path& file : files) require_writable(file);
  outputs() = std::move(files);
}

Outputs::~Outputs() { outputs().clear(); }

std::string read_text(const std::filesystem::path& file) {
  std::error_code error;  // whatever it is, reading says so
  if (std::filesystem::is_directory(file, error))
    throw InputError(file, "is a folder, not a file", "Name a file in it");
  require_no_output(file);
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    throw InputError(file, fmt::format("cannot be read ({})", std::strerror(errno)),
                     "Check the path and that you may read it");
  std::ostringstream content;
  content << stream.rdbuf();
  return std::move(content).str();
}

void write_atomically(const std::filesystem::path& file, const std::string& content, Flush flush) {
  std::error_code error;
  if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error)) {
    // A device or a pipe has no content to protect, and must not be replaced by a file.
    write_file(file, 0, content, flush, file);
    return;
  }
  // Renaming over a symbolic link would replace the link, so its target is written.
  const bool is_link = std::filesystem::is_symlink(file, error);
  const std::filesystem::path target =
      is_link ? std::filesystem::weakly_canonical(file, error) : file;
  const std::filesystem::path folder = target.has_parent_path() ? target.parent_path() : ".";
  std::filesystem::create_directories(folder, error);
  if (error) fail_to_write(file, error.value());
  const std::filesystem::path temporary =
      folder / fmt::format(".{}.{}.tmp", target.filename().string(), ::getpid());
  try {
    write_file(temporary, O_CREAT | O_TRUNC, content, flush, file);
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
  if (::rename(temporary.c_str(), target.c_str()) != 0) {
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

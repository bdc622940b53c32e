// Whole files read and written; nothing is ever left half-written.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace kinetostat::io {

inline constexpr std::size_t largest_file = std::size_t{4} << 30;      // [bytes]
inline constexpr std::size_t largest_stream = std::size_t{256} << 20;  // of a pipe or a device

/// The whole content of a file. Throws InputError when it cannot be read, would be replaced by a
/// result (Outputs), or is larger than `largest_file`, for pipes and devices `largest_stream`.
/// Throws Cancelled when a signal arrives while it waits for a pipe.
std::string read_text(const std::filesystem::path& file);

/// The first `most` bytes of a file, or all when there are fewer. Throws as read_text() does, but
/// never because the file is large.
std::string read_start(const std::filesystem::path& file, std::size_t most);

/// Files that results will be written to: as long as this lives, read_text() refuses them, whatever
/// they are called, so that no result replaces what it was made from. One at a time. Throws
/// InputError when one of them cannot be written (no folder, no permission, a name that is longer
/// than the file system takes), before time is spent on a result.
class Outputs {
 public:
  explicit Outputs(std::vector<std::filesystem::path> files);
  ~Outputs();
  Outputs(const Outputs&) = delete;
  Outputs& operator=(const Outputs&) = delete;
};

/// What files are read as while this lives, in place of what they hold, whatever they are called:
/// values that are set for one run. One at a time.
class ReadAs {
 public:
  using Content = std::pair<std::filesystem::path, std::string>;
  explicit ReadAs(std::vector<Content> files);
  ~ReadAs();
  ReadAs(const ReadAs&) = delete;
  ReadAs& operator=(const ReadAs&) = delete;
};

/// Throws what Outputs throws for a file that cannot be written.
void require_writable(const std::filesystem::path& file);

/// Whether content must be on the disk before its name is.
enum class Flush {
  yes,
  no  // quicker, but a crash of the machine may leave a part
};

/// Writes to a temporary file in the same folder, flushes it to disk, then renames it over `file`:
/// at every moment the old content or the new is there, never a part. Folders that are missing are
/// made. The replaced file passes on its permissions, and its owner and group where the system lets
/// it; a group that it cannot keep loses its permissions. Symbolic links are followed; devices and
/// pipes are written to directly. Throws InputError when the folder cannot be written to.
void write_atomically(const std::filesystem::path& file, const std::string& content,
                      Flush flush = Flush::yes);

/// Targets that write_in_place_of() may replace.
enum class Replace {
  nothing,  // what is there stays, even a symbolic link that leads nowhere
  entry     // a file or a symbolic link itself; what the link leads to stays
};

/// The same, but follows no symbolic link in the last part of the name: for names that somebody
/// else chose. False when something is there that must not be replaced.
bool write_in_place_of(Replace replace, const std::filesystem::path& file,
                       const std::string& content);

/// SHA-256 of some bytes, 64 lower-case hexadecimal digits.
std::string sha256(const std::string& bytes);

}  // namespace kinetostat::io

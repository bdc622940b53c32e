// Whole files read and written; nothing is ever left half-written.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kinetostat::files {

/// The whole content of a file. Throws InputError when it cannot be read, or would be replaced by a
/// result (Outputs).
std::string read_text(const std::filesystem::path& file);

/// Files that results will be written to: as long as this lives, read_text() refuses them, whatever
/// they are called, so that no result replaces what it was made from. One at a time. Throws
/// InputError when one of them cannot be written, before time is spent on a result.
class Outputs {
 public:
  explicit Outputs(std::vector<std::filesystem::path> files);
  ~Outputs();
  Outputs(const Outputs&) = delete;
  Outputs& operator=(const Outputs&) = delete;
};

/// Whether content must be on the disk before its name is.
enum class Flush {
  yes,
  no  // quicker, but a crash of the machine may leave a part
};

/// Writes to a temporary file in the same folder, flushes it to disk, then renames it over `file`:
/// at every moment the old content or the new is there, never a part. Folders that are missing are
/// made. Symbolic links are followed; devices and pipes are written to directly. Throws InputError
/// when the folder cannot be written to.
void write_atomically(const std::filesystem::path& file, const std::string& content,
                      Flush flush = Flush::yes);

/// SHA-256 of some bytes, 64 lower-case hexadecimal digits.
std::string sha256(const std::string& bytes);

}  // namespace kinetostat::files

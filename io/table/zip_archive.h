// Reads zip archives, as spreadsheets are.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace kinetostat::io {

/// The files in a zip archive of stored and deflated entries (PKWARE APPNOTE 6.3, without
/// encryption, several disks and Zip64). Keeps a view of the bytes.
class ZipArchive {
 public:
  static constexpr std::size_t largest_entry = std::size_t{512} << 20;  // unpacked [bytes]

  /// `file` stands for the archive in messages. Throws InputError when it has no directory.
  ZipArchive(std::string_view bytes, std::filesystem::path file);

  bool has(const std::string& name) const { return entries_.count(name) > 0; }
  /// Unpacked content. Throws InputError when there is none of this name, it is damaged, packed
  /// in another way or larger than largest_entry.
  std::string read(const std::string& name) const;

 private:
  struct Entry {
    std::uint32_t method = 0, checksum = 0;
    std::size_t packed = 0, unpacked = 0, begin = 0;  // size, size and place of the local header
  };
  std::uint32_t number(std::size_t at, std::size_t bytes) const;
  [[noreturn]] void fail(const std::string& what) const;

  std::string_view bytes_;
  std::filesystem::path file_;
  std::map<std::string, Entry> entries_;
};

}  // namespace kinetostat::io

#include "kinetostat/io/table/zip_archive.h"

#include <algorithm>
#include <zlib.h>

#include <fmt/format.h>

#include "kinetostat/common/error.h"

namespace kinetostat::io {
namespace {

constexpr std::size_t end_size = 22, entry_size = 46, local_size = 30;
constexpr std::uint32_t stored = 0, deflated = 8;
constexpr std::size_t most_deflated = 1040;  // bytes from one, RFC 1951: 258 from two bits

// Exactly `size` bytes, or nothing.
std::string inflated(std::string_view packed, std::size_t size) {
  std::string content(size, '\0');
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) return {};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(content.data());
  stream.avail_out = static_cast<uInt>(content.size());
  const int end = inflate(&stream, Z_FINISH);
  const bool whole = end == Z_STREAM_END && stream.avail_out == 0;
  inflateEnd(&stream);
  return whole ? content : std::string();
}

}  // namespace

ZipArchive::ZipArchive(std::string_view bytes, std::filesystem::path file)
    : bytes_(bytes), file_(std::move(file)) {
  const std::size_t end = bytes_.rfind("PK\x05\x06");
  if (end == std::string_view::npos || end + end_size > bytes_.size())
    fail("its directory is missing");
  std::size_t at = number(end + 16, 4);
  for (std::uint32_t left = number(end + 10, 2); left > 0; --left) {
    if (at + entry_size > end || bytes_.substr(at, 4) != "PK\x01\x02")
      fail("its directory is damaged");
    const std::size_t name = number(at + 28, 2);
    Entry entry{.method = number(at + 10, 2),
                .checksum = number(at + 16, 4),
                .packed = number(at + 20, 4),
                .unpacked = number(at + 24, 4),
                .begin = number(at + 42, 4)};
    entries_[std::string(bytes_.substr(at + entry_size, name))] = entry;
    at += entry_size + name + number(at + 30, 2) + number(at + 32, 2);
  }
}

std::string ZipArchive::read(const std::string& name) const {
  const auto found = entries_.find(name);
  if (found == entries_.end()) fail(fmt::format("it has no '{}'", name));
  const Entry& entry = found->second;
  if (entry.unpacked > largest_entry)
    fail(fmt::format("'{}' is larger than {} MiB", name, largest_entry >> 20));
  if (entry.begin + local_size > bytes_.size()) fail(fmt::format("'{}' is damaged", name));
  const std::size_t begin =
      entry.begin + local_size + number(entry.begin + 26, 2) + number(entry.begin + 28, 2);
  if (entry.unpacked / most_deflated > entry.packed) fail(fmt::format("'{}' is damaged", name));
  if (begin > bytes_.size() || entry.packed > bytes_.size() - begin)
    fail(fmt::format("'{}' is cut off", name));
  if (entry.method != stored && entry.method != deflated)
    fail(fmt::format("'{}' is packed in a way that is not known", name));
  const std::string_view packed = bytes_.substr(begin, entry.packed);
  std::string content =
      entry.method == stored ? std::string(packed) : inflated(packed, entry.unpacked);
  const auto* data = reinterpret_cast<const Bytef*>(content.data());
  if (content.size() != entry.unpacked ||
      crc32(0, data, static_cast<uInt>(content.size())) != entry.checksum)
    fail(fmt::format("'{}' is damaged", name));
  return content;
}

// Little-endian.
std::uint32_t ZipArchive::number(std::size_t at, std::size_t bytes) const {
  std::uint32_t value = 0;
  for (std::size_t i = bytes; i-- > 0;)
    value = value << 8 | static_cast<unsigned char>(bytes_[at + i]);
  return value;
}

void ZipArchive::fail(const std::string& what) const {
  throw common::InputError(file_, "this zip archive cannot be read: " + what,
                           "Save the file again; tables can be saved as 'CSV UTF-8' as well");
}

}  // namespace kinetostat::io

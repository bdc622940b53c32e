// Arrays as bytes, one after the other: a 64-bit count, then that many items as they lie in memory.
// For talking to helper programs on the same machine; nothing but the standard library, so that the
// helpers share no code with the rest.
#pragma once

#include <cstdint>
#include <cstring>
#include <istream>
#include <string>

namespace kinetostat::common {

/// The start of a block whose items follow by another way.
inline void append_count(std::string& bytes, std::uint64_t count) {
  bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
}

template <class Items>
void append_block(std::string& bytes, const Items& items) {
  const std::uint64_t count = items.size();
  append_count(bytes, count);
  if (count > 0)
    bytes.append(reinterpret_cast<const char*>(items.data()), count * sizeof(items[0]));
}

/// Takes one block off the front of bytes[at..]; false when the bytes end too early.
template <class Items>
bool take_block(const std::string& bytes, std::size_t& at, Items& items) {
  std::uint64_t count = 0;
  if (bytes.size() - at < sizeof count) return false;
  std::memcpy(&count, bytes.data() + at, sizeof count);
  at += sizeof count;
  if ((bytes.size() - at) / sizeof(items[0]) < count) return false;
  items.resize(count);
  if (count > 0)
    std::memcpy(static_cast<void*>(items.data()), bytes.data() + at, count * sizeof(items[0]));
  at += count * sizeof(items[0]);
  return true;
}

/// Takes the start of a block off a file; false when fewer items of this size follow than it says.
inline bool take_count(std::istream& file, std::size_t item_size, std::uint64_t& count) {
  if (!file.read(reinterpret_cast<char*>(&count), sizeof count)) return false;
  const std::istream::pos_type here = file.tellg();
  file.seekg(0, std::ios::end);
  const std::istream::off_type left = file.tellg() - here;
  file.seekg(here);
  return file.good() && static_cast<std::uint64_t>(left) / item_size >= count;
}

/// Takes one block off a file, without a copy of its bytes; false when the file ends too early.
template <class Items>
bool take_block(std::istream& file, Items& items) {
  std::uint64_t count = 0;
  if (!take_count(file, sizeof(items[0]), count)) return false;
  items.resize(count);
  const auto bytes = static_cast<std::streamsize>(count * sizeof(items[0]));
  return static_cast<bool>(file.read(reinterpret_cast<char*>(items.data()), bytes));
}

/// The blocks one after the other.
template <class... Items>
std::string encode_blocks(const Items&... blocks) {
  std::string bytes;
  (append_block(bytes, blocks), ...);
  return bytes;
}

/// The blocks that encode_blocks() wrote; false when `bytes` holds more or less than these.
template <class... Items>
bool decode_blocks(const std::string& bytes, Items&... blocks) {
  std::size_t at = 0;
  return (take_block(bytes, at, blocks) && ...) && at == bytes.size();
}

/// The next blocks of a file; false when it ends too early.
template <class... Items>
bool read_blocks(std::istream& file, Items&... blocks) {
  return (take_block(file, blocks) && ...);
}

}  // namespace kinetostat::common

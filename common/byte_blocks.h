// Arrays as bytes, one after the other: a 64-bit count, then that many items as they lie in memory.
// For talking to helper programs on the same machine; nothing but the standard library, so that the
// helpers share no code with the rest.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>

namespace kinetostat::common {

template <class Items>
void append_block(std::string& bytes, const Items& items) {
  const std::uint64_t count = items.size();
  bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
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
  if (count > 0) std::memcpy(items.data(), bytes.data() + at, count * sizeof(items[0]));
  at += count * sizeof(items[0]);
  return true;
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

}  // namespace kinetostat::common

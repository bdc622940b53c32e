#include "kinetostat/io/table/text_encoding.h"

#include <array>
#include <string_view>

#include "kinetostat/common/error.h"

namespace kinetostat::io {
namespace {

std::string from_utf16(std::string_view bytes, bool big, const std::filesystem::path& file) {
  const auto unit = [&](std::size_t i) {
    const auto a = static_cast<unsigned char>(bytes[i]),
               b = static_cast<unsigned char>(bytes[i + 1]);
    return static_cast<std::uint32_t>(big ? a << 8 | b : b << 8 | a);
  };
  if (bytes.size() % 2 != 0)
    throw common::InputError(file, "is UTF-16 text that ends within a character",
                             "Save it again, as 'CSV UTF-8' where there is a choice");
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 2) {
    std::uint32_t code = unit(i);
    const bool pair = code >= 0xD800 && code < 0xDC00 && i + 3 < bytes.size() &&
                      unit(i + 2) >= 0xDC00 && unit(i + 2) < 0xE000;
    if (pair) {
      code = 0x10000 + ((code - 0xD800) << 10) + (unit(i + 2) - 0xDC00);
      i += 2;
    } else if (code >= 0xD800 && code < 0xE000) {
      code = '?';
    }
    append_utf8(text, code);
  }
  return text;
}

// Continuation bytes that a first byte wants; 4 for a byte that starts no character.
int wanted_after(unsigned char byte) {
  return byte < 0x80                    ? 0
         : byte >= 0xC2 && byte < 0xE0  ? 1
         : byte >= 0xE0 && byte < 0xF0  ? 2
         : byte >= 0xF0 && byte <= 0xF4 ? 3
                                        : 4;
}

bool is_utf8(std::string_view text) {
  int wanted = 0;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (wanted > 0) {
      if ((byte & 0xC0) != 0x80) return false;
      --wanted;
    } else {
      wanted = wanted_after(byte);
      if (wanted == 4) return false;
    }
  }
  return wanted == 0;
}

// What Windows-1252 has at 0x80 to 0x9F; the rest is Latin-1.
constexpr std::array<std::uint16_t, 32> windows_1252 = {
    0x20AC, 0x81,   0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021, 0x02C6, 0x2030, 0x0160,
    0x2039, 0x0152, 0x8D,   0x017D, 0x8F,   0x90,   0x2018, 0x2019, 0x201C, 0x201D, 0x2022,
    0x2013, 0x2014, 0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0x9D,   0x017E, 0x0178};

std::string from_windows_1252(std::string_view bytes) {
  std::string text;
  text.reserve(bytes.size() + bytes.size() / 16);
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    append_utf8(text, byte >= 0x80 && byte < 0xA0 ? windows_1252[byte - 0x80U] : byte);
  }
  return text;
}

}  // namespace

void append_utf8(std::string& text, std::uint32_t code) {
  const auto put = [&text](std::uint32_t byte) { text += static_cast<char>(byte); };
  if (code < 0x80) {
    put(code);
  } else if (code < 0x800) {
    put(0xC0 | code >> 6), put(0x80 | (code & 0x3F));
  } else if (code < 0x10000) {
    put(0xE0 | code >> 12), put(0x80 | (code >> 6 & 0x3F)), put(0x80 | (code & 0x3F));
  } else {
    put(0xF0 | code >> 18), put(0x80 | (code >> 12 & 0x3F));
    put(0x80 | (code >> 6 & 0x3F)), put(0x80 | (code & 0x3F));
  }
}

std::string as_utf8(std::string bytes, const std::filesystem::path& file) {
  const std::string_view text = bytes;
  if (text.starts_with("\xff\xfe")) return from_utf16(text.substr(2), false, file);
  if (text.starts_with("\xfe\xff")) return from_utf16(text.substr(2), true, file);
  if (!is_utf8(text)) return from_windows_1252(text);
  if (text.starts_with("\xef\xbb\xbf")) bytes.erase(0, 3);
  return bytes;
}

}  // namespace kinetostat::io

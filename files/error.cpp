#include "kinetostat/files/error.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

namespace kinetostat::files {
namespace {

std::string sentence(std::string text) {
  if (!text.empty() && text.back() != '.' && text.back() != '?' && text.back() != '\n') text += '.';
  return text;
}

// How many bytes the UTF-8 character at the beginning of a text has; 0 when it is none.
std::size_t character_size(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const std::size_t size = byte(0) < 0x80                       ? 1
                           : byte(0) >= 0xc2 && byte(0) < 0xe0  ? 2
                           : (byte(0) & 0xf0) == 0xe0           ? 3
                           : byte(0) >= 0xf0 && byte(0) <= 0xf4 ? 4
                                                                : 0;
  if (size == 0 || size > text.size()) return 0;
  for (std::size_t i = 1; i < size; ++i)
    if ((byte(i) & 0xc0) != 0x80) return 0;
  return size;
}

// A file that is none of ours may hold anything: what is quoted of it neither floods nor upsets a
// terminal.
std::string readable(const std::string& text) {
  constexpr std::size_t head = 800, tail = 200;
  const std::string cut = text.size() <= head + tail + 100
                              ? text
                              : text.substr(0, head) + " ... " + text.substr(text.size() - tail);
  std::string result;
  for (std::string_view left = cut; !left.empty();) {
    const std::size_t size = character_size(left);
    const auto first = static_cast<unsigned char>(left[0]);
    const bool shown = size > 1 || (size == 1 && (first >= 0x20 || first == '\n') && first != 0x7f);
    result += shown ? left.substr(0, size) : "?";
    left.remove_prefix(std::max<std::size_t>(size, 1));
  }
  return result;
}

std::string message(const InputError::Details& d) {
  std::string text = d.file.string();
  if (d.line > 0) text += fmt::format(":{}", d.line);
  if (d.column > 0) text += fmt::format(":{}", d.column);
  if (!text.empty()) text += ": ";
  if (!d.key.empty()) text += readable(d.key) + ": ";
  text += sentence(readable(d.what));
  if (!d.cure.empty()) text += " " + sentence(d.cure);
  return text;
}

}  // namespace

InputError::InputError(Details details)
    : std::runtime_error(message(details)), details_(std::move(details)) {}

InputError::InputError(const std::filesystem::path& file, const std::string& what,
                       const std::string& cure)
    : InputError(Details{.file = file, .what = what, .cure = cure}) {}

}  // namespace kinetostat::files

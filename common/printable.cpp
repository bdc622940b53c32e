#include "kinetostat/common/printable.h"

#include <algorithm>

namespace kinetostat::common {
namespace {

// How many bytes the UTF-8 character at the start of a text has; 0 when it is none.
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

bool is_control(std::string_view character) {
  const auto first = static_cast<unsigned char>(character[0]);
  if (character.size() == 1) return first < 0x20 || first == 0x7f;
  const bool c1 = first == 0xc2 && static_cast<unsigned char>(character[1]) < 0xa0;
  return c1 || character == "\xe2\x80\xa8" || character == "\xe2\x80\xa9";
}

// Calls visit(character) for each; those that are not UTF-8 come as one byte, and `sound` false.
template <class Visit>
void for_each_character(std::string_view text, Visit visit) {
  while (!text.empty()) {
    const std::size_t size = character_size(text);
    visit(text.substr(0, std::max<std::size_t>(size, 1)), size > 0);
    text.remove_prefix(std::max<std::size_t>(size, 1));
  }
}

}  // namespace

bool has_control_characters(std::string_view text) {
  bool found = false;
  for_each_character(text, [&found](std::string_view character, bool sound) {
    found = found || (sound && is_control(character));
  });
  return found;
}

std::string printable(std::string_view text, std::string_view kept) {
  std::string result;
  result.reserve(text.size());
  for_each_character(text, [&](std::string_view character, bool sound) {
    const bool shown =
        sound && (!is_control(character) || kept.find(character) != std::string_view::npos);
    result += shown ? character : "?";
  });
  return result;
}

std::string plain_name(std::string_view text, std::string_view forbidden, std::size_t longest) {
  std::string name;
  bool is_full = false;
  for_each_character(text, [&](std::string_view character, bool sound) {
    is_full = is_full || name.size() + character.size() > longest;
    const bool shown =
        sound && !is_control(character) && forbidden.find(character) == std::string_view::npos;
    if (!is_full) name += shown ? character : "?";
  });
  return name;
}

}  // namespace kinetostat::common

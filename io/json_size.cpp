#include "kinetostat/io/json_size.h"

#include <cstddef>

namespace kinetostat::io {
namespace {

// Calls visit(c) for every character outside of texts, until it returns false.
template <class Visit>
bool for_each_mark(std::string_view json, Visit visit) {
  bool in_text = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_text && c == '\\')
      ++i;  // whatever comes is part of the text
    else if (c == '"')
      in_text = !in_text;
    else if (!in_text && !visit(c))
      return false;
  }
  return true;
}

}  // namespace

bool is_nested_too_deeply(std::string_view json) {
  constexpr int deepest = 200;
  int depth = 0;
  return !for_each_mark(json, [&depth](char c) {
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    return depth <= deepest;
  });
}

// As nlohmann::ordered_json keeps them on a machine with 64 bits: 16 bytes a value, twice that
// while a list grows; a list or a map by itself is a block of the heap, and a key another.
bool is_too_large(std::string_view json) {
  constexpr std::size_t limit = std::size_t{1} << 30, value = 32, container = 64, key = 64;
  std::size_t bytes = json.size();
  return !for_each_mark(json, [&bytes](char c) {
    if (c == ',') bytes += value;
    if (c == '[' || c == '{') bytes += container;
    if (c == ':') bytes += key;
    return bytes <= limit;
  });
}

}  // namespace kinetostat::io

#include "kinetostat/common/error.h"

#include <string_view>

#include <fmt/format.h>

#include "kinetostat/common/printable.h"

namespace kinetostat::common {
namespace {

std::string sentence(std::string text) {
  if (!text.empty() && text.back() != '.' && text.back() != '?' && text.back() != '\n') text += '.';
  return text;
}

// A file that is none of ours may hold anything: what is quoted of it neither floods nor upsets a
// terminal.
std::string readable(const std::string& text, std::string_view kept = {}) {
  constexpr std::size_t head = 800, tail = 200;
  const std::string cut = text.size() <= head + tail + 100
                              ? text
                              : text.substr(0, head) + " ... " + text.substr(text.size() - tail);
  return printable(cut, kept);
}

std::string message(const InputError::Details& d) {
  constexpr std::string_view lines = "\n";  // some messages have several
  std::string text = printable(d.file.string());
  if (d.line > 0) text += fmt::format(":{}", d.line);
  if (d.column > 0) text += fmt::format(":{}", d.column);
  if (!text.empty()) text += ": ";
  if (!d.key.empty()) text += readable(d.key) + ": ";
  text += sentence(readable(d.what, lines));
  if (!d.cure.empty()) text += " " + sentence(readable(d.cure, lines));
  return text;
}

}  // namespace

InputError::InputError(Details details)
    : std::runtime_error(message(details)), details_(std::move(details)) {}

InputError::InputError(const std::filesystem::path& file, const std::string& what,
                       const std::string& cure)
    : InputError(Details{.file = file, .what = what, .cure = cure}) {}

}  // namespace kinetostat::common

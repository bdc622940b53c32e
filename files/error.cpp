#include "kinetostat/files/error.h"

#include <fmt/format.h>

namespace kinetostat::files {
namespace {

std::string sentence(std::string text) {
  if (!text.empty() && text.back() != '.' && text.back() != '?' && text.back() != '\n') text += '.';
  return text;
}

std::string message(const InputError::Details& d) {
  std::string text = d.file.string();
  if (d.line > 0) text += fmt::format(":{}", d.line);
  if (d.column > 0) text += fmt::format(":{}", d.column);
  if (!text.empty()) text += ": ";
  if (!d.key.empty()) text += d.key + ": ";
  text += sentence(d.what);
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

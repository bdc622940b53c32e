#include "kinetostat/io/table/xml_scanner.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <utility>

#include "kinetostat/io/table/text_encoding.h"

namespace kinetostat::io {
namespace {

constexpr std::string_view blanks = " \t\r\n";
constexpr std::string_view cdata = "<![CDATA[";

std::string_view without_namespace(std::string_view name) {
  const std::size_t colon = name.find(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

// "amp", "#38" or "#x26"; empty for what is not known.
std::string character_of(std::string_view entity) {
  constexpr std::array<std::pair<std::string_view, char>, 5> named{
      {{"amp", '&'}, {"lt", '<'}, {"gt", '>'}, {"quot", '"'}, {"apos", '\''}}};
  for (const auto& [name, character] : named)
    if (entity == name) return {character};
  if (!entity.starts_with('#')) return {};
  const bool hexadecimal = entity.starts_with("#x");
  entity.remove_prefix(hexadecimal ? 2 : 1);
  std::uint32_t code = 0;
  const auto [end, error] =
      std::from_chars(entity.data(), entity.data() + entity.size(), code, hexadecimal ? 16 : 10);
  if (error != std::errc() || code == 0 || code > 0x10FFFF) return {};
  std::string character;
  append_utf8(character, code);
  return character;
}

std::string decoded(std::string_view text) {
  std::string result;
  for (std::size_t at = 0; at < text.size();) {
    if (text.substr(at).starts_with(cdata)) {
      const std::size_t end = std::min(text.find("]]>", at), text.size());
      result += text.substr(at + cdata.size(), end - at - cdata.size());
      at = std::min(end + 3, text.size());
      continue;
    }
    const std::size_t end = text[at] == '&' ? text.find(';', at) : std::string_view::npos;
    if (end != std::string_view::npos && end - at < 12) {
      result += character_of(text.substr(at + 1, end - at - 1));
      at = end + 1;
    } else {
      result += text[at++];
    }
  }
  return result;
}

}  // namespace

bool XmlScanner::next() {
  const std::size_t begin = at_;
  while (true) {
    const std::size_t open = xml_.find('<', at_);
    if (open == std::string_view::npos) return false;
    const std::string_view rest = xml_.substr(open);
    std::string_view end = ">";
    const bool is_cdata = rest.starts_with(cdata), is_comment = rest.starts_with("<!--");
    if (is_cdata) end = "]]>";
    if (is_comment) end = "-->";
    // A '>' may stand within quotes.
    std::size_t close = open + 1;
    if (is_cdata || is_comment) {
      close = xml_.find(end, open);
    } else {
      for (char quote = 0; close < xml_.size() && (quote != 0 || xml_[close] != '>'); ++close) {
        const char c = xml_[close];
        if (quote == 0 && (c == '"' || c == '\''))
          quote = c;
        else if (c == quote)
          quote = 0;
      }
    }
    if (close >= xml_.size()) return false;
    at_ = close + end.size();
    if (rest.starts_with("<!") || rest.starts_with("<?")) continue;
    text_ = xml_.substr(begin, open - begin);
    std::string_view tag = xml_.substr(open + 1, close - open - 1);
    closes_ = tag.starts_with('/') || tag.ends_with('/');
    opens_ = !tag.starts_with('/');
    if (tag.starts_with('/')) tag.remove_prefix(1);
    if (tag.ends_with('/')) tag.remove_suffix(1);
    const std::size_t name = std::min(tag.find_first_of(blanks), tag.size());
    name_ = without_namespace(tag.substr(0, name));
    attributes_ = tag.substr(name);
    return true;
  }
}

std::string XmlScanner::text() const {
  // Comments within the text are no part of it.
  std::string kept;
  std::string_view rest = text_;
  for (std::size_t comment; (comment = rest.find("<!--")) != std::string_view::npos;) {
    kept += rest.substr(0, comment);
    const std::size_t end = rest.find("-->", comment);
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 3);
  }
  return decoded(kept + std::string(rest));
}

std::optional<std::string> XmlScanner::attribute(std::string_view name) const {
  for (std::size_t at = 0; at < attributes_.size();) {
    at = attributes_.find_first_not_of(blanks, at);
    const std::size_t equals = attributes_.find('=', at);
    if (at == std::string_view::npos || equals == std::string_view::npos) return std::nullopt;
    const std::size_t open = attributes_.find_first_of("\"'", equals);
    if (open == std::string_view::npos) return std::nullopt;
    const std::size_t close = attributes_.find(attributes_[open], open + 1);
    if (close == std::string_view::npos) return std::nullopt;
    std::string_view found = attributes_.substr(at, equals - at);
    found = found.substr(0, std::min(found.find_first_of(blanks), found.size()));
    if (without_namespace(found) == name)
      return decoded(attributes_.substr(open + 1, close - open - 1));
    at = close + 1;
  }
  return std::nullopt;
}

}  // namespace kinetostat::io

#include "kinetostat/io/table/table_numbers.h"

#include <algorithm>
#include <array>

namespace kinetostat::io {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// A number cut in pieces: sign, digits with what separates them, exponent.
struct Pieces {
  bool negative = false;
  std::string digits;    // digits, '.', ',' and '_' for any other separator of thousands
  std::string exponent;  // "e-3", or empty
};

// The other separators of thousands, each to be written as '_'.
constexpr std::array<std::string_view, 5> other_separators = {"'", " ", "\xc2\xa0", "\xe2\x80\x89",
                                                              "\xe2\x80\xaf"};

bool take(std::string_view& text, std::string_view start) {
  if (!text.starts_with(start)) return false;
  text.remove_prefix(start.size());
  return true;
}

std::optional<Pieces> cut(std::string_view text) {
  Pieces pieces;
  pieces.negative = take(text, "-") || take(text, "\xe2\x88\x92");
  if (!pieces.negative) take(text, "+");
  while (!text.empty()) {
    if (is_digit(text[0]) || text[0] == '.' || text[0] == ',') {
      pieces.digits += text[0];
      text.remove_prefix(1);
      continue;
    }
    if (text[0] == 'e' || text[0] == 'E') break;
    if (!std::any_of(other_separators.begin(), other_separators.end(),
                     [&text](std::string_view separator) { return take(text, separator); }))
      return std::nullopt;
    pieces.digits += '_';
  }
  if (!std::any_of(pieces.digits.begin(), pieces.digits.end(), is_digit)) return std::nullopt;
  if (text.empty()) return pieces;
  pieces.exponent = "e";
  text.remove_prefix(1);
  if (take(text, "-")) pieces.exponent += '-';
  take(text, "+");
  if (text.empty() || !std::all_of(text.begin(), text.end(), is_digit)) return std::nullopt;
  pieces.exponent += text;
  return pieces;
}

// "1", "123", "1.234.567" with '.' as the separator.
bool is_whole(std::string_view digits, char separator) {
  const std::size_t first = digits.find(separator);
  if (first == std::string_view::npos) return std::all_of(digits.begin(), digits.end(), is_digit);
  if (first == 0 || first > 3 || digits[0] == '0') return false;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    const bool at_separator = i >= first && (i - first) % 4 == 0;
    if (at_separator ? digits[i] != separator : !is_digit(digits[i])) return false;
  }
  return (digits.size() - first) % 4 == 0;
}

std::optional<std::string> with_point(const Pieces& pieces, char decimal) {
  const std::string_view digits = pieces.digits;
  const std::size_t at = digits.rfind(decimal);
  const std::string_view whole = digits.substr(0, at);
  const std::string_view fraction = at == std::string_view::npos ? "" : digits.substr(at + 1);
  if (!std::all_of(fraction.begin(), fraction.end(), is_digit)) return std::nullopt;
  const std::string_view separators = decimal == '.' ? ",_" : "._";
  if (std::none_of(separators.begin(), separators.end(),
                   [whole](char separator) { return is_whole(whole, separator); }))
    return std::nullopt;
  std::string number = pieces.negative ? "-" : "";
  for (const char c : whole)
    if (is_digit(c)) number += c;
  if (at != std::string_view::npos) number += "." + std::string(fraction);
  return number + pieces.exponent;
}

}  // namespace

bool is_ambiguous_number(std::string_view cell) {
  const std::optional<Pieces> pieces = cut(cell);
  return pieces && pieces->exponent.empty() &&
         pieces->digits.find_first_of(".,") != std::string::npos && with_point(*pieces, '.') &&
         with_point(*pieces, ',');
}

DecimalSign decimal_sign_of(std::string_view cell) {
  if (cell.find_first_of(".,") == std::string_view::npos) return DecimalSign::unknown;
  const std::optional<Pieces> pieces = cut(cell);
  if (!pieces) return DecimalSign::unknown;
  const std::string& digits = pieces->digits;
  bool point = with_point(*pieces, '.').has_value(), comma = with_point(*pieces, ',').has_value();
  // An exponent follows decimals, not thousands.
  if (point && comma && !pieces->exponent.empty()) {
    point = digits.find('.') != std::string::npos;
    comma = !point;
  }
  if (point == comma) return DecimalSign::unknown;
  return point ? DecimalSign::point : DecimalSign::comma;
}

std::optional<std::string> plain_number(std::string_view cell, DecimalSign decimal) {
  const std::optional<Pieces> pieces = cut(cell);
  if (!pieces) return std::nullopt;
  return with_point(*pieces, decimal == DecimalSign::comma ? ',' : '.');
}

}  // namespace kinetostat::io

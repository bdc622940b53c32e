#include "kinetostat/io/table/sheet_rows.h"

#include <algorithm>

namespace kinetostat::io {

void SheetRows::put(std::size_t row, std::size_t column, std::string text) {
  if (text.empty() || row >= most_rows || column >= most_columns || is_full()) return;
  ++count_;
  std::replace_if(
      text.begin(), text.end(),
      [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, ' ');
  if (row >= rows_.size()) rows_.resize(row + 1);
  if (column >= rows_[row].size()) rows_[row].resize(column + 1);
  rows_[row][column] = std::move(text);
}

namespace {

// In quotes where the text means something in a table.
std::string quoted_where_needed(const std::string& text) {
  if (text.find_first_of("\"#") == std::string::npos) return text;
  std::string result = "\"";
  for (const char letter : text) {
    if (letter == '"') result += '"';
    result += letter;
  }
  return result + '"';
}

}  // namespace

std::string SheetRows::text() const {
  std::size_t width = 0;
  for (const auto& row : rows_) width = std::max(width, row.size());
  std::string result;
  for (const auto& row : rows_) {
    for (std::size_t c = 0; !row.empty() && c < width; ++c) {
      if (c > 0) result += '\t';
      if (c < row.size()) result += quoted_where_needed(row[c]);
    }
    result += '\n';
  }
  return result;
}

}  // namespace kinetostat::io

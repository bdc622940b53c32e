#include "kinetostat/io/csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/printable.h"
#include "kinetostat/io/file_kind.h"
#include "kinetostat/io/largest_number.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::io {
namespace {

constexpr std::size_t most_columns = 10'000;

bool is_blank(char c) { return c == ' ' || c == '\t'; }

// What a number that did not read might have been meant as.
std::string number_cure(std::string_view text) {
  if (text.find(',') != std::string_view::npos) return "Write the decimals with a point";
  const bool digits = text.find_first_of("0123456789") != std::string_view::npos;
  const bool letters = std::any_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z' && c != 'e') || (c >= 'A' && c <= 'Z' && c != 'E');
  });
  if (digits && letters) return "Write the number alone: units are stated once for the whole file";
  return "Write a number such as -12.5 or 3e-4";
}

bool is_number(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

// Spreadsheets compute what starts so, and what they compute may start programs.
bool begins_formula(char c) { return c == '=' || c == '+' || c == '-' || c == '@'; }

// A text that a spreadsheet would take for a formula, but for the quotes before it.
bool is_formula_behind_quotes(std::string_view text) {
  const std::size_t first = text.find_first_not_of('\'');
  return first != std::string_view::npos && first + 1 < text.size() &&
         begins_formula(text[first]) && !is_number(text.substr(first));
}

}  // namespace

CsvTable::CsvTable(std::string content, std::filesystem::path file)
    : file_(std::move(file)), buffer_(std::move(content)) {
  if (buffer_.starts_with("\xff\xfe") || buffer_.starts_with("\xfe\xff"))
    throw common::InputError(file_, "is UTF-16 text", "Save it as 'CSV UTF-8'");
  refuse_other_kinds(file_, buffer_, "a table (CSV)", "Save the table as 'CSV UTF-8'");
  if (buffer_.size() >= std::numeric_limits<std::uint32_t>::max())
    throw common::InputError(file_, "is larger than 4 GiB", "Split it into several campaigns");
  if (buffer_.starts_with("\xef\xbb\xbf")) position_ = 3;
  if (!next_line())
    throw common::InputError(file_, "holds no table",
                             "Give a header line with column names, then rows");
  read_header();
  while (next_line()) read_row();
  if (rows() == 0)
    throw common::InputError({.file = file_,
                              .line = line_,
                              .what = "the table has a header but no row",
                              .cure = "Give one row a reading"});
}

// Moves to the next line that is neither empty nor a comment; false at the end of the file.
bool CsvTable::next_line() {
  while (position_ < buffer_.size()) {
    std::size_t first = position_;
    while (first < buffer_.size() && (is_blank(buffer_[first]) || buffer_[first] == '\r')) ++first;
    const bool skipped = first == buffer_.size() || buffer_[first] == '\n' || buffer_[first] == '#';
    if (!skipped) return true;
    const std::size_t end = buffer_.find('\n', first);
    if (end == std::string::npos) return false;
    position_ = end + 1;
    ++line_;
  }
  return false;
}

void CsvTable::read_header() {
  header_line_ = line_;
  const std::size_t end = std::min(buffer_.find('\n', position_), buffer_.size());
  const std::string_view header(buffer_.data() + position_, end - position_);
  for (const char candidate : {'\t', ';', ','})
    if (header.find(candidate) != std::string_view::npos) separator_ = candidate;
  std::vector<Cell> cells;
  read_cells(cells);
  if (cells.size() > most_columns)
    fail_at(cells.front().begin,
            fmt::format("the header names {} columns, of at most {}", cells.size(), most_columns),
            "Give one line a reading, not one column");
  for (const Cell& cell : cells) {
    const std::string name(text(cell));
    if (common::has_control_characters(name))
      fail_at(cell.begin, fmt::format("the column name '{}' has a control character", name),
              "Name every column on one line");
    if (name.empty())
      fail_at(cell.begin, fmt::format("column {} has no name", columns_.size() + 1),
              "Name every column in the header line");
    if (find(name))
      fail_at(cell.begin, fmt::format("two columns are named '{}'", name),
              "Give each column its own name");
    column_begins_.push_back(cell.begin);
    columns_.push_back(name);
  }
}

void CsvTable::read_row() {
  const std::size_t begin = position_, first = cells_.size();
  const int line = line_;
  read_cells(cells_);
  const std::size_t count = cells_.size() - first;
  const bool all_empty =
      std::all_of(cells_.begin() + static_cast<std::ptrdiff_t>(first), cells_.end(),
                  [](const Cell& cell) { return cell.length == 0; });
  if (all_empty && count > 1) {  // spreadsheets append such rows
    cells_.resize(first);
    return;
  }
  if (count != columns_.size())
    throw common::InputError(
        {.file = file_,
         .line = line,
         .key = count < columns_.size() ? columns_[count] : "",
         .what = fmt::format(
             "this row has {} {}, the header has {}: '{}'", count, count == 1 ? "cell" : "cells",
             columns_.size(),
             buffer_.substr(
                 begin, std::min<std::size_t>(60, buffer_.find_first_of("\r\n", begin) - begin))),
         .cure = "Give one cell for each column; leave a cell empty when nothing was measured, and "
                 "quote texts that hold a separator"});
  row_lines_.push_back(line);
}

// Reads the cells of one line and moves behind its end.
void CsvTable::read_cells(std::vector<Cell>& cells) {
  while (true) {
    while (position_ < buffer_.size() && is_blank(buffer_[position_]) &&
           buffer_[position_] != separator_)
      ++position_;
    const bool quoted = position_ < buffer_.size() && buffer_[position_] == '"';
    cells.push_back(quoted ? read_quoted_cell() : read_plain_cell());
    if (position_ < buffer_.size() && buffer_[position_] == '\r') ++position_;
    if (position_ >= buffer_.size()) return;
    const char c = buffer_[position_++];
    if (c == '\n') {
      ++line_;
      return;
    }
  }
}

CsvTable::Cell CsvTable::read_plain_cell() {
  const std::size_t begin = position_;
  while (position_ < buffer_.size()) {
    const char c = buffer_[position_];
    if (c == separator_ || c == '\n') break;
    ++position_;
  }
  std::size_t end = position_;
  while (end > begin && (is_blank(buffer_[end - 1]) || buffer_[end - 1] == '\r')) --end;
  return {begin, static_cast<std::uint32_t>(end - begin), -1};
}

CsvTable::Cell CsvTable::read_quoted_cell() {
  const std::size_t opening = position_++;
  Cell cell{position_, 0, -1};
  bool doubled = false;
  while (true) {
    const std::size_t quote = buffer_.find('"', position_);
    if (quote == std::string::npos)
      fail_at(opening, "the quote that starts here is not closed",
              "Close it, or write \"\" for a quote inside a quoted cell");
    position_ = quote + 1;
    if (position_ >= buffer_.size() || buffer_[position_] != '"') break;
    doubled = true;
    ++position_;
  }
  cell.length = static_cast<std::uint32_t>(position_ - 1 - cell.begin);
  const std::string_view raw(buffer_.data() + cell.begin, cell.length);
  line_ += static_cast<int>(std::count(raw.begin(), raw.end(), '\n'));
  if (doubled) {
    std::string& text = unescaped_.emplace_back();
    for (std::size_t i = 0; i < raw.size(); ++i) {
      text += raw[i];
      if (raw[i] == '"') ++i;
    }
    cell.unescaped = static_cast<std::int32_t>(unescaped_.size()) - 1;
  }
  while (position_ < buffer_.size() && is_blank(buffer_[position_]) &&
         buffer_[position_] != separator_)
    ++position_;
  if (position_ < buffer_.size() && buffer_[position_] != separator_ &&
      buffer_[position_] != '\n' && buffer_[position_] != '\r')
    fail_at(position_, "text follows the quote that ends this cell",
            "Put the whole cell between the quotes");
  return cell;
}

std::optional<std::size_t> CsvTable::find(std::string_view column) const {
  const auto found = std::find(columns_.begin(), columns_.end(), column);
  if (found == columns_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - columns_.begin());
}

std::string_view CsvTable::text(const Cell& cell) const {
  std::string_view text(buffer_.data() + cell.begin, cell.length);
  if (cell.unescaped >= 0) text = unescaped_[static_cast<std::size_t>(cell.unescaped)];
  // The quote that csv_cell() puts before a formula.
  if (text.starts_with('\'') && is_formula_behind_quotes(text)) text.remove_prefix(1);
  return text;
}

std::string_view CsvTable::cell(std::size_t row, std::size_t column) const {
  return text(cells_[row * columns_.size() + column]);
}

double CsvTable::number(std::size_t row, std::size_t column) const {
  const std::string_view all = cell(row, column);
  if (all.empty()) fail(row, column, "the cell is empty", "Write a number");
  const std::string_view digits = all.size() > 1 && all[0] == '+' ? all.substr(1) : all;
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (end != digits.data() + digits.size() || error == std::errc::invalid_argument)
    fail(row, column, fmt::format("'{}' is not a number", all), number_cure(all));
  if (!std::isfinite(value))
    fail(row, column, fmt::format("'{}' is not a finite number", all),
         "Leave the cell empty when nothing was measured");
  if (error == std::errc::result_out_of_range || std::abs(value) > largest_number)
    fail(row, column, fmt::format("'{}' is too large or too small to compute with", all),
         "Check the number and its unit");
  return value;
}

void CsvTable::fail(std::size_t row, std::size_t column, const std::string& what,
                    const std::string& cure) const {
  const std::size_t position = cells_[row * columns_.size() + column].begin;
  throw common::InputError({.file = file_,
                            .line = line_of(position),
                            .column = column_in_line(position),
                            .key = columns_[column],
                            .what = what,
                            .cure = cure});
}

void CsvTable::fail_column(std::size_t column, const std::string& what,
                           const std::string& cure) const {
  throw common::InputError({.file = file_,
                            .line = header_line_,
                            .column = column_in_line(column_begins_[column]),
                            .key = columns_[column],
                            .what = what,
                            .cure = cure});
}

void CsvTable::fail_at(std::size_t position, const std::string& what,
                       const std::string& cure) const {
  throw common::InputError({.file = file_,
                            .line = line_of(position),
                            .column = column_in_line(position),
                            .what = what,
                            .cure = cure});
}

// Only messages need these, so they may walk through the file.
int CsvTable::line_of(std::size_t position) const {
  const auto end = buffer_.begin() + static_cast<std::ptrdiff_t>(position);
  return 1 + static_cast<int>(std::count(buffer_.begin(), end, '\n'));
}

int CsvTable::column_in_line(std::size_t position) const {
  const std::size_t line_end =
      position == 0 ? std::string::npos : buffer_.rfind('\n', position - 1);
  std::size_t begin = line_end == std::string::npos ? 0 : line_end + 1;
  if (begin == 0 && buffer_.starts_with("\xef\xbb\xbf")) begin = 3;
  return static_cast<int>(position - begin) + 1;
}

CsvTable read_csv(const std::filesystem::path& file) { return {read_text(file), file}; }

std::string csv_cell(std::string_view text) {
  const std::string shown =
      (is_formula_behind_quotes(text) ? "'" : "") + common::printable(text, "\n");
  if (shown.find_first_of(",;\"#\n") == std::string::npos) return shown;
  std::string quoted = "\"";
  for (const char c : shown) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

std::string csv_comment(std::string_view text) {
  std::string line = "# ";
  const std::string shown = common::printable(text);
  for (std::string_view rest = shown; !rest.empty();) {
    const std::size_t end = std::min(rest.find_first_of(",;"), rest.size());
    const std::size_t begin = std::min(rest.find_first_not_of(' '), end);
    const std::string_view cell = rest.substr(begin, end - begin);
    line.append(rest.substr(0, begin));
    if (is_formula_behind_quotes(cell) && !is_number(cell.substr(0, cell.find(' ')))) line += '\'';
    line.append(rest.substr(begin, std::min(end + 1, rest.size()) - begin));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return line + "\n";
}

}  // namespace kinetostat::io

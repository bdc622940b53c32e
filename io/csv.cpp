#include "kinetostat/io/csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <sstream>

#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/printable.h"
#include "kinetostat/io/file_kind.h"
#include "kinetostat/io/largest_number.h"
#include "kinetostat/io/table/text_encoding.h"
#include "kinetostat/io/table/workbook.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::io {
namespace {

constexpr std::size_t most_columns = 10'000;

bool is_blank(char c) { return c == ' ' || c == '\t'; }

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

CsvTable::CsvTable(std::string content, std::filesystem::path file, TableFormat format,
                   common::Faults* faults)
    : file_(std::move(file)),
      buffer_(as_utf8(std::move(content), file_)),
      format_(std::move(format)),
      faults_(faults) {
  refuse_other_kinds(file_, buffer_, "a table (CSV)", "Save the table as .xlsx or 'CSV UTF-8'");
  if (buffer_.size() >= std::numeric_limits<std::uint32_t>::max())
    throw common::InputError(file_, "is larger than 4 GiB", "Split it into several campaigns");
  if (!next_line())
    throw common::InputError(file_, "holds no table",
                             "Give a header line with column names, then rows");
  layout_ = find_layout(buffer_);
  line_ = line_of(layout_.begin);
  position_ = layout_.begin;
  separator_ = layout_.separator;
  read_header();
  if (layout_.has_units && next_line()) read_units();
  while (next_line()) read_row();
  if (rows() == 0 && faults_ != nullptr) faults_->throw_if_any();
  if (rows() == 0)
    throw common::InputError({.file = file_,
                              .line = line_,
                              .what = "the table has a header but no row",
                              .cure = "Give one row a reading"});
  drop_columns_without_name();
  find_decimals();
}

void CsvTable::report(common::InputError::Details mistake) {
  if (faults_ == nullptr) throw common::InputError(std::move(mistake));
  faults_->add(std::move(mistake));
}

// Moves to the next line that is neither empty nor a comment; false at the end of the file.
bool CsvTable::next_line() {
  while (position_ < buffer_.size()) {
    std::size_t first = position_;
    while (first < buffer_.size() && (is_blank(buffer_[first]) || buffer_[first] == '\r')) ++first;
    const bool skipped = first == buffer_.size() || buffer_[first] == '\n' ||
                         is_comment(std::string_view(buffer_).substr(first, 10));
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
  std::vector<Cell> cells;
  read_cells(cells);
  header_cells_ = cells.size();
  if (cells.size() > most_columns)
    fail_at(cells.front().begin,
            fmt::format("the header names {} columns, of at most {}", cells.size(), most_columns),
            "Give one line a reading, not one column");
  while (cells.size() > 1 && cells.back().length == 0) cells.pop_back();
  for (const Cell& cell : cells) {
    std::string name(text(cell));
    std::replace(name.begin(), name.end(), '\n', ' ');
    std::erase(name, '\r');
    if (common::has_control_characters(name))
      fail_at(cell.begin, fmt::format("the column name '{}' has a control character", name),
              "Name every column in plain letters");
    if (!name.empty() && find(name))
      report({.file = file_,
              .line = line_of(cell.begin),
              .column = column_in_line(cell.begin),
              .what = fmt::format("two columns are named '{}'", name),
              .cure = "Give each column its own name"});
    column_begins_.push_back(cell.begin);
    columns_.push_back(name);
  }
}

// The line after the header: into the names that have no unit yet.
void CsvTable::read_units() {
  std::vector<Cell> cells;
  read_cells(cells);
  for (std::size_t i = 0; i < std::min(cells.size(), columns_.size()); ++i) {
    std::string_view unit = text(cells[i]);
    if (unit.starts_with('[') || unit.starts_with('(')) unit = unit.substr(1, unit.size() - 2);
    const bool has_one = columns_[i].ends_with(']') || columns_[i].ends_with(')');
    if (!unit.empty() && unit != "-" && unit != "1" && !has_one && !columns_[i].empty())
      columns_[i] += fmt::format(" [{}]", unit);
  }
}

// Whether the cells from `first` on are the names of the columns, without the units that a line of
// their own gives them.
bool CsvTable::repeats_header(std::size_t first) const {
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    const std::string_view name = text(cells_[first + c]);
    const bool same = columns_[c] == name ||
                      (layout_.has_units && columns_[c].starts_with(std::string(name) + " ["));
    if (name.empty() || !same) return false;
  }
  return true;
}

void CsvTable::read_row() {
  const std::size_t begin = position_, first = cells_.size();
  const int line = line_;
  read_cells(cells_);
  if (is_cut_) return cells_.resize(first);
  std::size_t count = cells_.size() - first;
  const bool all_empty =
      std::all_of(cells_.begin() + static_cast<std::ptrdiff_t>(first), cells_.end(),
                  [](const Cell& cell) { return cell.length == 0; });
  if (all_empty && count > 1) {  // spreadsheets append such rows
    cells_.resize(first);
    return;
  }
  while (count > columns_.size() && count <= header_cells_ && cells_.back().length == 0) {
    cells_.pop_back();
    --count;
  }
  if (count == columns_.size()) {
    if (!repeats_header(first)) return row_lines_.push_back(line);
    ++repeated_headers_;
    cells_.resize(first);
    return;
  }
  cells_.resize(first);
  report({.file = file_,
          .line = line,
          .key = count < columns_.size() ? columns_[count] : "",
          .what = fmt::format(
              "this row has {} {}, the header has {}: '{}'", count, count == 1 ? "cell" : "cells",
              columns_.size(),
              buffer_.substr(
                  begin, std::min<std::size_t>(60, buffer_.find_first_of("\r\n", begin) - begin))),
          .cure = "Give one cell for each column; leave a cell empty when nothing was measured, "
                  "and quote texts that hold a separator"});
}

// A column without a name and without content is no column.
void CsvTable::drop_columns_without_name() {
  std::vector<std::size_t> kept;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (!columns_[c].empty()) {
      kept.push_back(c);
      continue;
    }
    for (std::size_t row = 0; row < rows(); ++row)
      if (!empty(row, c)) {
        report({.file = file_,
                .line = header_line_,
                .column = column_in_line(column_begins_[c]),
                .what = fmt::format("column {} has no name", c + 1),
                .cure = "Name every column in the header line"});
        break;
      }
  }
  if (kept.size() == columns_.size()) return;
  std::vector<Cell> cells;
  cells.reserve(rows() * kept.size());
  for (std::size_t row = 0; row < rows(); ++row)
    for (const std::size_t c : kept) cells.push_back(cells_[row * columns_.size() + c]);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    columns_[i] = columns_[kept[i]];
    column_begins_[i] = column_begins_[kept[i]];
  }
  columns_.resize(kept.size());
  column_begins_.resize(kept.size());
  cells_ = std::move(cells);
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
    if (quote == std::string::npos) {
      report({.file = file_,
              .line = line_of(opening),
              .column = column_in_line(opening),
              .what = "the quote that starts here is not closed",
              .cure = "Close it, or write \"\" for a quote inside a quoted cell"});
      position_ = buffer_.size();
      is_cut_ = true;
      return {opening, 0, -1};
    }
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

std::vector<std::vector<std::string>> CsvTable::title() const {
  std::vector<std::vector<std::string>> lines;
  std::istringstream above(buffer_.substr(0, layout_.begin));
  for (std::string line; std::getline(above, line);) {
    std::vector<std::string> cells;
    std::istringstream parts(line);
    for (std::string part; std::getline(parts, part, separator_);) {
      const std::size_t first = part.find_first_not_of(" \t\r\"");
      if (first == std::string::npos) continue;
      cells.push_back(part.substr(first, part.find_last_not_of(" \t\r\"") + 1 - first));
    }
    lines.push_back(std::move(cells));
  }
  return lines;
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

bool CsvTable::missing(std::size_t row, std::size_t column) const {
  const std::string_view text = cell(row, column);
  if (text.empty()) return true;
  const auto among = [text](const std::vector<std::string>& words) {
    return std::find(words.begin(), words.end(), text) != words.end();
  };
  const bool has_digit = text.find_first_of("0123456789") != std::string_view::npos;
  return (!has_digit && among(usual_missing())) || among(format_.missing);
}

const std::vector<std::string>& usual_missing() {
  static const std::vector<std::string> words = {
      "-",   "--",  "---", "n/a", "N/A",  "n.a.", "N.A.", "na",   "NA",           "#N/A",
      "#NV", "nan", "NaN", "NAN", "null", "NULL", "None", "none", "\xe2\x80\x93", "\xe2\x80\x94"};
  return words;
}

// Plain CSV separated by commas has decimal points: nothing to find out without quotes.
void CsvTable::find_decimals() {
  decimals_.assign(columns_.size(), format_.decimal);
  if (format_.decimal != DecimalSign::unknown && !format_.is_sheet) return;
  const bool may_have_commas = separator_ != ',' || buffer_.find('"') != std::string::npos;
  if (!may_have_commas || buffer_.find(',') == std::string::npos) {
    decimals_.assign(columns_.size(), DecimalSign::point);
    return;
  }
  struct Seen {
    std::size_t points = 0, commas = 0;
    bool ambiguous = false;
  };
  std::vector<Seen> seen(columns_.size());
  bool points = false, commas = false;
  for (std::size_t row = 0; row < rows(); ++row)
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      const std::string_view number = cell(row, c);
      const DecimalSign sign = decimal_sign_of(number);
      seen[c].points += sign == DecimalSign::point;
      seen[c].commas += sign == DecimalSign::comma;
      points = points || sign == DecimalSign::point;
      commas = commas || sign == DecimalSign::comma;
      if (sign == DecimalSign::unknown && !seen[c].ambiguous)
        seen[c].ambiguous = is_ambiguous_number(number);
    }
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    // Numbers of a sheet have points; a column of texts may have commas.
    const bool texts = seen[c].points == 0 && seen[c].commas > 0;
    if (format_.is_sheet)
      decimals_[c] = texts ? DecimalSign::comma : DecimalSign::point;
    else if (seen[c].points > 0 || seen[c].commas > 0)
      decimals_[c] = seen[c].commas > seen[c].points ? DecimalSign::comma : DecimalSign::point;
    else if (!seen[c].ambiguous || points != commas)
      decimals_[c] = commas ? DecimalSign::comma : DecimalSign::point;
  }
}

// What a number that did not read might have been meant as.
std::string CsvTable::number_cure(std::size_t column, std::string_view text) const {
  if (text.starts_with('#'))
    return "A spreadsheet could not compute this: repair its formula, or leave the cell empty";
  if (is_ambiguous_number(text) && decimals_[column] == DecimalSign::unknown)
    return "Say 'decimal: comma' or 'decimal: point' in the campaign file";
  if (decimal_sign_of(text) != DecimalSign::unknown)
    return decimals_[column] == DecimalSign::comma
               ? "Write the decimals with a comma, as elsewhere in this column"
               : "Write the decimals with a point";
  const bool digits = text.find_first_of("0123456789") != std::string_view::npos;
  const bool letters = std::any_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z' && c != 'e') || (c >= 'A' && c <= 'Z' && c != 'E');
  });
  if (digits && letters) return "Write the number alone: units are stated once for the whole file";
  return "Write a number such as -12.5 or 3e-4";
}

double CsvTable::number(std::size_t row, std::size_t column) const {
  const std::string_view all = cell(row, column);
  if (all.empty()) fail(row, column, "the cell is empty", "Write a number");
  std::string_view digits = all.size() > 1 && all[0] == '+' ? all.substr(1) : all;
  const DecimalSign decimal = decimals_[column];
  const auto read = [&digits](double& value) {
    return std::from_chars(digits.data(), digits.data() + digits.size(), value);
  };
  double value = 0;
  auto [end, error] = read(value);
  std::optional<std::string> plain;
  const bool as_it_stands =
      decimal == DecimalSign::point || digits.find_first_of(".,") == std::string_view::npos;
  if (!as_it_stands || end != digits.data() + digits.size()) {
    const bool unclear = decimal == DecimalSign::unknown && is_ambiguous_number(all);
    if (!unclear) plain = plain_number(all, decimal);
    if (!plain)
      fail(row, column, fmt::format("'{}' is not a number", all), number_cure(column, all));
    digits = *plain;
    error = read(value).ec;
  }
  if (error == std::errc::invalid_argument)
    fail(row, column, fmt::format("'{}' is not a number", all), number_cure(column, all));
  if (!std::isfinite(value))
    fail(row, column, fmt::format("'{}' is not a finite number", all),
         "Leave the cell empty when nothing was measured");
  if (error == std::errc::result_out_of_range || std::abs(value) > largest_number)
    fail(row, column, fmt::format("'{}' is too large or too small to compute with", all),
         "Check the number and its unit");
  return value;
}

common::InputError::Details CsvTable::mistake(std::size_t row, std::size_t column,
                                              const std::string& what,
                                              const std::string& cure) const {
  const std::size_t first = cells_[row * columns_.size()].begin;
  const std::size_t position = cells_[row * columns_.size() + column].begin;
  const auto at = [this](std::size_t i) {
    return buffer_.begin() + static_cast<std::ptrdiff_t>(i);
  };
  return {.file = file_,
          .line = row_lines_[row] +
                  static_cast<int>(std::count(at(first), at(std::max(first, position)), '\n')),
          .column = column_in_line(position),
          .key = columns_[column],
          .what = what,
          .cure = cure};
}

common::InputError::Details CsvTable::column_mistake(std::size_t column, const std::string& what,
                                                     const std::string& cure) const {
  return {.file = file_,
          .line = header_line_,
          .column = column_in_line(column_begins_[column]),
          .key = columns_[column],
          .what = what,
          .cure = cure};
}

void CsvTable::fail(std::size_t row, std::size_t column, const std::string& what,
                    const std::string& cure) const {
  throw common::InputError(mistake(row, column, what, cure));
}

void CsvTable::fail_column(std::size_t column, const std::string& what,
                           const std::string& cure) const {
  throw common::InputError(column_mistake(column, what, cure));
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

// Letters from 1; of a sheet, cells.
int CsvTable::column_in_line(std::size_t position) const {
  const std::size_t line_end =
      position == 0 ? std::string::npos : buffer_.rfind('\n', position - 1);
  const std::size_t begin = line_end == std::string::npos ? 0 : line_end + 1;
  const std::string_view before(buffer_.data() + begin, position - begin);
  if (format_.is_sheet) return 1 + static_cast<int>(std::count(before.begin(), before.end(), '\t'));
  return 1 + static_cast<int>(std::count_if(before.begin(), before.end(), [](char c) {
           return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
         }));
}

CsvTable read_csv(const std::filesystem::path& file) { return {read_text(file), file}; }

std::string table_text(const std::filesystem::path& file, TableFormat& format) {
  std::string bytes = read_text(file);
  format.is_sheet = is_workbook(bytes);
  if (!format.is_sheet) return as_utf8(std::move(bytes), file);
  std::vector<Sheet> sheets = read_workbook(bytes, file);
  const std::size_t chosen = find_sheet(sheets, format.sheet, file);
  for (std::size_t i = 0; i < sheets.size(); ++i)
    if (i != chosen && holds_table(sheets[i])) format.other_sheets.push_back(sheets[i].name);
  format.sheet = sheets[chosen].name;
  return std::move(sheets[chosen].text);
}

CsvTable read_table(const std::filesystem::path& file, TableFormat format, common::Faults* faults) {
  std::string text = table_text(file, format);
  return {std::move(text), file, std::move(format), faults};
}

std::string csv_cell(std::string_view text) {
  std::string shown = (is_formula_behind_quotes(text) ? "'" : "") + common::printable(text, "\n");
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

// Tables of readings as people keep them: CSV files, every cell with its place for messages.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinetostat/common/faults.h"
#include "kinetostat/io/table/table_layout.h"
#include "kinetostat/io/table/table_numbers.h"

namespace kinetostat::io {

/// What a table does not say of itself.
struct TableFormat {
  DecimalSign decimal = DecimalSign::unknown;  // unknown: as the numbers show
  std::vector<std::string> missing = {};       // cells that hold no value, besides usual_missing()
  std::string sheet = {};                      // of a workbook; empty: the first with a table
  bool is_sheet = false;                       // the text is the sheet of a workbook
  std::vector<std::string> other_sheets = {};  // that hold tables as well
};

/// Words for "not measured": "-", "n/a", "NaN" and the like.
const std::vector<std::string>& usual_missing();

/// A CSV file (RFC 4180): one header line with the column names, then one line a row. Besides:
/// lines that start with '#', empty lines and a title block above the header are skipped
/// (find_layout), lines that repeat it below are skipped, a line of units after it goes into the
/// names ("fx [N]"), blanks around cells are dropped, UTF-16, Latin-1, a byte-order mark and CRLF
/// are accepted, ';' or tab separate where the header has no comma, and decimals may have a comma
/// where no cell contradicts. The table is one buffer with views into it, so 100,000 rows are read
/// in a fraction of a second.
class CsvTable {
 public:
  /// Throws InputError naming file, line and column when there is no header, a column has no name
  /// or the name of another, a row has more or fewer cells than the header, a quote is not closed,
  /// or there is no row. With `faults`, what can be skipped is added to them instead.
  CsvTable(std::string content, std::filesystem::path file, TableFormat format = {},
           common::Faults* faults = nullptr);

  const std::filesystem::path& file() const { return file_; }
  const TableFormat& format() const { return format_; }
  const std::vector<std::string>& columns() const { return columns_; }
  std::size_t rows() const { return row_lines_.size(); }
  std::optional<std::size_t> find(std::string_view column) const;
  /// Line of the column names, counted from 1.
  int header_line() const { return header_line_; }
  /// Throws InputError with the place of a column's name.
  [[noreturn]] void fail_column(std::size_t column, const std::string& what,
                                const std::string& cure) const;

  /// Line of the file on which a row starts, counted from 1.
  int line(std::size_t row) const { return row_lines_[row]; }
  std::string_view cell(std::size_t row, std::size_t column) const;
  bool empty(std::size_t row, std::size_t column) const { return cell(row, column).empty(); }
  /// Empty, or a word for "not measured".
  bool missing(std::size_t row, std::size_t column) const;
  /// Of the numbers of a column; unknown where they have neither point nor comma.
  DecimalSign decimal(std::size_t column) const { return decimals_[column]; }
  /// Lines below the header that repeat it, as loggers write them that start anew: skipped.
  std::size_t repeated_headers() const { return repeated_headers_; }
  /// Whether a title block was skipped.
  bool has_title() const { return layout_.has_title; }
  /// The cells above the header that hold something, line by line, without blanks and quotes around
  /// them.
  std::vector<std::vector<std::string>> title() const;
  /// A number with a decimal point, up to `largest_number`. Throws InputError for anything else.
  double number(std::size_t row, std::size_t column) const;

  /// Throws InputError with file, line, place in the line, column name and the cure.
  [[noreturn]] void fail(std::size_t row, std::size_t column, const std::string& what,
                         const std::string& cure = {}) const;
  /// What fail() throws.
  common::InputError::Details mistake(std::size_t row, std::size_t column, const std::string& what,
                                      const std::string& cure = {}) const;
  /// What fail_column() throws.
  common::InputError::Details column_mistake(std::size_t column, const std::string& what,
                                             const std::string& cure) const;

 private:
  struct Cell {
    std::size_t begin = 0;        // in the buffer
    std::uint32_t length = 0;     // there
    std::int32_t unescaped = -1;  // index of the text when quotes were doubled inside it
  };

  bool next_line();
  void read_header();
  void read_units();
  void read_row();
  bool repeats_header(std::size_t first) const;
  void drop_columns_without_name();
  void find_decimals();
  std::string number_cure(std::size_t column, std::string_view text) const;
  void report(common::InputError::Details mistake);
  void read_cells(std::vector<Cell>& cells);
  Cell read_quoted_cell();
  Cell read_plain_cell();
  std::string_view text(const Cell& cell) const;
  int column_in_line(std::size_t position) const;
  int line_of(std::size_t position) const;
  [[noreturn]] void fail_at(std::size_t position, const std::string& what,
                            const std::string& cure) const;

  std::filesystem::path file_;
  std::string buffer_;
  TableFormat format_;
  TableLayout layout_;
  common::Faults* faults_ = nullptr;
  char separator_ = ',';
  std::vector<std::string> columns_;
  std::vector<std::size_t> column_begins_;  // in the buffer
  std::size_t header_cells_ = 0;            // with those at its end that hold nothing
  std::vector<Cell> cells_;                 // row-major
  std::vector<int> row_lines_;
  std::deque<std::string> unescaped_;
  std::vector<DecimalSign> decimals_;  // of the columns

  int header_line_ = 1;
  std::size_t repeated_headers_ = 0;

  // Where reading stands.
  std::size_t position_ = 0;
  int line_ = 1;
  bool is_cut_ = false;  // by a quote that is not closed
};

CsvTable read_csv(const std::filesystem::path& file);

/// Text of a table for CsvTable: of a CSV file in UTF-8; of a workbook (.xlsx, .ods) the cells of
/// the sheet that `format` names, in tab-separated lines that have the numbers of its rows; what
/// was chosen goes into `format`. Throws InputError.
std::string table_text(const std::filesystem::path& file, TableFormat& format);
/// The table in a CSV file or a workbook.
CsvTable read_table(const std::filesystem::path& file, TableFormat format = {},
                    common::Faults* faults = nullptr);

/// A text as a cell must be written: in double quotes when it holds a separator, a quote or a line
/// end, with '?' for other control characters, and with a single quote before what a spreadsheet
/// would compute (=, +, - or @ at the start of what is no number), which CsvTable takes away again.
std::string csv_cell(std::string_view text);

/// A comment line, "# text" and a line end, that a spreadsheet finds no formula in either.
std::string csv_comment(std::string_view text);

}  // namespace kinetostat::io

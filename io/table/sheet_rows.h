// A sheet of a spreadsheet as text, and its cells while they are read.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace kinetostat::io {

struct Sheet {
  std::string name;
  std::string text;     // cells separated by tabs, one line a row, from the first row on
  bool is_cut = false;  // it has more cells than SheetRows takes
};

class SheetRows {
 public:
  static constexpr std::size_t most_rows = std::size_t{1} << 20, most_columns = 1 << 14;
  static constexpr std::size_t most_cells = 20'000'000;

  /// Cells of row and column, from 0; what lies beyond the limits of spreadsheets is left out.
  void put(std::size_t row, std::size_t column, std::string text);
  /// It has had most_cells, and takes no more.
  bool is_full() const { return count_ >= most_cells; }
  /// Lines of cells between tabs; texts that hold quotes or start with '#' are quoted.
  std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;
  std::size_t count_ = 0;
};

}  // namespace kinetostat::io

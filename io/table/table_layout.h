// Where the table starts in a text that may have a title block above it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace kinetostat::io {

struct TableLayout {
  std::size_t begin = 0;   // of the header line in the text [bytes]
  char separator = ',';    // of cells
  bool has_units = false;  // the line after the header gives a unit for each column
  bool has_title = false;  // lines above the header that are neither empty nor comments
};

/// The header is the first line that is neither empty nor a comment ('#') where names without gaps
/// or repetitions stand there and the lines below have as many cells; ';' or a tab separates where
/// it has no comma. Otherwise it is the line, of the first 200, with the most names above rows with
/// numbers that have no more cells than it, for the separator that gives most. Where there is none,
/// the first line again.
TableLayout find_layout(std::string_view text);

/// Whether a line (without the blanks before it) is a comment: it starts with '#', and not with an
/// error of a spreadsheet, "#DIV/0!".
bool is_comment(std::string_view line);

/// "0.5", "-1,5e-3", "1.234,5", "12:30:01", "2026-05-03": what a table has in its rows, not in its
/// header.
bool looks_like_value(std::string_view cell);

}  // namespace kinetostat::io

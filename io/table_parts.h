// Tables of numbered rows that several runs make, each a part of them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace kinetostat::io {

/// The i-th of n parts: every n-th row from the i-th on.
struct Part {
  std::size_t number = 1, count = 1;

  bool has(std::size_t row) const { return row % count == number - 1; }
  bool is_whole() const { return count == 1; }
};

/// A table, or what there is of it.
struct NumberedTable {
  std::string title;   // "# map HASH of N poses": parts of another table have another one
  std::string header;  // names of columns, that of the number first
  std::map<std::size_t, std::string> lines = {};  // by number, which they start with; ended lines

  /// The number of rows that the title names.
  std::size_t rows() const;
  std::string text() const;
};

/// `kind` is "map", `rows` how many `what` ("poses") the whole has, `meaning` all that decides what
/// is in it.
std::string title_of_table(const std::string& kind, const std::string& meaning, std::size_t rows,
                           const std::string& what);

/// Throws InputError for a file that is none of these.
NumberedTable read_numbered_table(const std::filesystem::path& file);

/// A whole table of the rows of its parts.
struct JoinedTable {
  std::string title, header;            // those of the parts
  std::vector<std::string> parts;       // contents of their files
  std::vector<std::string_view> lines;  // by number, which they start with, in `parts`

  std::string text() const;
  /// Without title and numbers.
  std::string plain_text() const;
};

/// Parts in any order; of a row that is in several, the first. Throws InputError where one is of
/// another table, or a row is in none.
JoinedTable join_tables(const std::vector<std::string>& files);

}  // namespace kinetostat::io

#include "kinetostat/io/table_parts.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/io/csv.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::io {
namespace {

std::string_view without_number(std::string_view line) { return line.substr(line.find(',') + 1); }

std::size_t rows_in(std::string_view title) {
  const std::size_t at = title.rfind(" of ");
  std::size_t rows = 0;
  if (at != std::string_view::npos)
    (void)std::from_chars(title.data() + at + 4, title.data() + title.size(), rows);
  return rows;
}

// A file of a part, line by line with their ends.
struct PartLines {
  std::string_view rest;

  std::string_view next() {
    const std::string_view line = rest.substr(0, rest.find('\n') + 1);
    rest.remove_prefix(line.size());
    return line;
  }
};

const char* const made_again = "The file is damaged: make this part again";

// The text of a file. Throws InputError where it is no part, or a part that is cut off.
std::string read_part(const std::filesystem::path& file) {
  std::string text = read_text(file);
  std::erase(text, '\r');  // of an editor
  PartLines lines{text};
  const std::string_view title = lines.next(), header = lines.next();
  if (!title.starts_with("# ") || rows_in(title) == 0 || header.find(',') == std::string_view::npos)
    throw common::InputError(file, "this is no table that was written with --part",
                             "Name what 'sweep' or 'map' wrote with --part i/n -o FILE");
  if (!text.ends_with('\n')) throw common::InputError(file, "its last line has no end", made_again);
  return text;
}

// The number of a line. Throws InputError where it has none of the table's.
std::size_t number_of(std::string_view line, std::size_t rows, const std::filesystem::path& file) {
  std::size_t number = 0;
  const char* const end = line.data() + line.size();
  const auto [at, error] = std::from_chars(line.data(), end, number);
  if (error != std::errc() || at == end || *at != ',' || number >= rows) {
    const std::string_view start =
        line.substr(0, std::min<std::size_t>(line.find_first_of(",\n"), 20));
    throw common::InputError(
        file, fmt::format("'{}' is none of its rows, 0 to {}", start, rows - 1), made_again);
  }
  return number;
}

// How many cells a line has: separators in quotes are none.
std::size_t cells_in(std::string_view line) {
  std::size_t cells = 1;
  bool is_quoted = false;
  for (const char c : line) {
    if (c == '"') is_quoted = !is_quoted;
    if (c == ',' && !is_quoted) ++cells;
  }
  return cells;
}

// All lines have as many cells as the first one; a header may name several by one word.
class CellCount {
 public:
  void require(std::string_view line, std::size_t number, const std::filesystem::path& file) {
    const std::size_t has = cells_in(line);
    if (cells_ == 0) cells_ = has;
    if (has != cells_)
      throw common::InputError(
          file, fmt::format("row {} has {} cells, those before have {}", number, has, cells_),
          made_again);
  }

 private:
  std::size_t cells_ = 0;
};

std::size_t size_of(const std::vector<std::string>& texts) {
  std::size_t size = 0;
  for (const std::string& text : texts) size += text.size();
  return size;
}

}  // namespace

std::size_t NumberedTable::rows() const { return rows_in(title); }

std::string NumberedTable::text() const {
  std::string whole = title + header;
  for (const auto& [number, line] : lines) whole += line;
  return whole;
}

std::string title_of_table(const std::string& kind, const std::string& meaning, std::size_t rows,
                           const std::string& what) {
  return csv_comment(
      fmt::format("{} {} of {} {}", kind, sha256(meaning).substr(0, 16), rows, what));
}

NumberedTable read_numbered_table(const std::filesystem::path& file) {
  const std::string text = read_part(file);
  PartLines lines{text};
  NumberedTable table{.title = std::string(lines.next()), .header = std::string(lines.next())};
  CellCount cells;
  while (!lines.rest.empty()) {
    const std::string_view line = lines.next();
    const std::size_t number = number_of(line, table.rows(), file);
    cells.require(line, number, file);
    table.lines[number] = line;
  }
  return table;
}

std::string JoinedTable::text() const {
  std::string whole = title + header;
  whole.reserve(size_of(parts));
  for (const std::string_view line : lines) whole += line;
  return whole;
}

std::string JoinedTable::plain_text() const {
  std::string plain(without_number(header));
  plain.reserve(size_of(parts));
  for (const std::string_view line : lines) plain += without_number(line);
  return plain;
}

JoinedTable join_tables(const std::vector<std::string>& files) {
  JoinedTable all;
  all.parts.resize(files.size());
  std::transform(files.begin(), files.end(), all.parts.begin(), read_part);
  PartLines first{all.parts.front()};
  all.title = first.next();
  all.header = first.next();
  const std::size_t rows = rows_in(all.title);
  CellCount cells;
  if (rows > size_of(all.parts))
    throw common::InputError(files.front(),
                             fmt::format("there are far fewer rows than its {}", rows),
                             "Name all parts: those of --part 1/n to n/n");
  all.lines.resize(rows);
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::string& file = files[i];
    PartLines lines{all.parts[i]};
    const std::string_view title = lines.next(), header = lines.next();
    if (title != all.title || header != all.header)
      throw common::InputError(file, "this is a part of another table",
                               fmt::format("Join only what {} belongs to", files.front()));
    while (!lines.rest.empty()) {
      const std::string_view line = lines.next();
      const std::size_t number = number_of(line, rows, file);
      cells.require(line, number, file);
      std::string_view& place = all.lines[number];
      if (place.empty()) place = line;
      if (place != line)
        throw common::InputError(file,
                                 fmt::format("row {} is not what another of the files has", number),
                                 "Join parts of one run: the same program, command and inputs");
    }
  }
  const auto missing = std::find(all.lines.begin(), all.lines.end(), std::string_view());
  if (missing != all.lines.end())
    throw common::InputError(
        files.front(),
        fmt::format("row {} of {} is in none of the files", missing - all.lines.begin(), rows),
        "Name all parts: those of --part 1/n to n/n");
  return all;
}

}  // namespace kinetostat::io

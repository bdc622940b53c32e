#include "kinetostat/io/table_parts.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/io/csv.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::io {
namespace {

std::size_t number_at(const std::string& text, std::size_t at) {
  std::size_t number = 0;
  if (at < text.size()) (void)std::from_chars(text.data() + at, text.data() + text.size(), number);
  return number;
}

std::string without_number(const std::string& line) { return line.substr(line.find(',') + 1); }

}  // namespace

std::size_t NumberedTable::rows() const {
  const std::size_t at = title.rfind(" of ");
  return at == std::string::npos ? 0 : number_at(title, at + 4);
}

std::string NumberedTable::text() const {
  std::string whole = title + header;
  for (const auto& [number, line] : lines) whole += line;
  return whole;
}

std::string NumberedTable::plain_text() const {
  std::string plain = without_number(header);
  for (const auto& [number, line] : lines) plain += without_number(line);
  return plain;
}

std::string title_of_table(const std::string& kind, const std::string& meaning, std::size_t rows,
                           const std::string& what) {
  return csv_comment(
      fmt::format("{} {} of {} {}", kind, sha256(meaning).substr(0, 16), rows, what));
}

NumberedTable read_numbered_table(const std::filesystem::path& file) {
  const std::string text = read_text(file);
  std::size_t at = 0;
  const auto next = [&] {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string line = text.substr(at, end - at) + "\n";
    at = end + 1;
    return line;
  };
  NumberedTable table{.title = next(), .header = next()};
  if (!table.title.starts_with("# ") || table.rows() == 0 ||
      table.header.find(',') == std::string::npos)
    throw common::InputError(file, "this is no table that was written with --part",
                             "Name what 'sweep' or 'map' wrote with --part i/n -o FILE");
  while (at < text.size()) {
    std::string line = next();
    table.lines[number_at(line, 0)] = std::move(line);
  }
  return table;
}

NumberedTable join_tables(const std::vector<std::string>& files) {
  NumberedTable all = read_numbered_table(files.front());
  for (const std::string& file : files) {
    NumberedTable part = read_numbered_table(file);
    if (part.title != all.title || part.header != all.header)
      throw common::InputError(file, "this is a part of another table",
                               fmt::format("Join only what {} belongs to", files.front()));
    all.lines.merge(part.lines);
  }
  for (std::size_t r = 0; r < all.rows(); ++r)
    if (!all.lines.contains(r))
      throw common::InputError(files.front(),
                               fmt::format("row {} of {} is in none of the files", r, all.rows()),
                               "Name all parts: those of --part 1/n to n/n");
  return all;
}

}  // namespace kinetostat::io

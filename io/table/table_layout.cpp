#include "kinetostat/io/table/table_layout.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <set>
#include <stdexcept>

#include "kinetostat/spatial/units.h"

namespace kinetostat::io {
namespace {

constexpr std::size_t most_lines = 200, rows_judged = 30;

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

struct Line {
  std::size_t begin = 0;
  std::string_view text;
};

// A cell of a header may run over some lines in quotes.
std::size_t end_of_line(std::string_view text, std::size_t begin) {
  constexpr int most_lines_of_one = 6;
  const std::size_t first = std::min(text.find('\n', begin), text.size());
  std::size_t end = first;
  for (int lines = 0; lines < most_lines_of_one; ++lines) {
    const auto from = text.begin() + static_cast<std::ptrdiff_t>(begin);
    if (std::count(from, text.begin() + static_cast<std::ptrdiff_t>(end), '"') % 2 == 0) return end;
    if (end == text.size()) break;
    end = std::min(text.find('\n', end + 1), text.size());
  }
  return first;
}

// The first lines that are neither empty nor comments.
std::vector<Line> first_lines(std::string_view text) {
  std::vector<Line> lines;
  for (std::size_t at = 0; at < text.size() && lines.size() < most_lines;) {
    const std::size_t end = end_of_line(text, at);
    const std::string_view line = text.substr(at, end - at), content = trimmed(line);
    if (!content.empty() && !is_comment(content)) lines.push_back({at, line});
    at = end + 1;
  }
  return lines;
}

// Of one line; quotes keep separators together and are taken off.
std::vector<std::string_view> cells_of(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  bool quoted = false;
  for (std::size_t i = 0, begin = 0; i <= line.size(); ++i) {
    if (i < line.size() && line[i] == '"') quoted = !quoted;
    if (i < line.size() && (quoted || line[i] != separator)) continue;
    std::string_view cell = trimmed(line.substr(begin, i - begin));
    if (cell.size() > 1 && cell.front() == '"' && cell.back() == '"')
      cell = trimmed(cell.substr(1, cell.size() - 2));
    cells.push_back(cell);
    begin = i + 1;
  }
  return cells;
}

// Up to the last cell that is not empty.
std::size_t extent_of(const std::vector<std::string_view>& cells) {
  std::size_t extent = cells.size();
  while (extent > 0 && cells[extent - 1].empty()) --extent;
  return extent;
}

bool has_value(const std::vector<std::string_view>& cells) {
  return std::any_of(cells.begin(), cells.end(), looks_like_value);
}

bool is_unit(std::string_view cell) {
  if (cell.size() > 2 &&
      ((cell.front() == '[' && cell.back() == ']') || (cell.front() == '(' && cell.back() == ')')))
    cell = trimmed(cell.substr(1, cell.size() - 2));
  if (cell == "-") return true;
  const bool letters = std::any_of(cell.begin(), cell.end(), [](unsigned char c) {
    return std::isalpha(c) != 0 || c >= 0x80 || c == '%';
  });
  if (!letters) return false;  // numbers
  try {
    spatial::parse_unit(cell);
    return true;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

// "[N];[um];;": units, and nothing else.
bool is_line_of_units(const std::vector<std::string_view>& cells) {
  const auto given = std::count_if(cells.begin(), cells.end(),
                                   [](std::string_view cell) { return !cell.empty(); });
  return given >= 2 && std::all_of(cells.begin(), cells.end(), [](std::string_view cell) {
           return cell.empty() || is_unit(cell);
         });
}

// The separator where the first line is the header.
char separator_of_first(std::string_view line) {
  char separator = ',';
  for (const char candidate : {'\t', ';', ','})
    if (line.find(candidate) != std::string_view::npos) separator = candidate;
  return separator;
}

std::optional<TableLayout> first_line_as_header(const std::vector<Line>& lines) {
  TableLayout layout{.begin = lines[0].begin, .separator = separator_of_first(lines[0].text)};
  const auto names = cells_of(lines[0].text, layout.separator);
  const std::set<std::string_view> different(names.begin(), names.end());
  if (different.size() != names.size() || different.count("") > 0) return std::nullopt;
  std::size_t first = 1;
  if (lines.size() > 1 && is_line_of_units(cells_of(lines[1].text, layout.separator))) {
    layout.has_units = true;
    first = 2;
  }
  for (std::size_t i = first; i < std::min(lines.size(), rows_judged); ++i) {
    const auto cells = cells_of(lines[i].text, layout.separator);
    if (cells.size() != names.size() && extent_of(cells) > 0) return std::nullopt;
    if (i == first && !has_value(cells)) return std::nullopt;
  }
  return layout;
}

// How many names the line has where it may be a header; 0 where not.
std::size_t names_in(const std::vector<Line>& lines, std::size_t i, TableLayout& layout) {
  const auto names = cells_of(lines[i].text, layout.separator);
  const std::size_t extent = extent_of(names);
  const auto given = static_cast<std::size_t>(std::count_if(
      names.begin(), names.end(), [](std::string_view name) { return !name.empty(); }));
  if (given < 2 || 2 * given <= extent || has_value(names)) return 0;
  std::size_t first = i + 1;
  if (first < lines.size()) {
    layout.has_units = is_line_of_units(cells_of(lines[first].text, layout.separator));
    first += layout.has_units;
  }
  if (first >= lines.size() || !has_value(cells_of(lines[first].text, layout.separator))) return 0;
  std::size_t fitting = 0, judged = 0;
  for (std::size_t row = first; row < std::min(lines.size(), first + rows_judged);
       ++row, ++judged) {
    const auto cells = cells_of(lines[row].text, layout.separator);
    fitting += extent_of(cells) <= extent && 2 * cells.size() > extent;
  }
  return 2 * fitting > judged ? given : 0;
}

}  // namespace

bool is_comment(std::string_view line) {
  if (!line.starts_with('#')) return false;
  // In English, German, French, Spanish and Italian.
  constexpr std::array<std::string_view, 14> errors = {
      "#DIV/0!", "#N/A",  "#NAME?", "#NULL!", "#NUM!",    "#REF!",   "#VALUE!",
      "#NV",     "#WERT", "#BEZUG", "#ZAHL!", "#VALEUR!", "#VALOR!", "#VALORE!"};
  return std::none_of(errors.begin(), errors.end(),
                      [line](std::string_view error) { return line.starts_with(error); });
}

bool looks_like_value(std::string_view cell) {
  if (cell.empty()) return false;
  bool digit = false;
  for (const char c : cell) {
    digit = digit || (c >= '0' && c <= '9');
    if (std::string_view("0123456789+-.,:eETZ' ").find(c) == std::string_view::npos) {
      // The minus sign and the hard blanks that word processors write.
      if (static_cast<unsigned char>(c) < 0x80) return false;
    }
  }
  return digit && (std::string_view("0123456789+-.,").find(cell[0]) != std::string_view::npos ||
                   cell.starts_with("\xe2\x88\x92"));
}

TableLayout find_layout(std::string_view text) {
  const std::vector<Line> lines = first_lines(text);
  if (lines.empty()) return {};
  if (const auto layout = first_line_as_header(lines)) return *layout;
  TableLayout best{.begin = lines[0].begin, .separator = separator_of_first(lines[0].text)};
  std::size_t most = 0;
  for (const char separator : {'\t', ';', ','})
    for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
      TableLayout layout{.begin = lines[i].begin, .separator = separator, .has_title = i > 0};
      const std::size_t names = names_in(lines, i, layout);
      if (names <= most) continue;
      most = names;
      best = layout;
    }
  return best;
}

}  // namespace kinetostat::io

#include "kinetostat/common/faults.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>
#include <sstream>
#include <tuple>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/printable.h"

namespace kinetostat::common {
namespace {

using Details = InputError::Details;

constexpr std::size_t most_lines = 4, widest = 44, longest = 260;
// Of one screen, of which a program has one line before and one after.
constexpr std::size_t lines_of_screen = 23, columns_of_screen = 100;

// Of a mistake without what stands between quotes: the same in other rows.
std::string kind_of(const Details& mistake) {
  std::string kind;
  bool quoted = false;
  for (const char c : mistake.what) {
    if (c == '\'') quoted = !quoted;
    if (!quoted) kind += c;
  }
  return kind;
}

std::string cut(std::string text) {
  if (text.size() <= longest) return text;
  std::size_t end = longest;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return text.substr(0, end) + " ...";
}

std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](unsigned char c) { return (c & 0xC0) != 0x80; }));
}

// Mistakes of one kind in one column, which one line of the report holds.
using Group = std::vector<Details>;

std::vector<Group> grouped(const std::vector<Details>& mistakes) {
  std::vector<Group> groups;
  std::map<std::tuple<std::string, std::string, std::string>, std::size_t> place_of;
  for (const Details& mistake : mistakes) {
    const auto [found, fresh] =
        place_of.emplace(std::tuple(mistake.key, kind_of(mistake), mistake.cure), groups.size());
    if (fresh) groups.emplace_back();
    groups[found->second].push_back(mistake);
  }
  return groups;
}

// In a file other than the first one's, its name comes before.
std::string place_of(const Details& mistake, const std::filesystem::path& file) {
  std::string place = mistake.file == file ? "" : printable(mistake.file.filename().string()) + " ";
  if (mistake.line == 0) return place.empty() ? "the file" : place;
  place += fmt::format("line {}", mistake.line);
  return mistake.column == 0 ? place : fmt::format("{}:{}", place, mistake.column);
}

std::string what_of(const Group& group) {
  const Details& first = group.front();
  // Most messages quote the value; the column goes before it, unless it is named already.
  const bool named = first.key.empty() || first.what.find(first.key) != std::string::npos;
  std::string text = named ? first.what : first.key + ": " + first.what;
  std::vector<int> others;
  for (const Details& mistake : group)
    if (mistake.line != first.line && (others.empty() || others.back() != mistake.line))
      others.push_back(mistake.line);
  if (others.empty()) return text;
  const std::size_t shown = std::min(others.size(), most_lines);
  const std::vector<int> some(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(shown));
  text +=
      fmt::format(" (and on line{} {}{})", others.size() == 1 ? "" : "s", fmt::join(some, ", "),
                  others.size() > shown ? fmt::format(" and {} more", others.size() - shown) : "");
  return text;
}

// On a screen, whose terminal breaks what is longer.
std::size_t lines_of(const std::string& text) {
  std::size_t lines = 0;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);)
    lines += std::max<std::size_t>(1, (width_of(line) + columns_of_screen - 1) / columns_of_screen);
  return lines;
}

// Place, what is wrong and what would work; the last in a line of its own where it is far right.
std::string row_of(const Group& group, const std::filesystem::path& file, std::size_t place_width,
                   std::size_t what_width) {
  const Details& first = group.front();
  const std::string what = cut(printable(what_of(group)));
  std::string row = fmt::format("  {:<{}}  {}", place_of(first, file), place_width, what);
  if (first.cure.empty()) return row;
  const std::size_t width = width_of(what);
  row += width <= what_width ? std::string(what_width - width + 2, ' ')
                             : "\n" + std::string(place_width + 6, ' ');
  return row + cut(printable(first.cure));
}

std::string table(const std::vector<Details>& mistakes, std::size_t most) {
  const std::vector<Group> groups = grouped(mistakes);
  const std::filesystem::path& file = mistakes.front().file;
  std::string text =
      fmt::format("{}: {} thing{} to repair before anything can be computed",
                  printable(file.string()), groups.size(), groups.size() == 1 ? "" : "s");
  std::size_t place_width = 0, what_width = 0;
  for (const Group& group : groups) {
    place_width = std::max(place_width, place_of(group.front(), file).size());
    const std::size_t width = width_of(what_of(group));
    if (width <= widest) what_width = std::max(what_width, width);
  }
  std::size_t lines = 1, shown = 0;
  for (const Group& group : groups) {
    const std::string row = row_of(group, file, place_width, what_width);
    lines += lines_of(row);
    if (lines + (shown + 1 < groups.size() ? 1 : 0) > most) break;
    text += "\n" + row;
    ++shown;
  }
  if (shown < groups.size()) text += fmt::format("\n  and {} more", groups.size() - shown);
  return text;
}

}  // namespace

InputErrors::InputErrors(std::vector<Details> mistakes)
    : InputError(mistakes.front()),
      mistakes_(std::move(mistakes)),
      text_(table(mistakes_, lines_of_screen)) {}

std::string InputErrors::all() const {
  return table(mistakes_, std::numeric_limits<std::size_t>::max());
}

void Faults::add(const InputError& error) {
  if (const auto* several = dynamic_cast<const InputErrors*>(&error))
    mistakes_.insert(mistakes_.end(), several->mistakes().begin(), several->mistakes().end());
  else
    mistakes_.push_back(error.details());
}

std::vector<Details> Faults::mistakes() const {
  std::vector<Details> sorted = mistakes_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Details& a, const Details& b) {
    return std::tuple(a.line, a.column) < std::tuple(b.line, b.column);
  });
  const auto same = [](const Details& a, const Details& b) {
    return a.file == b.file &&
           std::tie(a.line, a.column, a.key, a.what) == std::tie(b.line, b.column, b.key, b.what);
  };
  sorted.erase(std::unique(sorted.begin(), sorted.end(), same), sorted.end());
  return sorted;
}

void Faults::throw_if_any() const {
  if (mistakes_.empty()) return;
  std::vector<Details> all = mistakes();
  if (all.size() == 1) throw InputError(all.front());
  throw InputErrors(std::move(all));
}

}  // namespace kinetostat::common

#include "kinetostat/report/screen/readings.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/report/screen/wording.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

using calibration::ColumnOverview;

constexpr std::size_t widest = 34, most_columns = 12;

std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](unsigned char c) { return (c & 0xC0) != 0x80; }));
}

std::string cut(std::string text) {
  if (width_of(text) <= widest) return text;
  std::size_t end = 0, letters = 0;
  while (letters < widest - 3)
    if ((static_cast<unsigned char>(text[++end]) & 0xC0) != 0x80) ++letters;
  return text.substr(0, end) + "...";
}

std::string values_of(const ColumnOverview& column) {
  if (column.values == 0) return "none";
  if (column.different > 0) {
    const std::string words =
        column.different == 1 ? column.first : fmt::format("{} ... {}", column.first, column.last);
    return column.range ? fmt::format("{} and numbers", words) : words;
  }
  const auto [least, most] = *column.range;
  return least == most ? fmt::format("{}", least) : fmt::format("{:.6g} to {:.6g}", least, most);
}

const std::vector<std::string> heads = {"column", "understood as", "unit", "values", "missing"};

std::vector<std::string> row_of(const ColumnOverview& column) {
  return {cut(column.header), (column.negative ? "minus " : "") + column.words, column.unit,
          cut(values_of(column)), column.missing > 0 ? std::to_string(column.missing) : ""};
}

// Nobody needs to look at a column that is called what it means.
bool is_plain(const ColumnOverview& column) {
  return column.missing == 0 && !column.negative && column.header == column.meaning &&
         column.unit != "?";
}

// What there are too many of for one screen is named in a line, as far as it says itself what it
// is.
std::string gathered_text(const calibration::ReadingsOverview& overview) {
  const bool gathers = overview.columns.size() > most_columns;
  Table table(heads);
  std::vector<std::string> plain;
  for (const ColumnOverview& column : overview.columns)
    if (gathers && is_plain(column))
      plain.push_back(column.header);
    else
      table.add_row(row_of(column));
  if (plain.empty()) return table.text();
  return (plain.size() < overview.columns.size() ? table.text() + "\n" : "") +
         wrapped("What their names say: " + listed(plain) + ".", 2, 2);
}

}  // namespace

std::string table_text(const calibration::ReadingsOverview& overview) {
  Table table(heads);
  for (const ColumnOverview& column : overview.columns) table.add_row(row_of(column));
  return table.text();
}

std::string readings_text(const calibration::ReadingsOverview& overview) {
  const std::size_t used = static_cast<std::size_t>(
      std::count_if(overview.columns.begin(), overview.columns.end(),
                    [](const ColumnOverview& c) { return !c.meaning.empty(); }));
  std::string text = fmt::format("{}: {} reading{}; {} of {} columns are used\n\n",
                                 overview.table.filename().string(), overview.rows,
                                 overview.rows == 1 ? "" : "s", used, overview.columns.size());
  text += gathered_text(overview);
  bool first = true;
  const auto say = [&text, &first](const std::string& sentence) {
    text += (first ? "\n" : "") + wrapped(sentence);
    first = false;
  };
  for (const ColumnOverview& column : overview.columns)
    if (!column.meant.empty())
      say(fmt::format("Not used: '{}'. If it is a reading, --column \"{}={}\".", column.header,
                      column.header, column.meant));
  for (const calibration::ProposedSensor& sensor : overview.sensors)
    say(
        fmt::format("'{}' may be a sensor ({}) elsewhere than at the platform: the campaign file "
                    "that -o writes proposes 'sensors:'.",
                    fmt::join(sensor.columns, "', '"), sensor.kind));
  // What the table above shows already.
  for (const std::string& note : overview.notes)
    if (!note.starts_with("Columns ") && note.find("is kept as a covariate, not") == note.npos)
      say(note);
  return text;
}

}  // namespace kinetostat::report

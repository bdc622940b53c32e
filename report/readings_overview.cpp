#include "kinetostat/report/readings_overview.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

using calibration::ColumnOverview;

constexpr std::size_t widest = 34;

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

std::string table_text(const calibration::ReadingsOverview& overview) {
  Table table({"column", "understood as", "unit", "values", "missing"});
  for (const ColumnOverview& column : overview.columns)
    table.add_row({cut(column.header), (column.negative ? "minus " : "") + column.words,
                   column.unit, cut(values_of(column)),
                   column.missing > 0 ? std::to_string(column.missing) : ""});
  return table.text();
}

}  // namespace

std::string readings_text(const calibration::ReadingsOverview& overview) {
  const std::size_t used = static_cast<std::size_t>(
      std::count_if(overview.columns.begin(), overview.columns.end(),
                    [](const ColumnOverview& c) { return !c.meaning.empty(); }));
  std::string text = fmt::format("{}: {} reading{}; {} of {} columns are used\n\n",
                                 overview.table.filename().string(), overview.rows,
                                 overview.rows == 1 ? "" : "s", used, overview.columns.size());
  text += table_text(overview);
  bool first = true;
  const auto say = [&text, &first](const std::string& sentence) {
    text += (first ? "\n" : "") + sentence + "\n";
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

io::Json readings_json(const calibration::ReadingsOverview& overview) {
  io::Json json{{"readings", overview.table.filename().string()},
                {"rows", overview.rows},
                {"header_line", overview.header_line}};
  json["columns"] = io::Json::array();
  for (const ColumnOverview& column : overview.columns) {
    io::Json item{{"column", column.header},
                  {"meaning", column.meaning.empty() ? "covariate" : column.meaning},
                  {"unit", column.unit},
                  {"negative", column.negative},
                  {"values", column.values},
                  {"missing", column.missing}};
    if (column.range) item["range"] = {(*column.range)[0], (*column.range)[1]};
    if (!column.meant.empty()) item["looks_like"] = column.meant;
    json["columns"].push_back(item);
  }
  for (const calibration::ProposedSensor& sensor : overview.sensors)
    json["proposed_sensors"].push_back(
        {{"name", sensor.name}, {"kind", sensor.kind}, {"columns", sensor.columns}});
  json["notes"] = overview.notes;
  json["mistakes"] = io::Json::array();
  for (const common::InputError::Details& mistake : overview.mistakes)
    json["mistakes"].push_back({{"line", mistake.line},
                                {"column", mistake.column},
                                {"key", mistake.key},
                                {"what", mistake.what},
                                {"cure", mistake.cure}});
  return json;
}

}  // namespace kinetostat::report

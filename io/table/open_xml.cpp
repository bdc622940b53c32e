#include "kinetostat/io/table/open_xml.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/io/table/sheet_rows.h"
#include "kinetostat/io/table/xml_scanner.h"

namespace kinetostat::io {
namespace {

std::size_t whole_number(const std::optional<std::string>& text) {
  std::size_t value = 0;
  if (text) std::from_chars(text->data(), text->data() + text->size(), value);
  return value;
}

// Names of files by their keys ("rId1"), from the root of the archive.
std::map<std::string, std::string> read_targets(const ZipArchive& archive) {
  std::map<std::string, std::string> targets;
  const std::string xml = archive.read("xl/_rels/workbook.xml.rels");
  for (XmlScanner tags(xml); tags.next();)
    if (tags.name() == "Relationship") {
      const std::string target = tags.attribute("Target").value_or("");
      targets[tags.attribute("Id").value_or("")] =
          target.starts_with('/') ? target.substr(1) : "xl/" + target;
    }
  return targets;
}

// Texts that cells refer to by number. Phonetic hints are no part of them.
std::vector<std::string> read_shared_strings(const ZipArchive& archive) {
  std::vector<std::string> strings;
  if (!archive.has("xl/sharedStrings.xml")) return strings;
  const std::string xml = archive.read("xl/sharedStrings.xml");
  bool phonetic = false;
  for (XmlScanner tags(xml); tags.next();) {
    if (tags.name() == "si" && tags.opens()) strings.emplace_back();
    if (tags.name() == "rPh") phonetic = tags.opens() && !tags.closes();
    if (tags.name() == "t" && tags.closes() && !tags.opens() && !phonetic && !strings.empty())
      strings.back() += tags.text();
  }
  return strings;
}

// ECMA-376, 18.8.30: formats that have a number and no text.
bool is_built_in_time(std::size_t format) {
  return (format >= 14 && format <= 22) || (format >= 27 && format <= 36) ||
         (format >= 45 && format <= 47) || (format >= 50 && format <= 58);
}

// The cell formats that show dates or times.
std::set<std::size_t> read_time_formats(const ZipArchive& archive) {
  std::set<std::size_t> result;
  if (!archive.has("xl/styles.xml")) return result;
  const std::string xml = archive.read("xl/styles.xml");
  std::map<std::size_t, bool> stated;
  bool in_cell_formats = false;
  std::size_t count = 0;
  for (XmlScanner tags(xml); tags.next();) {
    if (tags.name() == "numFmt")
      stated[whole_number(tags.attribute("numFmtId"))] =
          shows_time(tags.attribute("formatCode").value_or(""));
    if (tags.name() == "cellXfs") in_cell_formats = tags.opens() && !tags.closes();
    if (tags.name() != "xf" || !tags.opens() || !in_cell_formats) continue;
    const std::size_t format = whole_number(tags.attribute("numFmtId"));
    const auto found = stated.find(format);
    if (found == stated.end() ? is_built_in_time(format) : found->second) result.insert(count);
    ++count;
  }
  return result;
}

// "C14" from 0: column 2. The row is a number of its own.
std::size_t column_of(std::string_view reference) {
  std::size_t column = 0;
  for (const char c : reference) {
    if (c < 'A' || c > 'Z' || column > SheetRows::most_columns) break;
    column = column * 26 + static_cast<std::size_t>(c - 'A' + 1);
  }
  return column - 1;
}

struct Book {
  std::vector<std::string> strings;
  std::set<std::size_t> time_formats;
  bool since_1904 = false;
};

std::string cell_text(const std::string& type, std::size_t format, std::string value,
                      const Book& book) {
  if (type == "s") {
    const std::size_t i = whole_number(value);
    return i < book.strings.size() ? book.strings[i] : "";
  }
  if (type == "b") return value == "1" ? "true" : "false";
  double number = 0;
  const bool counts_days = (type.empty() || type == "n") && book.time_formats.count(format) > 0;
  if (!counts_days) return value;
  std::from_chars(value.data(), value.data() + value.size(), number);
  return date_text(number, book.since_1904);
}

Sheet read_sheet(std::string name, const std::string& xml, const Book& book) {
  SheetRows rows;
  std::size_t row = 0, column = 0, format = 0;
  bool started = false, phonetic = false;
  std::string type, value;
  for (XmlScanner tags(xml); tags.next();) {
    if (tags.name() == "row" && tags.opens()) {
      const std::size_t stated = whole_number(tags.attribute("r"));
      row = stated > 0 ? stated - 1 : row + started;
      started = true;
      column = static_cast<std::size_t>(-1);
    } else if (tags.name() == "c") {
      if (tags.opens()) {
        const auto reference = tags.attribute("r");
        column = reference ? column_of(*reference) : column + 1;
        format = whole_number(tags.attribute("s"));
        type = tags.attribute("t").value_or("");
        value.clear();
      }
      if (tags.closes() && !value.empty())
        rows.put(row, column, cell_text(type, format, std::exchange(value, {}), book));
    } else if (tags.name() == "rPh") {
      phonetic = tags.opens() && !tags.closes();
    } else if ((tags.name() == "v" || tags.name() == "t") && tags.closes() && !tags.opens()) {
      if (!phonetic) value += tags.text();
    }
  }
  return {std::move(name), rows.text(), rows.is_full()};
}

}  // namespace

// Letters of dates and times outside of quotes and of brackets that name colours or languages.
bool shows_time(std::string_view format) {
  if (format.starts_with("General") || format.starts_with("Standard")) return false;
  bool quoted = false, bracketed = false;
  for (std::size_t i = 0; i < format.size(); ++i) {
    const char c = format[i];
    if (c == '"') quoted = !quoted;
    if (!quoted && (c == '\\' || c == '_')) ++i;
    if (quoted || c == '\\' || c == '_') continue;
    if (c == '[')
      bracketed = i + 1 >= format.size() ||
                  std::string_view("hHmMsS").find(format[i + 1]) == std::string_view::npos ||
                  format.substr(i).starts_with("[Mag");
    if (c == ']') bracketed = false;
    if (!bracketed && std::string_view("yYdDhHsSmM").find(c) != std::string_view::npos) return true;
  }
  return false;
}

std::string date_text(double days, bool since_1904) {
  using namespace std::chrono;
  constexpr double most_days = 3e6;  // the year 9999
  if (!(days >= 0 && days < most_days)) return fmt::format("{}", days);
  const auto total = static_cast<long long>(std::round(days * 86400e3));  // [ms]
  const long long day = total / 86400000, rest = total % 86400000;
  std::string clock = fmt::format("{:02}:{:02}:{:02}.{:03}", rest / 3600000, rest / 60000 % 60,
                                  rest / 1000 % 60, rest % 1000);
  if (day == 0) return clock;
  const sys_days origin =
      since_1904 ? sys_days(year(1904) / 1 / 1) : sys_days(year(1899) / 12 / 30);
  const year_month_day date(origin + std::chrono::days(day));
  return fmt::format("{:04}-{:02}-{:02}T{}", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()), clock);
}

std::vector<Sheet> read_open_xml(const ZipArchive& archive) {
  const auto targets = read_targets(archive);
  Book book{.strings = read_shared_strings(archive), .time_formats = read_time_formats(archive)};
  const std::string xml = archive.read("xl/workbook.xml");
  std::vector<Sheet> sheets;
  for (XmlScanner tags(xml); tags.next();) {
    if (tags.name() == "workbookPr") {
      const std::string since = tags.attribute("date1904").value_or("0");
      book.since_1904 = since == "1" || since == "true";
    }
    if (tags.name() != "sheet" || !tags.opens()) continue;
    const auto target = targets.find(tags.attribute("id").value_or(""));
    if (target == targets.end() || !archive.has(target->second)) continue;  // a chart
    sheets.push_back(
        read_sheet(tags.attribute("name").value_or(""), archive.read(target->second), book));
  }
  return sheets;
}

}  // namespace kinetostat::io

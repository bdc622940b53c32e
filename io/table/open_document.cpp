#include "kinetostat/io/table/open_document.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include <fmt/format.h>

#include "kinetostat/io/table/sheet_rows.h"
#include "kinetostat/io/table/xml_scanner.h"

namespace kinetostat::io {
namespace {

std::size_t repetitions(const XmlScanner& tags, std::string_view attribute) {
  std::size_t count = 1;
  if (const auto text = tags.attribute(attribute))
    std::from_chars(text->data(), text->data() + text->size(), count);
  return std::max<std::size_t>(count, 1);
}

// "PT12H30M05.5S" as "12:30:05.5".
std::string clock_of(std::string_view duration) {
  double parts[3] = {0, 0, 0};
  std::size_t at = duration.find('T');
  for (std::size_t i = 0; i < 3 && at != std::string_view::npos; ++i) {
    const std::size_t end = duration.find("HMS"[i], at);
    if (end == std::string_view::npos) continue;
    std::from_chars(duration.data() + at + 1, duration.data() + end, parts[i]);
    at = end;
  }
  return fmt::format("{:02}:{:02}:{:06.3f}", static_cast<int>(parts[0]), static_cast<int>(parts[1]),
                     parts[2]);
}

// The value that a cell has beside what it shows; nullopt for texts.
std::optional<std::string> value_of(const XmlScanner& tags) {
  const std::string type = tags.attribute("value-type").value_or("");
  if (type == "float" || type == "percentage" || type == "currency") return tags.attribute("value");
  if (type == "date") return tags.attribute("date-value");
  if (type == "boolean") return tags.attribute("boolean-value");
  if (type == "time") return clock_of(tags.attribute("time-value").value_or(""));
  return std::nullopt;
}

class Reader {
 public:
  std::vector<Sheet> read(const std::string& xml) {
    for (XmlScanner tags(xml); tags.next();) {
      if (tags.name() == "table")
        table(tags);
      else if (tags.name() == "table-row")
        row(tags);
      else if (tags.name() == "table-cell" || tags.name() == "covered-table-cell")
        cell(tags);
      else if (tags.name() == "annotation")
        aside_ = tags.opens() && !tags.closes();
      else if (!aside_ && in_cell_)
        text(tags);
    }
    return std::move(sheets_);
  }

 private:
  void table(const XmlScanner& tags) {
    if (tags.opens()) {
      name_ = tags.attribute("name").value_or("");
      rows_ = SheetRows();
      row_ = 0;
    }
    if (tags.closes()) sheets_.push_back({name_, rows_.text(), rows_.is_full()});
  }

  void row(const XmlScanner& tags) {
    if (tags.opens()) {
      cells_.clear();
      empty_ = 0;
      repeated_row_ = repetitions(tags, "number-rows-repeated");
    }
    if (!tags.closes()) return;
    const std::size_t count = std::min(repeated_row_, SheetRows::most_rows - row_);
    for (std::size_t i = 0; !cells_.empty() && i < count && !rows_.is_full(); ++i)
      for (std::size_t c = 0; c < cells_.size(); ++c) rows_.put(row_ + i, c, cells_[c]);
    row_ = std::min(row_ + repeated_row_, SheetRows::most_rows);
  }

  void cell(const XmlScanner& tags) {
    if (tags.opens()) {
      text_.clear();
      value_ = value_of(tags);
      repeated_cell_ = repetitions(tags, "number-columns-repeated");
      in_cell_ = true;
    }
    if (!tags.closes()) return;
    in_cell_ = false;
    place(value_.value_or(text_));
  }

  // Empty cells count only where another follows.
  void place(const std::string& content) {
    if (content.empty()) {
      empty_ += repeated_cell_;
      return;
    }
    const std::size_t room =
        SheetRows::most_columns - std::min(cells_.size(), SheetRows::most_columns);
    cells_.resize(cells_.size() + std::min(empty_, room));
    empty_ = 0;
    cells_.resize(std::min(cells_.size() + repeated_cell_, SheetRows::most_columns), content);
  }

  // Of the tags in a cell: text stands in paragraphs, which are divided by a blank.
  void text(const XmlScanner& tags) {
    if (in_paragraph_) text_ += tags.text();
    if (tags.name() == "p") {
      if (tags.opens() && !text_.empty()) text_ += ' ';
      in_paragraph_ = tags.opens() && !tags.closes();
    }
    if (!tags.opens()) return;
    if (tags.name() == "s") text_.append(std::min<std::size_t>(repetitions(tags, "c"), 100), ' ');
    if (tags.name() == "tab" || tags.name() == "line-break") text_ += ' ';
  }

  std::vector<Sheet> sheets_;
  std::string name_, text_;
  std::optional<std::string> value_;
  SheetRows rows_;
  std::vector<std::string> cells_;
  std::size_t row_ = 0, repeated_row_ = 1, repeated_cell_ = 1, empty_ = 0;
  bool in_cell_ = false, in_paragraph_ = false, aside_ = false;
};

}  // namespace

std::vector<Sheet> read_open_document(const ZipArchive& archive) {
  return Reader().read(archive.read("content.xml"));
}

}  // namespace kinetostat::io

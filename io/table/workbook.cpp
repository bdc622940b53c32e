#include "kinetostat/io/table/workbook.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/io/table/open_document.h"
#include "kinetostat/io/table/open_xml.h"
#include "kinetostat/io/table/sheet_rows.h"
#include "kinetostat/io/table/table_layout.h"
#include "kinetostat/io/table/zip_archive.h"

namespace kinetostat::io {

bool is_workbook(std::string_view bytes) {
  if (!bytes.starts_with("PK\x03\x04")) return false;
  return bytes.find("xl/workbook.xml") != std::string_view::npos ||
         bytes.substr(0, 200).find("opendocument.spreadsheet") != std::string_view::npos;
}

std::vector<Sheet> read_workbook(const std::string& bytes, const std::filesystem::path& file) {
  const ZipArchive archive(bytes, file);
  std::vector<Sheet> sheets =
      archive.has("xl/workbook.xml") ? read_open_xml(archive) : read_open_document(archive);
  for (const Sheet& sheet : sheets)
    if (sheet.is_cut)
      throw common::InputError(
          file, fmt::format("sheet '{}' has more than {} cells", sheet.name, SheetRows::most_cells),
          "Save the table alone, as 'CSV UTF-8'");
  return sheets;
}

bool holds_table(const Sheet& sheet) {
  const std::size_t header = find_layout(sheet.text).begin;
  const std::size_t rows = sheet.text.find('\n', header);
  if (rows == std::string::npos || sheet.text.find('\t', header) == std::string::npos) return false;
  for (std::size_t at = rows; at < sheet.text.size();) {
    const std::size_t end = std::min(sheet.text.find_first_of("\t\n", at), sheet.text.size());
    if (looks_like_value(std::string_view(sheet.text).substr(at, end - at))) return true;
    at = end + 1;
  }
  return false;
}

std::size_t find_sheet(const std::vector<Sheet>& sheets, const std::string& name,
                       const std::filesystem::path& file) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < sheets.size(); ++i) {
    if (name.empty() ? holds_table(sheets[i]) : sheets[i].name == name) return i;
    names.push_back(sheets[i].name);
  }
  if (name.empty())
    throw common::InputError(file, "no sheet of this spreadsheet holds a table",
                             "Give a row with column names, then one row a reading");
  const std::string near = common::nearest_spelling(name, names);
  throw common::InputError({.file = file,
                            .key = "sheet",
                            .what = fmt::format("there is no sheet '{}'", name),
                            .cure = near.empty()
                                        ? fmt::format("Known are: {}", fmt::join(names, ", "))
                                        : fmt::format("Did you mean '{}'?", near)});
}

}  // namespace kinetostat::io

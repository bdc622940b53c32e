// Sheets of an .xlsx file (Office Open XML, ECMA-376 part 1, 18.3 SpreadsheetML).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "kinetostat/io/table/sheet_rows.h"
#include "kinetostat/io/table/zip_archive.h"

namespace kinetostat::io {

/// Throws InputError.
std::vector<Sheet> read_open_xml(const ZipArchive& archive);

/// Whether a number format shows a date or a time: "yyyy-mm-dd", "[h]:mm"; not "0.00 \"mm\"".
bool shows_time(std::string_view format);

/// Days since 1899-12-30 (`since_1904`: since 1904-01-01) as ISO 8601, "2026-05-03T14:22:05.100";
/// less than a day as a time alone.
std::string date_text(double days, bool since_1904);

}  // namespace kinetostat::io

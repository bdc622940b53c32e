// Spreadsheets as Excel (.xlsx, Office Open XML, ECMA-376) and LibreOffice (.ods, OpenDocument)
// save them, as text.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "kinetostat/io/table/sheet_rows.h"

namespace kinetostat::io {

/// Whether the bytes are those of an .xlsx or .ods file.
bool is_workbook(std::string_view bytes);

/// The sheets in their order. Formulas have the values that were saved; dates and times are ISO
/// 8601 to the millisecond, and numbers have a decimal point. Throws InputError when the file is
/// damaged.
std::vector<Sheet> read_workbook(const std::string& bytes, const std::filesystem::path& file);

/// Index of the sheet of this name; of none, of the first that holds a table. Throws InputError,
/// naming the sheets, when there is none.
std::size_t find_sheet(const std::vector<Sheet>& sheets, const std::string& name,
                       const std::filesystem::path& file);

/// Whether the sheet has a row of names above a row with numbers.
bool holds_table(const Sheet& sheet);

}  // namespace kinetostat::io

// Sheets of an .ods file (OpenDocument 1.3 part 3, 9 tables).
#pragma once

#include <vector>

#include "kinetostat/io/table/sheet_rows.h"
#include "kinetostat/io/table/zip_archive.h"

namespace kinetostat::io {

/// Throws InputError.
std::vector<Sheet> read_open_document(const ZipArchive& archive);

}  // namespace kinetostat::io

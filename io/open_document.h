// Sheets of an .ods file (OpenDocument 1.3 part 3, 9 tables).
#pragma once

#include <vector>

#include "kinetostat/io/workbook.h"
#include "kinetostat/io/zip_archive.h"

namespace kinetostat::io {

/// Throws InputError.
std::vector<Sheet> read_open_document(const ZipArchive& archive);

}  // namespace kinetostat::io

// Writes zip archives without compression, and spreadsheets in them, for tests of their readers.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace kinetostat::test {

using Files = std::vector<std::pair<std::string, std::string>>;  // name, content

inline std::uint32_t crc32_of(const std::string& bytes) {
  std::uint32_t crc = 0xFFFFFFFF;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320 : 0);
  }
  return ~crc;
}

inline std::string little_endian(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> 8 * i & 0xFF);
  return text;
}

inline std::string zip_of(const Files& files) {
  std::string archive, directory;
  for (const auto& [name, content] : files) {
    const std::string common = little_endian(0, 2) + little_endian(0, 2) + little_endian(0, 4) +
                               little_endian(crc32_of(content), 4) +
                               little_endian(content.size(), 4) + little_endian(content.size(), 4) +
                               little_endian(name.size(), 2) + little_endian(0, 2);
    directory += "PK\x01\x02" + little_endian(20, 2) + little_endian(20, 2) + common +
                 little_endian(0, 2) + little_endian(0, 2) + little_endian(0, 2) +
                 little_endian(0, 4) + little_endian(archive.size(), 4) + name;
    archive += "PK\x03\x04" + little_endian(20, 2) + common + name + content;
  }
  return archive + directory + "PK\x05\x06" + little_endian(0, 4) + little_endian(files.size(), 2) +
         little_endian(files.size(), 2) + little_endian(directory.size(), 4) +
         little_endian(archive.size(), 4) + little_endian(0, 2);
}

/// Rows of XML cells ("<c ...>...</c>"), as Excel writes them; `styles` holds number formats of the
/// cell formats 1, 2, ...
inline std::string xlsx_of(const std::vector<std::pair<std::string, std::string>>& sheets,
                           const std::vector<std::string>& shared = {},
                           const std::vector<std::string>& formats = {},
                           const std::string& workbook_properties = "") {
  std::string book = "<?xml version=\"1.0\"?><workbook>" + workbook_properties + "<sheets>";
  std::string relations = "<Relationships>", strings = "<sst>", styles = "<styleSheet><numFmts>";
  Files files = {{"[Content_Types].xml", "<Types/>"}};
  int count = 0;
  for (const auto& [name, rows] : sheets) {
    const std::string number = std::to_string(++count);
    book += "<sheet name=\"" + name + "\" sheetId=\"" + number + "\" r:id=\"rId" + number + "\"/>";
    // Some programs write targets from the root of the archive.
    relations += "<Relationship Id=\"rId" + number + "\" Target=\"" +
                 (count % 2 == 0 ? "/xl/" : "") + "worksheets/sheet" + number + ".xml\"/>";
    files.emplace_back("xl/worksheets/sheet" + number + ".xml",
                       "<worksheet><sheetData>" + rows + "</sheetData></worksheet>");
  }
  for (const std::string& text : shared) strings += "<si><t>" + text + "</t></si>";
  std::string cell_formats = "<cellXfs><xf numFmtId=\"0\"/>";
  for (std::size_t i = 0; i < formats.size(); ++i) {
    const std::string id = std::to_string(164 + i);
    styles += "<numFmt numFmtId=\"" + id + "\" formatCode=\"" + formats[i] + "\"/>";
    cell_formats += "<xf numFmtId=\"" + id + "\"/>";
  }
  files.emplace_back("xl/workbook.xml", book + "</sheets></workbook>");
  files.emplace_back("xl/_rels/workbook.xml.rels", relations + "</Relationships>");
  files.emplace_back("xl/sharedStrings.xml", strings + "</sst>");
  files.emplace_back("xl/styles.xml",
                     styles + "</numFmts>" + cell_formats + "</cellXfs></styleSheet>");
  return zip_of(files);
}

inline std::string ods_of(const std::string& tables) {
  return zip_of({{"mimetype", "application/vnd.oasis.opendocument.spreadsheet"},
                 {"content.xml",
                  "<?xml version=\"1.0\"?><office:document-content><office:body>"
                  "<office:spreadsheet>" +
                      tables + "</office:spreadsheet></office:body></office:document-content>"}});
}

}  // namespace kinetostat::test

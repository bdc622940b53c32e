#include "kinetostat/io/document_kind.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <string_view>
#include <utility>

#include "kinetostat/common/error.h"
#include "kinetostat/io/file_kind.h"
#include "kinetostat/io/table/text_encoding.h"
#include "kinetostat/io/table/workbook.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::io {
namespace {

constexpr std::size_t looked_at = std::size_t{1} << 20;  // [bytes]

std::string lower_extension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

bool contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

DocumentKind kind_of_json(std::string_view text) {
  if (contains(text, "\"verdict\"") && contains(text, "\"draws\"")) return DocumentKind::diagnosis;
  if (contains(text, "\"command\"")) return DocumentKind::result;
  if (contains(text, "\"compliance\"") && contains(text, "\"link\""))
    return DocumentKind::link_result;
  return DocumentKind::unknown;
}

// By keys at the start of a line.
DocumentKind kind_of_yaml(std::string_view text) {
  const auto has_key = [text](std::string_view key) {
    return text.starts_with(key) || contains(text, "\n" + std::string(key));
  };
  if (has_key("dh:")) return DocumentKind::description;
  if (has_key("link:")) return DocumentKind::link;
  if (has_key("campaign:")) return DocumentKind::campaign;
  if (has_key("manipulator:") || has_key("chain_types:") || has_key("name:"))
    return DocumentKind::robot;
  return DocumentKind::unknown;
}

bool is_description(std::string_view bytes, const std::string& kind) {
  if (contains(kind, "robot description")) return true;
  const bool names_robot =
      contains(bytes, "<robot") || contains(bytes, "<sdf") || contains(bytes, "<mujoco");
  return names_robot && (kind == "XML" || bytes.starts_with("<!--"));
}

DocumentKind kind_of(std::string_view bytes, const std::string& extension) {
  constexpr std::array<std::string_view, 9> of_meshes = {".stl", ".obj", ".ply", ".step", ".stp",
                                                         ".msh", ".inp", ".off", ".3mf"};
  if (is_workbook(bytes)) return DocumentKind::table;
  const std::string kind = kind_of_bytes(bytes);
  if (contains(kind, "mesh") || contains(kind, "CAD model")) return DocumentKind::mesh;
  if (std::find(of_meshes.begin(), of_meshes.end(), extension) != of_meshes.end())
    return DocumentKind::mesh;
  if (is_description(bytes, kind)) return DocumentKind::description;
  if (kind == "UTF-16 text") return DocumentKind::table;
  if (!kind.empty()) return DocumentKind::unknown;
  const std::size_t first = bytes.find_first_not_of(" \t\r\n\xef\xbb\xbf");
  if (first != std::string_view::npos && bytes[first] == '{') return kind_of_json(bytes);
  if (const DocumentKind yaml = kind_of_yaml(bytes); yaml != DocumentKind::unknown) return yaml;
  const bool named_so = extension == ".csv" || extension == ".tsv";
  return named_so || looks_like_table(bytes) ? DocumentKind::table : DocumentKind::unknown;
}

}  // namespace

DocumentKind document_kind(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return DocumentKind::unknown;
  std::string bytes;
  try {
    bytes = read_start(file, looked_at);
    // The directory of an archive is at its end.
    if (bytes.starts_with("PK\x03\x04") && bytes.size() == looked_at) bytes = read_text(file);
  } catch (const common::InputError&) {
    return DocumentKind::unknown;
  }
  return bytes.empty() ? DocumentKind::unknown : kind_of(bytes, lower_extension(file));
}

const char* words_for(DocumentKind kind) {
  switch (kind) {
    case DocumentKind::mesh:
      return "a mesh";
    case DocumentKind::description:
      return "a robot description (URDF, SDF, MJCF or a Denavit-Hartenberg table)";
    case DocumentKind::table:
      return "a table (CSV)";
    case DocumentKind::robot:
      return "a robot file";
    case DocumentKind::campaign:
      return "a campaign file";
    case DocumentKind::link:
      return "a link file";
    case DocumentKind::link_result:
      return "the result of a link";
    case DocumentKind::diagnosis:
      return "a diagnosis";
    case DocumentKind::result:
      return "a result of kinetostat";
    case DocumentKind::unknown:
      break;
  }
  return "a file of an unknown kind";
}

}  // namespace kinetostat::io

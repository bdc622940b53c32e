#include "kinetostat/io/file_kind.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstring>

#include <fmt/format.h>

#include "kinetostat/common/error.h"

namespace kinetostat::io {
namespace {

using namespace std::string_view_literals;

struct Signature {
  std::string_view bytes;
  const char* kind;
};

// As the formats themselves define them; the longer one first where one starts with another.
constexpr std::array signatures{
    Signature{"\x89PNG\r\n\x1a\n"sv, "a PNG picture"},
    Signature{"\xff\xd8\xff"sv, "a JPEG picture"},
    Signature{"GIF8"sv, "a GIF picture"},
    Signature{"II*\0"sv, "a TIFF picture"},
    Signature{"MM\0*"sv, "a TIFF picture"},
    Signature{"%PDF-"sv, "a PDF document"},
    Signature{"{\\rtf"sv, "an RTF document"},
    Signature{"PK\x03\x04"sv, "a zip archive (as Excel, LibreOffice and 3MF files are)"},
    Signature{"PK\x05\x06"sv, "a zip archive without content"},
    Signature{"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"sv, "an Excel or Word file of the old kind"},
    Signature{"\x1f\x8b"sv, "gzip-compressed data"},
    Signature{"BZh"sv, "bzip2-compressed data"},
    Signature{"\xfd"
              "7zXZ\0"sv,
              "xz-compressed data"},
    Signature{"\x28\xb5\x2f\xfd"sv, "zstd-compressed data"},
    Signature{"7z\xbc\xaf\x27\x1c"sv, "a 7z archive"},
    Signature{"\x7f"
              "ELF"sv,
              "a program (ELF)"},
    Signature{"MZ\x90\0"sv, "a program (Windows)"},
    Signature{"SQLite format 3\0"sv, "an SQLite data base"},
    Signature{"\x89HDF\r\n\x1a\n"sv, "an HDF5 file"},
    Signature{"MATLAB 5.0 MAT-file"sv, "a MATLAB data file"},
    Signature{"\x93NUMPY"sv, "a NumPy array"},
    Signature{"\xff\xfe"sv, "UTF-16 text"},
    Signature{"\xfe\xff"sv, "UTF-16 text"},
    Signature{"ISO-10303-21"sv, "a CAD model (STEP)"},
    Signature{"ply\n"sv, "a mesh (PLY)"},
    Signature{"ply\r\n"sv, "a mesh (PLY)"},
    Signature{"$MeshFormat"sv, "a mesh (Gmsh)"},
    Signature{"version https://git-lfs"sv, "the note that Git LFS leaves in place of a file"},
    Signature{"<?xml"sv, "XML"},
    Signature{"<robot"sv, "a robot description (URDF)"},
    Signature{"<sdf"sv, "a robot description (SDF)"},
    Signature{"<mujoco"sv, "a robot description (MJCF)"},
    Signature{"<!DOCTYPE"sv, "an HTML page"},
    Signature{"<!doctype"sv, "an HTML page"},
    Signature{"<html"sv, "an HTML page"}};

bool is_binary_stl(std::string_view bytes) {
  constexpr std::size_t header = 84, facet = 50;
  std::uint32_t count = 0;
  if (bytes.size() < header) return false;
  std::memcpy(&count, bytes.data() + 80, sizeof count);
  return count > 0 && bytes.size() == header + facet * count;
}

// Both words, because "solid" may start a text of another kind.
bool is_ascii_stl(std::string_view bytes) {
  const std::string_view start = bytes.substr(0, 1000);
  return start.starts_with("solid") && start.find("facet normal") != std::string_view::npos;
}

std::string_view without_mark(std::string_view bytes) {
  if (bytes.starts_with("\xef\xbb\xbf")) bytes.remove_prefix(3);
  return bytes;
}

// The first line that is neither empty nor a comment.
std::string_view first_line(std::string_view text) {
  text = without_mark(text);
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find_first_of("\r\n"));
    const std::size_t first = line.find_first_not_of(" \t");
    if (first != std::string_view::npos && line[first] != '#') return line;
    text.remove_prefix(std::min(line.size() + 1, text.size()));
  }
  return {};
}

}  // namespace

std::string kind_of_bytes(std::string_view bytes) {
  bytes = without_mark(bytes);
  for (const Signature& signature : signatures)
    if (bytes.starts_with(signature.bytes)) return signature.kind;
  if (is_binary_stl(bytes)) return "a mesh (binary STL)";
  if (is_ascii_stl(bytes)) return "a mesh (ASCII STL)";
  if (bytes.substr(0, std::size_t{1} << 16).find('\0') != std::string_view::npos)
    return "binary data";
  return {};
}

bool looks_like_table(std::string_view text) {
  const std::string_view line = first_line(text);
  if (line.find(':') != std::string_view::npos || line.starts_with('{')) return false;
  const bool begins_empty = line.starts_with(',') || line.starts_with(';');
  const auto separators = std::count_if(line.begin(), line.end(),
                                        [](char c) { return c == ',' || c == ';' || c == '\t'; });
  const bool is_flow = line.starts_with('[') || line.starts_with('-');
  return begins_empty || (separators > 0 && !is_flow && !line.starts_with('\t'));
}

void refuse_other_kinds(const std::filesystem::path& file, std::string_view bytes,
                        const std::string& wanted, const std::string& cure) {
  if (const std::string kind = kind_of_bytes(bytes); !kind.empty())
    throw common::InputError(file, fmt::format("this is {}, not {}", kind, wanted), cure);
}

}  // namespace kinetostat::io

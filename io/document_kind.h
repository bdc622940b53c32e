// What a file that people hand over is: a mesh, a robot file, a table of readings, a diagnosis.
#pragma once

#include <filesystem>

namespace kinetostat::io {

enum class DocumentKind {
  unknown,
  mesh,         // of a surface or volume, CAD model
  description,  // of a robot by another program: URDF, SDF, MJCF, Denavit-Hartenberg table
  table,        // CSV, or a spreadsheet
  robot,        // robot file
  campaign,     // campaign file
  link,         // link file
  link_result,  // what `identify -o` writes
  diagnosis,    // what `diagnose -o` writes
  result        // of another command, as JSON
};

/// By the name of the file and its first MiB; unknown for what cannot be read, for pipes and for
/// what is none of these.
DocumentKind document_kind(const std::filesystem::path& file);

/// With its article: "a mesh", "a robot file", "a table (CSV)".
const char* words_for(DocumentKind kind);

}  // namespace kinetostat::io

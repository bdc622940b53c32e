// The folder of a studio: files that are dropped onto its page, and how tables of readings are
// understood.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "kinetostat/io/json.h"

namespace kinetostat::apps {

/// Letters, digits, '-', '_' and '.', at most 100, not hidden: no way out of the folder.
bool is_plain_name(const std::string& name);

/// Files are named by plain names in the folder. Nothing outside it is read or written, no file
/// that was there before is written over, and no symbolic link is followed. Mistakes of the page
/// end in common::InputError.
class StudioFiles {
 public:
  explicit StudioFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}

  const std::filesystem::path& folder() const { return folder_; }
  /// The file of that name in the folder.
  std::filesystem::path file(const std::string& name) const;

  /// {"robots": [names], "campaigns": [...], "tables": [...]}, each in alphabetical order.
  io::Json list() const;
  /// {"name", "content": base64}: writes the file; where another content has the name already, the
  /// new one gets a number. {"file": its name, "kind": "a robot file"}.
  io::Json drop(const io::Json& request);
  /// {"table", "robot", "columns": {header: meaning}, "units": {"length": "mm"}, "displacement",
  /// "sheet"}: how the columns are understood (report::readings_json), and as "meanings" what else
  /// a column may be. All but the table may be left out.
  io::Json look(const io::Json& request) const;
  /// The same, with "noise" of translations ("2 um") where the readings do not tell it themselves:
  /// writes the campaign file. {"campaign": its name}. Throws for a table that cannot be used.
  io::Json use(const io::Json& request);

 private:
  std::string write_new(const std::string& name, const std::string& content);

  std::filesystem::path folder_;
};

}  // namespace kinetostat::apps

// What a session of the studio has come to, in a file: it is there again after a reload, and after
// the program was started anew.
#pragma once

#include <filesystem>
#include <string>

#include "kinetostat/io/json.h"

namespace kinetostat::apps {

class StudioNotes {
 public:
  /// Reads the file if it is there and about the same inputs (`about`: their digest); else starts
  /// anew. Throws common::InputError where the file is something else than notes of a studio.
  StudioNotes(std::filesystem::path file, const std::string& about);

  /// "cards": models that were tried, as StudioSession gives them, one of each set of effects;
  /// "chosen": the name of one; "verdict", "plan", "adopted": what these steps ended with.
  const io::Json& all() const { return notes_; }
  /// Each writes the file.
  void keep_card(const io::Json& card);
  void remove_card(const std::string& name);
  void keep(const std::string& key, const io::Json& value);

 private:
  void write() const;

  std::filesystem::path file_;
  io::Json notes_;
};

}  // namespace kinetostat::apps

// What the program can be asked, as plain values: what man pages and completions are made from.
#pragma once

#include <string>
#include <vector>

namespace kinetostat::apps {

struct OptionText {
  std::vector<std::string> names;  // "-o", "--out"; none where it stands without a name
  std::string value;               // "FILE", "[ROBOT] CAMPAIGN"; empty for a flag
  std::string description;         // as in the help, with defaults
  std::string heading;             // of the help
  std::vector<std::string> choices;
};

struct CommandText {
  std::string name;  // "stiffness", "mesh check"
  std::string summary, heading, example;
  std::vector<OptionText> options;
};

struct ProgramText {
  std::string version, purpose;
  std::vector<CommandText> commands;  // in the order of the help
};

}  // namespace kinetostat::apps

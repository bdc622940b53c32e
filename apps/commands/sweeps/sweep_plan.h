// Many runs of one command with other values each: what a sweep file asks for.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "kinetostat/io/json.h"

namespace kinetostat::apps {

/// A sweep file (docs/reference/sweep.md), with its runs.
struct SweepPlan {
  std::filesystem::path file;
  std::string name;
  std::vector<std::string> command;    // words of it, without the program
  std::vector<std::string> keys = {};  // that are varied
  std::vector<bool> is_word = {};      // {KEY} in the command, else a key for --set
  /// Names of columns, and paths in the JSON of the command: "unloaded.stiffness.0.0".
  std::vector<std::pair<std::string, std::string>> results = {};
  std::vector<std::vector<std::string>> runs = {};  // a value for each key, as --set takes it
  std::string meaning = {};  // of the file, and of those that its command names
};

/// Throws common::InputError with file, line and key.
SweepPlan read_sweep(const std::filesystem::path& file);

/// What stands in the cell of a result: a number with the digits that read back to it, a text, or
/// nothing where the JSON has no such value.
std::string result_cell(const io::Json& result, const std::string& path);
/// The paths below one that leads to a map or a list, the first few: "a.x, a.y". Empty for others.
std::string parts_of_result(const io::Json& result, const std::string& path);

}  // namespace kinetostat::apps

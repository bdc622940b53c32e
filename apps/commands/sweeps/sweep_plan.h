// Many runs of one command with other values each: what a sweep file asks for.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kinetostat/common/error.h"
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
  std::vector<int> result_lines = {};               // of the file, one each
  std::vector<std::vector<std::string>> runs = {};  // a value for each key, as --set takes it
  std::string meaning = {};  // of the file, and of those that its command names
};

/// Throws common::InputError with file, line and key.
SweepPlan read_sweep(const std::filesystem::path& file);

/// What stands in the cell of a result: a number with the digits that read back to it, a text, or
/// nothing where the JSON has no such value.
std::string result_cell(const io::Json& result, const std::string& path);
/// That one of the results leads to a map or a list, which no cell can hold, and what it has; none
/// where all of them fit.
std::optional<common::InputError> unfit_result(const SweepPlan& plan, const io::Json& result);

}  // namespace kinetostat::apps

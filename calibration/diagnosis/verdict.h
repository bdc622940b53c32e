// The five kinds of verdict, and their words.
#pragma once

#include <optional>
#include <string>

namespace kinetostat::calibration {

enum class Verdict {
  identified,     // class and place of every effect that was found
  narrowed_down,  // to a short list
  unexplained,    // something is missing that the catalogue lacks
  none_needed,
  inconclusive
};
std::string to_string(Verdict verdict);
/// Reads the words of to_string(), and those of files written before 2027. None for others.
std::optional<Verdict> verdict_named(const std::string& words);

}  // namespace kinetostat::calibration

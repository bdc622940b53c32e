#include "kinetostat/calibration/diagnosis/verdict.h"

#include <map>

namespace kinetostat::calibration {

std::string to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::identified:
      return "identified";
    case Verdict::narrowed_down:
      return "narrowed down";
    case Verdict::unexplained:
      return "unexplained";
    case Verdict::none_needed:
      return "none needed";
    case Verdict::inconclusive:
      break;
  }
  return "inconclusive";
}

std::optional<Verdict> verdict_named(const std::string& words) {
  static const std::map<std::string, Verdict> old{
      {"named effect", Verdict::identified},
      {"ambiguous", Verdict::narrowed_down},
      {"none of the above", Verdict::unexplained},
      {"no effect needed", Verdict::none_needed},
      {"these data cannot tell", Verdict::inconclusive}};
  for (const Verdict verdict : {Verdict::identified, Verdict::narrowed_down, Verdict::unexplained,
                                Verdict::none_needed, Verdict::inconclusive})
    if (words == to_string(verdict)) return verdict;
  const auto found = old.find(words);
  return found == old.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace kinetostat::calibration

#include "kinetostat/calibration/diagnosis/diagnosis_result.h"

#include <algorithm>
#include <map>

namespace kinetostat::calibration {
bool Diagnosis::is_left_open() const {
  return after && misfit > believable_noise * believable_noise;
}

bool Diagnosis::leaves_misfit() const { return after && after->p_value <= certain_level; }

bool Diagnosis::predicts_no_better() const {
  // What is of some readings only says nothing of others.
  return std::any_of(found.begin(), found.end(), [](const FoundEffect& f) {
    return !(f.log_score_gain > 0) && !f.candidate.effect.kind->offsets_readings;
  });
}

bool Diagnosis::predicts_worse() const {
  for (std::size_t i = 1; i < waterfall.size(); ++i)
    if (waterfall[i].name.rfind("+ ", 0) == 0 && waterfall[i].whitened >= waterfall[i - 1].whitened)
      return true;
  return false;
}

std::vector<UnseenKind> unseen_kinds(const Diagnosis& diagnosis) {
  if (diagnosis.steps.empty()) return {};
  std::map<std::string, UnseenKind> kinds;
  for (const RankedCandidate& ranked : diagnosis.steps.front().ranking) {
    UnseenKind& kind = kinds[ranked.candidate.effect.kind->name];
    kind.name = ranked.candidate.effect.kind->name;
    kind.detectability = std::max(kind.detectability, ranked.most_detectability);
    kind.confounded_with_fit |= ranked.unobservable == confounded_with_fit;
  }
  std::vector<UnseenKind> unseen;
  for (const auto& [name, kind] : kinds) {
    const std::string& own = name;
    const bool is_found = std::any_of(
        diagnosis.found.begin(), diagnosis.found.end(),
        [&](const FoundEffect& found) { return found.candidate.effect.kind->name == own; });
    if (kind.detectability < discriminable_from && !is_found) unseen.push_back(kind);
  }
  for (const KindWithoutPlace& kind : diagnosis.without_place)
    unseen.push_back({.name = kind.name, .reason = kind.reason});
  std::sort(unseen.begin(), unseen.end(),
            [](const UnseenKind& a, const UnseenKind& b) { return a.name < b.name; });
  return unseen;
}

}  // namespace kinetostat::calibration

#include "kinetostat/calibration/diagnosis/judgement.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace kinetostat::calibration {
namespace {

bool can_show_anything(const DiagnosisStep& step) {
  return std::any_of(step.ranking.begin(), step.ranking.end(), [](const RankedCandidate& r) {
    return r.detectability >= discriminable_from;
  });
}

// The best candidate of the first round, where it exceeds the detection threshold but only at a
// size that nobody has seen, and something is missing rather than nothing.
std::string absurd_explanation(const Diagnosis& d) {
  if (d.steps.empty() || d.steps[0].indistinguishable.empty()) return {};
  const DiagnosisStep& first = d.steps[0];
  const RankedCandidate& best = first.ranking[0];
  if (first.max_score.p_value > significance_level || !is_absurd(first)) return {};
  if (decide(first).is_none_needed) return {};
  return fmt::format(
      "an effect that explains the misfit at a size that makes sense: {} comes nearest, but would "
      "have to be {:.0f} times as large as usual",
      best.candidate.name(), times_usual(best));
}

// The unmodelled smooth error is another law of what was found: of that drive, or over that time or
// temperature.
bool is_other_law(const Diagnosis& d) {
  const SmoothOver over = d.free_form.over;
  return std::any_of(d.found.begin(), d.found.end(), [&](const FoundEffect& found) {
    const vjm::EffectKind& kind = *found.candidate.effect.kind;
    const std::string& at = found.candidate.effect.at;
    if (kind.effect_class == vjm::EffectClass::time && !kind.acts_on_chains())
      return over == SmoothOver::time;
    if (kind.effect_class == vjm::EffectClass::temperature)
      return over == SmoothOver::time || over == SmoothOver::temperature;
    return kind.place == vjm::EffectPlace::joint &&
           (at == d.free_form.drive || d.free_form.drive.ends_with("." + at));
  });
}

// Each that was found must be identified; a list that is too long says nothing.
Verdict verdict_on_found(const Diagnosis& d) {
  constexpr double more_likely_than_not = 0.5;
  bool all_identified = true, all_listed = true;
  for (const FoundEffect& found : d.found) {
    if (found.decision.unexplained > more_likely_than_not) return Verdict::unexplained;
    all_identified &= found.decision.is_identified;
    all_listed &= found.decision.is_identified || found.decision.is_narrowed_down;
  }
  if (all_identified && d.ambiguous.empty()) return Verdict::identified;
  return all_listed ? Verdict::narrowed_down : Verdict::inconclusive;
}

Judgement judge_nothing_found(const Diagnosis& d, bool structure_left) {
  if (std::string nearest = absurd_explanation(d); !nearest.empty())
    return {Verdict::unexplained, {std::move(nearest)}};
  if (structure_left || (d.is_left_open() && !d.noise_without_load)) return {Verdict::unexplained};
  if (d.is_left_open())
    return {Verdict::inconclusive,
            {fmt::format("how exact readings under load are: only readings without load are "
                         "repeated, and the misfit is {:.2g} times what those show; repeat some "
                         "under load, or state 'noise'",
                         std::sqrt(d.misfit))}};
  if (d.common_cause || d.steps.empty() || !can_show_anything(d.steps.front()))
    return {Verdict::inconclusive};
  return {Verdict::none_needed};
}

}  // namespace

Judgement judge(const Diagnosis& d, double share_left) {
  // Of the misfit: laws in other forms leave a tenth, effects outside the catalogue a quarter and
  // more of what the nearest one explains.
  constexpr double most_left = 0.2;
  const bool structure_left = d.left.p_value() < structure_level;
  if (d.found.empty()) return judge_nothing_found(d, structure_left);
  const bool unlike_any = d.above_free_form < beaten_by_free_form && !is_other_law(d);
  if (unlike_any || (structure_left && share_left > most_left)) return {Verdict::unexplained};
  return {verdict_on_found(d)};
}

}  // namespace kinetostat::calibration

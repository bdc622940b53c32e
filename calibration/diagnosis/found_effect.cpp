#include "kinetostat/calibration/diagnosis/found_effect.h"

#include <algorithm>

#include "kinetostat/calibration/search/search.h"
#include "kinetostat/calibration/statistics/goodness_of_fit.h"

namespace kinetostat::calibration {
namespace {

constexpr double significance_of_more = 0.01;  // of a further effect beside one that was found

// Probability of an effect's class at its place, and what it may be instead: the first law of each
// other answer. Laws of one answer are no alternatives.
void take_decision(const DiagnosisStep& step, FoundEffect& found) {
  found.decision = decide(step);
  found.probability = 0;
  found.instead.clear();
  const vjm::Effect& effect = found.candidate.effect;
  for (const Answer& answer : found.decision.answers) {
    const bool is_own = std::any_of(answer.laws.begin(), answer.laws.end(), [&](const auto& law) {
      return law.effect == effect.kind->name && law.at == effect.at;
    });
    if (is_own)
      found.probability = answer.probability;
    else
      found.instead.push_back(step.ranking[answer.laws.front().candidate].candidate);
  }
}

// Beside others that are of some readings only, and so say nothing of those that were left out.
// Beside laws it may be what these get wrong.
bool is_one_more_offset(const Candidate& candidate, const std::vector<FoundEffect>& found) {
  const auto offsets = [](const Candidate& one) { return one.effect.kind->offsets_readings; };
  return offsets(candidate) && std::all_of(found.begin(), found.end(), [&](const FoundEffect& f) {
           return offsets(f.candidate);
         });
}

// Of what the best of a round does, where one of those beside it acts.
double shared_with(const FoundEffect& found, const DiagnosisStep& step) {
  const auto own = std::find(step.beside.begin(), step.beside.end(), found.candidate.name());
  const auto number = static_cast<std::size_t>(own - step.beside.begin());
  return number < step.shared.size() ? step.shared[number] : 1;
}

// Orders of one series: none is a part of what the law of another one gets wrong.
bool are_of_one_series(const Candidate& a, const Candidate& b) {
  return a.name() == b.name() && is_of_series(*a.effect.kind);
}

// Two to one: of laws of one answer the likeliest is named.
constexpr double noticeable = 0.7;

bool are_laws_of_one_answer(const Candidate& a, const Candidate& b) {
  return a.effect.at == b.effect.at && family_of(*a.effect.kind) == family_of(*b.effect.kind);
}

}  // namespace

// The larger it is, the more it has to explain.
bool is_absurd(const DiagnosisStep& step) {
  const RankedCandidate& best = step.ranking[0];
  const double times = times_usual(best);
  if (times <= unusual) return false;
  const double free_form = step.log_evidence_without + step.free_form.log;
  return best.fit->log_evidence - free_form < doubtful_beside_free_form ||
         step.share_left > unexplained_share * unusual / times;
}

double law_error_like(const std::vector<FoundEffect>& found, const DiagnosisStep& step) {
  constexpr double relative_error = 0.25;
  const Candidate& candidate = step.ranking[0].candidate;
  double most = 0;
  for (const FoundEffect& f : found) {
    const bool relatives =
        (act_at_one_joint(f.candidate, candidate) && !are_of_one_series(f.candidate, candidate)) ||
        (f.candidate.effect.kind->varies && candidate.effect.kind->varies);
    const double error = f.candidate.effect.kind->is_exact ? error_of_exact_law
                         : relatives                       ? relative_error
                                                           : law_error;
    most = std::max(most, error * f.length * shared_with(f, step));
  }
  return most;
}

Finding finding(const DiagnosisStep& step, const std::vector<FoundEffect>& found) {
  if (!step.is_worth_a_look() || step.indistinguishable.empty()) return Finding::nothing;
  const RankedCandidate& best = step.ranking[0];
  const double more_probable = best.fit->log_evidence - step.log_evidence_without;
  const bool probable = more_probable > doubtful;
  const bool predicts = best.fit->log_score_gain > best.fit->log_score_deviation ||
                        (is_one_more_offset(best.candidate, found) && more_probable > 3 * doubtful);
  const Finding what = is_absurd(step) ? Finding::part : Finding::effect;
  if (step.beside.empty()) return predicts || probable ? what : Finding::nothing;
  // A rest that comes and goes slowly is taken for noise of that kind by the test, and not by the
  // evidence, which lets the noise be either with the effect and without.
  const bool excludes_noise = step.takes_rest_for_noise && more_probable > 3 * doubtful;
  if (step.max_score.p_value > significance_of_more && !excludes_noise) return Finding::nothing;
  if (!predicts || !probable || best.fit->discriminability < discriminable_from ||
      best.fit->discriminability < law_error_like(found, step))
    return Finding::nothing;
  return step.free_form_probability < 0.5 ? what : Finding::part;
}

const DiagnosisStep* round_beside(std::span<const FoundEffect> found,
                                  const std::vector<DiagnosisStep>& steps) {
  std::vector<std::string> names;
  names.reserve(found.size());
  for (const FoundEffect& one : found) names.push_back(one.candidate.name());
  const auto own = std::find_if(steps.rbegin(), steps.rend(), [&](const DiagnosisStep& step) {
    return std::is_permutation(step.beside.begin(), step.beside.end(), names.begin(), names.end());
  });
  return own == steps.rend() ? nullptr : &*own;
}

bool is_rest_of_laws(const std::vector<FoundEffect>& found, const DiagnosisStep& step) {
  return !step.ranking.empty() && step.ranking[0].fit &&
         step.ranking[0].fit->discriminability < law_error_like(found, step);
}

FoundEffect found_effect(const DiagnosisStep& step) {
  const RankedCandidate& best = step.ranking[0];
  FoundEffect found{.candidate = best.candidate,
                    .deviations = best.fit->deviations,
                    .decision = {},
                    .false_alarm_chance = step.max_score.p_value,
                    .log_prior = best.fit->log_prior,
                    .times_usual = times_usual(best),
                    .length = best.fit->discriminability,
                    .log_score_gain = best.fit->log_score_gain};
  found.candidate.effect.values = best.fit->values;
  take_decision(step, found);
  return found;
}

const CandidateFit* fit_of(const DiagnosisStep& step, const FoundEffect& found) {
  const std::string name = found.candidate.name();
  const auto own =
      std::find_if(step.ranking.begin(), step.ranking.end(),
                   [&](const RankedCandidate& r) { return r.candidate.name() == name; });
  return own != step.ranking.end() && own->fit ? &*own->fit : nullptr;
}

void confirm(const DiagnosisStep& step, FoundEffect& found) {
  const CandidateFit* own = fit_of(step, found);
  found.false_alarm_chance = step.max_score.p_value;
  found.log_score_gain = own == nullptr ? 0 : own->log_score_gain;
  // Beside another order of its series it does not compete with what the series could be.
  const bool is_beside_order = is_of_series(*found.candidate.effect.kind) &&
                               std::find(step.beside.begin(), step.beside.end(),
                                         found.candidate.name()) != step.beside.end();
  if (own != nullptr && !is_beside_order) take_decision(step, found);
}

bool is_replaced(const DiagnosisStep& step, const FoundEffect& found, double squared_error) {
  if (step.ranking.empty() || !step.ranking[0].fit) return false;
  const CandidateFit& best = *step.ranking[0].fit;
  const CandidateFit* own = fit_of(step, found);
  if (own == nullptr) return squared_error - best.squared_error > 2 * doubtful;
  const double likelier = best.log_evidence - own->log_evidence;
  if (are_laws_of_one_answer(step.ranking[0].candidate, found.candidate))
    return likelier > noticeable;
  return likelier > doubtful && (best.squared_error < own->squared_error ||
                                 best.degrees_of_freedom > own->degrees_of_freedom);
}

}  // namespace kinetostat::calibration

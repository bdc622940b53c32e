#include "kinetostat/calibration/diagnosis/diagnosis.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/campaign/pure_error.h"
#include "kinetostat/calibration/campaign/replicates.h"
#include "kinetostat/calibration/comparison/unit_slip.h"
#include "kinetostat/calibration/diagnosis/outliers.h"
#include "kinetostat/calibration/diagnosis/search.h"
#include "kinetostat/calibration/regression/evidence.h"
#include "kinetostat/calibration/regression/joint_scales.h"
#include "kinetostat/calibration/regression/undetermined.h"
#include "kinetostat/calibration/regression/wrench_noise.h"
#include "kinetostat/common/error.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double significance_of_more = 0.01;  // of a further effect beside one that was found
constexpr double level_of_rest = 0.005;        // of a rest that no effect explains
constexpr double believable_noise = 2;         // times the stated one, to account for a misfit
constexpr std::size_t most_revisions = 8;      // of what was found
constexpr double most_outliers = 0.04;     // of all values: more are something that is not known
constexpr double unexplained_share = 0.3;  // of the misfit: more is another effect, not this one

// So large that nobody has seen one, and no better than an unmodelled smooth error, or it leaves
// much of the misfit.
bool is_absurd(const DiagnosisStep& step) {
  const RankedCandidate& best = step.ranking[0];
  if (times_usual(best) <= unusual) return false;
  const double free_form = step.log_evidence_without + step.free_form.log;
  return best.fit->log_evidence - free_form < doubtful_beside_free_form ||
         step.share_left > unexplained_share;
}

// The length of what the laws of those that were found may get wrong, where that looks like a
// candidate: more of it where both are laws of one joint, or of time and temperature.
double law_error_like(const std::vector<FoundEffect>& found, const Candidate& candidate) {
  constexpr double relative_error = 0.25;
  double most = 0;
  for (const FoundEffect& f : found) {
    const bool relatives = are_laws_of_one_joint(f.candidate, candidate) ||
                           (f.candidate.effect.kind->varies && candidate.effect.kind->varies);
    most = std::max(most, (relatives ? relative_error : law_error) * f.length);
  }
  return most;
}

// A found effect exceeds the detection threshold, and improves the prediction of readings that it
// was not fitted to or is far more probable than no missing effect. Beside another effect it must
// do both, have a higher significance, and not be less likely than an unmodelled smooth error.
bool is_found(const DiagnosisStep& step, const std::vector<FoundEffect>& found) {
  const bool first = step.beside.empty();
  if (step.max_score.p_value > (first ? significance_level : significance_of_more)) return false;
  if (step.indistinguishable.empty()) return false;
  if (is_absurd(step)) return false;
  const RankedCandidate& best = step.ranking[0];
  const bool predicts = best.fit->log_score_gain > best.fit->log_score_deviation;
  const bool probable = best.fit->log_evidence - step.log_evidence_without > doubtful;
  if (first) return predicts || probable;
  return predicts && probable && step.free_form_probability < 0.5 &&
         best.fit->discriminability >= discriminable_from &&
         best.fit->discriminability >= law_error_like(found, best.candidate);
}

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
      found.instead.push_back(step.ranking[answer.laws.front().candidate].candidate.name());
  }
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

std::optional<BaseFit> fit_if_possible(const CandidateFitter& fitter,
                                       const std::vector<Candidate>& added, const BaseFit& start,
                                       common::Progress& progress) {
  return if_possible([&] { return fitter.fit(added, &start, progress); });
}

// Of an effect that was found, in a round; none where it was not fitted there.
const CandidateFit* fit_of(const DiagnosisStep& step, const FoundEffect& found) {
  const std::string name = found.candidate.name();
  const auto own =
      std::find_if(step.ranking.begin(), step.ranking.end(),
                   [&](const RankedCandidate& r) { return r.candidate.name() == name; });
  return own != step.ranking.end() && own->fit ? &*own->fit : nullptr;
}

// What a round beside all the other effects says of one that was found earlier.
void confirm(const DiagnosisStep& step, FoundEffect& found) {
  const CandidateFit* own = fit_of(step, found);
  found.false_alarm_chance = step.max_score.p_value;
  found.log_score_gain = own == nullptr ? 0 : own->log_score_gain;
  take_decision(step, found);
}

// One effect that does the work of several is the likelier one.
void doubt_beside_one(const std::vector<BaseFit>& alone, const DiagnosisStep& first,
                      const BaseFit& together, std::vector<FoundEffect>& found) {
  const double exponent = common_exponent(together, alone);
  const double of_all = evidence(together, exponent).log;
  for (std::size_t c = 0; c < alone.size(); ++c) {
    const std::string name = first.ranking[c].candidate.name();
    if (alone[c].values == 0 || of_all - evidence(alone[c], exponent).log > doubtful) continue;
    for (FoundEffect& f : found)
      if (f.candidate.name() != name &&
          std::find(f.instead.begin(), f.instead.end(), name) == f.instead.end())
        f.instead.push_back(name);
  }
}

// Where no load is taken back or reversed, friction only takes up a part of the load, as a gap
// takes up a part of the way; the details of either law are no evidence.
void doubt_friction(const Campaign& campaign, Diagnosis& d) {
  if (takes_loads_back(campaign)) return;
  for (FoundEffect& found : d.found) {
    if (found.candidate.effect.kind->name != "friction") continue;
    const std::string gap = "clearance at " + found.candidate.effect.at;
    if (std::none_of(found.instead.begin(), found.instead.end(),
                     [&](const std::string& other) { return other.ends_with(gap); }))
      found.instead.push_back(gap);
    d.missing.push_back(
        "loads that are taken back or reversed: without them friction looks like a clearance");
  }
}

// Log evidence of all effects that were found over that of the unmodelled smooth error in their
// place. With independent noise: the residual of a wrong effect looks like correlated noise.
double above_free_form(const BaseFit& without, const std::vector<BaseFit>& alone,
                       const BaseFit& together, const FreeForm& free_form, const Diagnosis& d,
                       FreeFormEvidence& instead) {
  const double exponent = std::max(common_exponent(without, alone), exponent_of(together));
  instead = free_form.evidence({-without.at.residual, without.at.jacobian}, exponent);
  double prior = 0;
  bool is_usual = true;
  for (const FoundEffect& found : d.found) {
    prior += found.log_prior;
    is_usual &= found.times_usual <= unusual;
  }
  return evidence(together, exponent, is_usual ? Sizes::usual : Sizes::any).log + prior -
         evidence(without, exponent).log - instead.log;
}

// Whether there is something more beside all that was found: of the round that looked for it.
void take_rest(Diagnosis& d) {
  std::vector<std::string> names;
  for (const FoundEffect& found : d.found) names.push_back(found.candidate.name());
  const auto step = std::find_if(d.steps.begin(), d.steps.end(), [&](const DiagnosisStep& s) {
    return std::is_permutation(s.beside.begin(), s.beside.end(), names.begin(), names.end());
  });
  if (step == d.steps.end()) return;
  d.rest_p_value = step->max_score.p_value;
  if (step->ranking.empty() || !step->ranking[0].fit) return;
  const RankedCandidate& best = step->ranking[0];
  if (best.fit->discriminability < law_error_like(d.found, best.candidate))
    d.rest_of_laws = best.candidate.name();
}

// Values and deviations of all that was found, from the fit that has all of it.
void take_values(const std::vector<FittedValues>& fitted, std::vector<FoundEffect>& found) {
  for (std::size_t k = 0; k < found.size(); ++k) {
    found[k].candidate.effect.values = fitted[k].values;
    found[k].deviations = fitted[k].deviations;
  }
}

std::optional<ChiSquareTest> test_of(const BaseFit& fit, NoiseSource source) {
  if (source == NoiseSource::unknown || fit.degrees_of_freedom() < 1) return std::nullopt;
  return chi_square_test(fit.squared_error, fit.degrees_of_freedom());
}

// Readings of some values, masked.
Campaign without(const Campaign& campaign, const std::vector<Value>& values,
                 const std::vector<std::size_t>& outliers, std::vector<std::string>& said) {
  Campaign result = campaign;
  for (const std::size_t v : outliers) {
    Reading& reading = result.readings[values[v].reading];
    if (reading.masked) continue;
    reading.masked = true;
    reading.mask_reason = fmt::format(
        "more than {:g} standard deviations from what any effect explains, to first order",
        outlying);
    said.push_back(fmt::format("reading '{}' ({}:{}): {}", reading.id,
                               campaign.readings_file.filename().string(), reading.line,
                               reading.mask_reason));
  }
  return result;
}

bool can_show_anything(const DiagnosisStep& step) {
  return std::any_of(step.ranking.begin(), step.ranking.end(), [](const RankedCandidate& r) {
    return r.detectability >= discriminable_from;
  });
}

// The best candidate of the first round, where it exceeds the detection threshold but only at a
// size that nobody has seen.
std::string absurd_explanation(const Diagnosis& d) {
  if (d.steps.empty() || d.steps[0].indistinguishable.empty()) return {};
  const RankedCandidate& best = d.steps[0].ranking[0];
  if (d.steps[0].max_score.p_value > significance_level || !is_absurd(d.steps[0])) return {};
  return fmt::format(
      "an effect that explains the misfit at a size that makes sense: {} comes nearest, but would "
      "have to be {:.0f} times as large as usual",
      best.candidate.name(), times_usual(best));
}

// The unmodelled smooth error is another law of what was found: of that drive, or over that time or
// temperature.
bool is_other_law(const Diagnosis& d) {
  const std::string& over = d.free_form.depends_on;
  return std::any_of(d.found.begin(), d.found.end(), [&](const FoundEffect& found) {
    const vjm::EffectKind& kind = *found.candidate.effect.kind;
    const std::string& at = found.candidate.effect.at;
    if (kind.name == "session_drift") return over.starts_with("time");
    if (kind.effect_class == vjm::EffectClass::temperature)
      return over.starts_with("time") || over.starts_with("temperature");
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

// `share_left`: of the misfit, by all that was found.
void judge(double share_left, Diagnosis& d) {
  const bool structure_left = d.left.p_value() < structure_level;
  if (d.found.empty()) {
    if (const std::string nearest = absurd_explanation(d); !nearest.empty()) {
      d.verdict = Verdict::unexplained;
      d.missing.push_back(nearest);
    } else if (structure_left || (d.is_left_open() && !d.noise_without_load)) {
      d.verdict = Verdict::unexplained;
    } else if (d.is_left_open()) {
      d.verdict = Verdict::inconclusive;
      d.missing.push_back(fmt::format(
          "how exact readings under load are: only readings without load are repeated, and the "
          "misfit is {:.2g} times what those show; repeat some under load, or state 'noise'",
          std::sqrt(d.after->reduced())));
    } else if (d.common_cause || d.steps.empty() || !can_show_anything(d.steps.front()))
      d.verdict = Verdict::inconclusive;
    else
      d.verdict = Verdict::none_needed;
    return;
  }
  const bool unlike_any = d.above_free_form < beaten_by_free_form && !is_other_law(d);
  d.verdict = unlike_any || (structure_left && share_left > unexplained_share)
                  ? Verdict::unexplained
                  : verdict_on_found(d);
}

// A model that grows by one effect after the other.
struct Model {
  std::vector<Candidate> present;
  BaseFit fit;
  std::vector<BaseFit> alone;  // of models with one effect, in the order of the first ranking
  BaseFit without;             // of the model before anything was added
};

using AddStage = std::function<void(const std::string& name, const BaseFit& fit,
                                    const std::vector<Candidate>& added)>;

// Until nothing more is found. The signatures of the first round are there.
void add_effects(Search& search, const DiagnosisOptions& options, const AddStage& add_stage,
                 Model& model, Diagnosis& d) {
  while (model.present.size() < options.most_effects) {
    if (!model.present.empty()) search.screen(model.present, model.fit);
    std::vector<BaseFit> fits;
    DiagnosisStep step = search.step(model.present, model.fit, fits);
    d.steps.push_back(step);
    if (!is_found(step, d.found)) break;
    model.fit = fits[0];
    if (model.present.empty()) model.alone = std::move(fits);
    model.present.push_back(step.ranking[0].candidate);
    model.present.back().effect.values = step.ranking[0].fit->values;
    d.found.push_back(found_effect(step));
    add_stage("+ " + model.present.back().name(), model.fit, model.present);
  }
}

// One that is not needed beside the others, or in whose place another one is better.
struct Revision {
  std::size_t which = 0;
  BaseFit fit;                              // without it, or with the other one
  std::optional<FoundEffect> instead = {};  // the other one
};

// Something fits better beside the others than the one that is there, and is decidedly likelier.
bool is_better(const DiagnosisStep& step, const FoundEffect& found) {
  const CandidateFit* own = fit_of(step, found);
  if (own == nullptr || !step.ranking[0].fit) return false;
  const CandidateFit &best = *step.ranking[0].fit, &mine = *own;
  return best.log_evidence - mine.log_evidence > doubtful &&
         best.squared_error < mine.squared_error;
}

std::vector<Candidate> all_but(std::vector<Candidate> present, std::size_t k) {
  present.erase(present.begin() + static_cast<std::ptrdiff_t>(k));
  return present;
}

// An effect of which no amplitude exceeds its own standard deviation is none.
bool is_determined(const Candidate& candidate, const FittedValues& fitted) {
  const auto& parameters = candidate.effect.kind->parameters;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const auto i = static_cast<Index>(k);
    const bool is_small = std::abs(fitted.values[i] - parameters[k].none) < fitted.deviations[i];
    if (!parameters[k].is_shape && !is_small) return true;
  }
  return false;
}

std::optional<Revision> without_undetermined(const CandidateFitter& fitter, const Model& model,
                                             common::Progress& progress) {
  const std::vector<FittedValues> fitted = fitted_values(model.fit, model.present);
  for (std::size_t k = 0; k < model.present.size() && model.present.size() > 1; ++k) {
    if (is_determined(model.present[k], fitted[k])) continue;
    const std::vector<Candidate> others = all_but(model.present, k);
    if (auto without = fit_if_possible(fitter, others, model.fit, progress))
      return Revision{k, *std::move(without)};
  }
  return std::nullopt;
}

// With all of them in the model each must still be needed, and the best in its place: of the first
// `count`.
std::optional<Revision> weigh_again(const CandidateFitter& fitter, Search& search,
                                    const Model& model, std::size_t count,
                                    common::Progress& progress, Diagnosis& d) {
  if (auto smaller = without_undetermined(fitter, model, progress)) return smaller;
  for (std::size_t k = 0; k < count; ++k) {
    const std::vector<Candidate> others = all_but(model.present, k);
    std::optional<BaseFit> without_it = fit_if_possible(fitter, others, model.fit, progress);
    if (!without_it) continue;  // then it is needed all the more
    search.screen(others, *without_it);
    std::vector<BaseFit> fits;
    DiagnosisStep step = search.step(others, *without_it, fits);
    const bool needed = step.max_score.p_value <= significance_level;
    if (needed && is_better(step, d.found[k])) {
      d.steps.push_back(step);
      return Revision{k, std::move(fits[0]), found_effect(step)};
    }
    if (needed) confirm(step, d.found[k]);
    d.steps.push_back(std::move(step));
    if (!needed) return Revision{k, *std::move(without_it)};
  }
  return std::nullopt;
}

void revise(Revision revision, const CandidateFitter& fitter, const AddStage& add_stage,
            common::Progress& progress, Model& model, Diagnosis& d) {
  const auto k = static_cast<std::ptrdiff_t>(revision.which);
  model.present.erase(model.present.begin() + k);
  model.fit = std::move(revision.fit);
  d.found.erase(d.found.begin() + k);
  if (revision.instead) {
    model.present.push_back(revision.instead->candidate);
    d.found.push_back(*std::move(revision.instead));
  } else if (d.found.size() == 1)
    confirm(d.steps[0], d.found[0]);
  std::erase_if(d.waterfall, [](const WaterfallStage& s) { return s.name.starts_with("+ "); });
  for (std::size_t n = 1; n <= model.present.size(); ++n) {
    const std::vector<Candidate> first(model.present.begin(),
                                       model.present.begin() + static_cast<std::ptrdiff_t>(n));
    const std::optional<BaseFit> fit =
        n == model.present.size() ? model.fit : fit_if_possible(fitter, first, model.fit, progress);
    if (fit) add_stage("+ " + first.back().name(), *fit, first);
  }
}

// The last one has just been found beside all others, as long as all of these stay. A revision
// makes the model more probable, or smaller: they end.
void eliminate(const CandidateFitter& fitter, Search& search, const AddStage& add_stage,
               common::Progress& progress, Model& model, Diagnosis& d) {
  std::size_t count = model.present.empty() ? 0 : model.present.size() - 1;
  for (std::size_t revisions = 0; revisions < most_revisions; ++revisions) {
    auto revision = weigh_again(fitter, search, model, count, progress, d);
    if (!revision) return;
    revise(*std::move(revision), fitter, add_stage, progress, model, d);
    count = model.present.size() > 1 ? model.present.size() : 0;
  }
}

// Two effects that hide one another: neither passes alone, each does beside the other.
void find_masked_pair(const CandidateFitter& fitter, Search& search, const AddStage& add_stage,
                      common::Progress& progress, Model& model, Diagnosis& d) {
  for (std::vector<Candidate> pair : search.masked_pairs(model.fit)) {
    const std::optional<BaseFit> both = fit_if_possible(fitter, pair, model.fit, progress);
    if (!both) continue;
    std::vector<DiagnosisStep> steps;
    std::vector<FoundEffect> found;
    std::optional<BaseFit> beside;  // in the end with the first alone
    for (const Candidate& other : {pair[1], pair[0]}) {
      beside = fit_if_possible(fitter, {other}, *both, progress);
      if (!beside) break;
      search.screen({other}, *beside);
      std::vector<BaseFit> fits;
      steps.push_back(search.step({other}, *beside, fits));
      if (!is_found(steps.back(), found)) break;
      found.push_back(found_effect(steps.back()));
    }
    if (found.size() < 2 || found[0].candidate.name() != pair[0].name() ||
        found[1].candidate.name() != pair[1].name())
      continue;
    d.steps.insert(d.steps.end(), steps.begin(), steps.end());
    d.found = std::move(found);
    model.present = std::move(pair);
    model.fit = *both;
    add_stage("+ " + model.present[0].name(), *beside, {model.present[0]});
    add_stage("+ " + model.present[1].name(), model.fit, model.present);
    return;
  }
}

void list_ambiguous(Diagnosis& d) {
  for (const FoundEffect& found : d.found) {
    if (found.instead.empty() && found.decision.is_identified && !d.or_something_else) continue;
    d.ambiguous.push_back(found.candidate.name());
    d.ambiguous.insert(d.ambiguous.end(), found.instead.begin(), found.instead.end());
  }
}

// The model that is written, against all readings, those that were set aside included.
void add_as_adopted(const CandidateFitter& all, const Search& whole_search,
                    const DiagnosisOptions& options, std::size_t uncertain, const Model& model,
                    common::Progress& progress, Diagnosis& d) {
  const std::vector<ParameterEstimate>& found = model.fit.parameters;
  d.fitted_beside.assign(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(uncertain));
  const std::optional<BaseFit> written =
      if_possible([&] { return all.as_fitted(model.present, model.fit, progress); });
  if (written)
    d.waterfall.push_back(waterfall_stage(as_adopted, -written->at.residual, whole_search.values(),
                                          all.noise(), whole_search.groups(), options.seed));
}

Diagnosis cannot_tell_without_noise() {
  Diagnosis d;
  d.missing.push_back(
      "how exact the readings are: state the instrument's noise in the campaign file, or repeat "
      "readings under the same load; noise is never taken from the misfit of the model itself");
  return d;
}

}  // namespace

bool Diagnosis::is_left_open() const {
  return after && after->reduced() > believable_noise * believable_noise;
}

bool Diagnosis::predicts_no_better() const {
  return std::any_of(found.begin(), found.end(),
                     [](const FoundEffect& f) { return !(f.log_score_gain > 0); });
}

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
  for (const auto& [name, kind] : kinds)
    if (kind.detectability < discriminable_from) unseen.push_back(kind);
  for (const KindWithoutPlace& kind : diagnosis.without_place)
    unseen.push_back({.name = kind.name, .reason = kind.reason});
  std::sort(unseen.begin(), unseen.end(),
            [](const UnseenKind& a, const UnseenKind& b) { return a.name < b.name; });
  return unseen;
}

Diagnosis diagnose(const vjm::Robot& robot, const Campaign& whole, const DiagnosisOptions& options,
                   int threads, common::Progress& progress) {
  const Campaign given = only(whole, {Role::fit, Role::select});
  const Noise noise = noise_of(robot, whole, threads, progress);
  if (noise.source == NoiseSource::unknown) return cannot_tell_without_noise();
  Diagnosis d;
  d.noise = noise.source;
  d.noise_without_load = noise.only_unloaded;
  const CandidateFitter all(robot, given, noise, threads, progress, options.journal);
  const vjm::JointScales scales =
      joint_scales(all.predictor(), robot.without_effects(), given, progress);
  const std::vector<Candidate> tried = candidates(robot, options.kinds, scales);
  d.without_place = kinds_without_place(robot, options.kinds, scales);
  Search whole_search(all, tried, options, threads, progress);
  BaseFit fit = with_hint_of_unit_error(all.predictor(), given, progress,
                                        [&] { return all.fit({}, nullptr, progress); });
  whole_search.screen({}, fit);
  std::vector<std::size_t> outliers = whole_search.outliers(fit);
  if (static_cast<double>(outliers.size()) >
      most_outliers * static_cast<double>(whole_search.values().size())) {
    d.far_values = outliers.size();
    outliers.clear();
  }
  const Campaign campaign = without(given, whole_search.values(), outliers, d.set_aside);
  const CandidateFitter fitter(robot, campaign, noise, threads, progress, options.journal);
  Search search(fitter, tried, options, threads, progress);
  search.take_signatures(whole_search);
  if (!d.set_aside.empty()) fit = fitter.fit({}, &fit, progress);
  search.prepare_free_form(fit);
  d.before = test_of(fit, noise.source);
  d.noise_check =
      test_of_stated_noise(pure_error(campaign, replicate_groups(campaign), noise), noise);
  d.weak = fitter.kept_nominal();
  if (is_held_near_design(fit))
    d.weak.push_back(
        "With no effect added, the best value of some stiffness is infinite or 0: all "
        "that are uncertain are fitted as known by design to a factor of 2.7, one standard "
        "deviation.");
  d.weak.insert(d.weak.end(), fit.weak.begin(), fit.weak.end());
  d.held_out = search.groups().what;
  const Campaign kept = only(whole, {Role::confirm});
  const auto add_stage = [&](const std::string& name, const BaseFit& stage,
                             const std::vector<Candidate>& added) {
    d.waterfall.push_back(
        waterfall_stage(name, stage, search.values(), noise, search.groups(), options.seed));
    if (has_role(whole, Role::confirm))
      d.waterfall.back().confirmed = fitter.error_on(kept, stage, added, progress);
  };
  const BaseFit nominal = fit_base(fitter.predictor(), campaign, noise, {}, progress);
  d.unit_error = unit_error(campaign, nominal.predicted);
  add_stage("as designed", nominal, {});
  if (!fit.parameters.empty()) add_stage("refitted", fit, {});
  Model model{.present = {}, .fit = fit, .alone = {}, .without = fit};
  add_effects(search, options, add_stage, model, d);
  const std::vector<Candidate> candidates = d.found.empty() && refutes_nominal(nominal, fit)
                                                ? search.like_the_fit(nominal, fit)
                                                : std::vector<Candidate>();
  if (d.found.empty() && d.steps[0].max_score.p_value > significance_level &&
      options.most_effects > 1)
    find_masked_pair(fitter, search, add_stage, progress, model, d);
  else
    eliminate(fitter, search, add_stage, progress, model, d);
  if (model.present.size() > 1) doubt_beside_one(model.alone, d.steps[0], model.fit, d.found);
  if (d.found.empty())
    d.common_cause = common_cause(robot, campaign, noise, fit, nominal, candidates, threads,
                                  progress, options.journal);
  d.after = test_of(model.fit, noise.source);
  if (!d.found.empty()) {
    d.above_free_form =
        above_free_form(model.without, model.alone, model.fit, search.free_form(), d, d.free_form);
    take_rest(d);
    d.or_something_else = (d.rest_p_value < level_of_rest && d.rest_of_laws.empty()) ||
                          d.is_left_open() || d.predicts_no_better();
  }
  take_values(fitted_values(model.fit, model.present), d.found);
  doubt_friction(campaign, d);
  list_ambiguous(d);
  d.fitted_without = fit.parameters;
  if (!d.found.empty())
    add_as_adopted(all, whole_search, options, fit.parameters.size(), model, progress, d);
  d.waterfall.push_back(noise_floor(search.values(), noise));
  d.left = search.free_form().evidence({-model.fit.at.residual, model.fit.at.jacobian},
                                       exponent_of(model.fit));
  d.left.log -= search.correlated_noise().gain(model.fit);
  if (const auto way = search.correlated_noise().prevailing(model.fit))
    d.correlated_noise = search.correlated_noise().what(*way);
  judge(search.correlated_noise().share_left(model.without, model.fit), d);
  if (d.verdict != Verdict::inconclusive) d.common_cause.reset();
  if (options.profiles > 0)
    d.profiles = profiles(fitter, model.present, model.fit, options.profiles, progress);
  return d;
}

}  // namespace kinetostat::calibration

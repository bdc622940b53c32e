#include "kinetostat/calibration/diagnosis/growth.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <string>

#include "kinetostat/calibration/regression/evidence.h"
#include "kinetostat/calibration/search/pair_screen.h"
#include "kinetostat/calibration/statistics/goodness_of_fit.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;

constexpr std::size_t most_revisions = 8;  // of what was found
constexpr std::size_t most_additions = 3;  // after revisions

// One that is not needed beside the others, or in whose place another one is better.
struct Revision {
  std::size_t which = 0;
  BaseFit fit;                              // without it, or with the other one
  std::optional<FoundEffect> instead = {};  // the other one
};

std::vector<Candidate> all_but(std::vector<Candidate> present, std::size_t k) {
  present.erase(present.begin() + static_cast<std::ptrdiff_t>(k));
  return present;
}

// An effect of which no amplitude exceeds its own standard deviation is none. At a bound it has no
// deviation.
bool is_determined(const Candidate& candidate, const FittedValues& fitted) {
  const auto& parameters = candidate.effect.kind->parameters;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const auto i = static_cast<Index>(k);
    const bool is_small = fitted.values[i] == parameters[k].none ||
                          std::abs(fitted.values[i] - parameters[k].none) < fitted.deviations[i];
    if (!parameters[k].is_shape && !is_small) return true;
  }
  return false;
}

class Grower {
 public:
  Grower(const CandidateFitter& fitter, const HeldOutRefit& refit, Search& search,
         const DiagnosisOptions& options, const BaseFit& fit, common::Progress& progress)
      : fitter_(fitter), refit_(refit), search_(search), options_(options), progress_(progress) {
    model_.fit = model_.without = fit;
  }

  // Until nothing more is found. The signatures of the first round are there. Parts of what is
  // missing stay where all of them together leave nothing, and one of an absurd size only beside
  // others. Whether anything was added.
  bool add_effects() {
    const std::size_t before = found_.size();
    std::size_t whole = before;  // so many of those found, the last of which is no part
    while (model_.present.size() < options_.most_effects) {
      if (!model_.present.empty()) search_.screen(model_.present, model_.fit);
      std::vector<BaseFit> fits;
      DiagnosisStep step = search_.step(model_.present, model_.fit, fits);
      check_prediction(model_.present, model_.fit, fits, step);
      if (!fits.empty()) step.shared = shared_with(fits[0]);
      grown_.steps.push_back(step);
      const Finding what = finding(step, found_);
      if (what == Finding::nothing) break;
      if (what == Finding::effect) whole = found_.size() + 1;
      model_.fit = fits[0];
      model_.stages.emplace_back(fits[0]);
      if (model_.present.empty()) keep_alone(std::move(fits));
      model_.present.push_back(step.ranking[0].candidate);
      model_.present.back().effect.values = step.ranking[0].fit->values;
      found_.push_back(found_effect(step));
    }
    const bool is_absurd_alone = whole == 0 && found_.size() == 1 && is_absurd(grown_.steps[0]);
    if (whole < found_.size() && (is_absurd_alone || leaves_something())) keep_first(whole);
    return found_.size() > before;
  }

  bool may_hide_a_pair() const {
    return grown_.steps[0].max_score.p_value > significance_level && options_.most_effects > 1 &&
           (found_.empty() || is_doubted());
  }

  // The best of the first round may stand for several, and be none of them: another one may be.
  void start_again() {
    if (found_.empty() || options_.most_effects < 2) return;
    std::vector<std::size_t> starts = starts_of_pairs();
    if (!is_above_smooth_error() || leaves_rest())
      for (const std::size_t c : other_starts())
        if (std::find(starts.begin(), starts.end(), c) == starts.end()) starts.push_back(c);
    const Model model = model_;
    const std::vector<FoundEffect> found = found_;
    const std::size_t steps = grown_.steps.size();
    for (const std::size_t c : starts) {
      if (grows_from(c) && explains_all() && log_odds_over(model, found) > doubtful) return;
      model_ = model;
      found_ = found;
      grown_.steps.resize(steps);
    }
  }

  // Two effects that hide one another: neither passes alone, each does beside the other. One that
  // comes near the threshold, but is less probable than nothing, goes.
  void find_masked_pair() {
    if (!found_.empty()) search_.screen({}, model_.without);
    give_up_doubted();
    for (std::vector<Candidate> pair : search_.masked_pairs(model_.fit)) {
      const std::optional<BaseFit> both = fit_if_possible(fitter_, pair, model_.fit, progress_);
      if (!both) continue;
      std::vector<DiagnosisStep> steps;
      std::vector<FoundEffect> found;
      std::optional<BaseFit> beside;  // in the end with the first alone
      for (const Candidate& other : {pair[1], pair[0]}) {
        beside = fit_if_possible(fitter_, {other}, *both, progress_);
        if (!beside) break;
        search_.screen({other}, *beside);
        std::vector<BaseFit> fits;
        steps.push_back(search_.step({other}, *beside, fits));
        if (finding(steps.back(), found) != Finding::effect) break;
        found.push_back(found_effect(steps.back()));
      }
      if (found.size() < 2 || found[0].candidate.name() != pair[0].name() ||
          found[1].candidate.name() != pair[1].name())
        continue;
      grown_.steps.insert(grown_.steps.end(), steps.begin(), steps.end());
      found_ = std::move(found);
      model_.present = std::move(pair);
      model_.fit = *both;
      model_.stages = {beside, both};
      return;
    }
  }

  // The last one has just been found beside all others, as long as all of these stay. A revision
  // makes the model more probable, or smaller: they end. Whether there was one.
  bool eliminate() {
    std::size_t count = model_.present.empty() ? 0 : model_.present.size() - 1;
    for (std::size_t revisions = 0; revisions < most_revisions; ++revisions) {
      auto revision = weigh_again(count);
      if (!revision) return revisions > 0;
      revise(*std::move(revision));
      count = model_.present.size() > 1 ? model_.present.size() : 0;
    }
    return true;
  }

  // What a revision has taken out may be missing beside what is in the model now: until a model
  // comes again.
  void eliminate_and_add() {
    std::set<std::vector<std::string>> seen;
    for (std::size_t times = 0; times < most_additions && eliminate(); ++times) {
      if (model_.present.empty() || !add_effects()) return;
      std::vector<std::string> names = names_of(model_.present);
      std::sort(names.begin(), names.end());
      if (!seen.insert(std::move(names)).second) return;
    }
  }

  // What exceeds the detection threshold may still be less probable than that nothing is missing.
  void give_up_doubted() {
    if (!is_doubted()) return;
    if (found_[0].false_alarm_chance <= significance_level) grown_.doubted = std::move(found_[0]);
    found_.clear();
    model_.present.clear();
    model_.stages.clear();
    model_.fit = model_.without;
  }

  Growth result() && {
    grown_.model = std::move(model_);
    grown_.found = std::move(found_);
    return std::move(grown_);
  }

 private:
  bool is_doubted() const { return found_.size() == 1 && found_[0].decision.is_none_needed; }

  // An unmodelled smooth error beside all that was found is more likely than none.
  bool leaves_something() const { return smooth_error_beside(model_.fit, search_).log > 0; }

  // More than noise and what their laws may get wrong, beside all that was found.
  bool leaves_rest() const {
    const DiagnosisStep* step = round_beside(found_, grown_.steps);
    return step != nullptr && step->max_score.p_value < level_of_rest &&
           !is_rest_of_laws(found_, *step);
  }

  // Several effects, each of them more likely than an unmodelled smooth error, and all together.
  bool explains_all() const {
    return found_.size() > 1 && is_above_smooth_error() && !leaves_something() &&
           std::all_of(found_.begin(), found_.end(),
                       [](const FoundEffect& f) { return f.decision.unexplained < 0.5; });
  }

  // Or there is nothing that one could explain.
  bool is_above_smooth_error() const {
    FreeFormEvidence instead;
    return above_free_form(model_, found_, search_, instead) >= beaten_by_free_form;
  }

  // From candidate c of the first round alone; false where that has no fit now.
  bool grows_from(std::size_t c) {
    DiagnosisStep first = grown_.steps[0];
    std::swap(first.ranking[0], first.ranking[c]);
    Candidate start = first.ranking[0].candidate;
    start.effect.values = first.ranking[0].fit->values;
    std::optional<BaseFit> fit = fit_if_possible(fitter_, {start}, model_.without, progress_);
    if (!fit) return false;
    model_.present = {start};
    model_.fit = *fit;
    model_.stages = {std::move(fit)};
    found_ = {found_effect(first)};
    add_effects();
    eliminate_and_add();
    return true;
  }

  // Candidates of the first round that are more significant than what was found there, or
  // significant at the same joint: hysteresis and a gap look like creep. The most significant
  // first.
  std::vector<std::size_t> other_starts() const {
    constexpr std::size_t most = 2;
    const std::vector<RankedCandidate>& ranking = grown_.steps[0].ranking;
    std::vector<std::size_t> starts;
    for (std::size_t c = 1; c < ranking.size(); ++c) {
      const double least = act_at_one_joint(ranking[c].candidate, ranking[0].candidate) ? 0.5 : 1;
      if (ranking[c].fit && ranking[c].significance > least * ranking[0].significance)
        starts.push_back(c);
    }
    std::stable_sort(starts.begin(), starts.end(), [&](std::size_t a, std::size_t b) {
      return ranking[a].significance > ranking[b].significance;
    });
    starts.resize(std::min(starts.size(), most));
    return starts;
  }

  // Where two effects promise to explain more than what was found in their place: of each such pair
  // the one that is likelier alone, but for what the rounds started from.
  std::vector<std::size_t> starts_of_pairs() const {
    constexpr std::size_t most = 2;
    const std::vector<RankedCandidate>& ranking = grown_.steps[0].ranking;
    std::vector<std::size_t> starts;
    for (const CandidatePair& pair : grown_.steps[0].pairs) {
      if (starts.size() == most || !promises_more(pair)) continue;
      const auto start = std::find_if(ranking.begin() + 1, ranking.end(), [&](const auto& ranked) {
        return ranked.fit && (ranked.candidate.name() == pair.names[0] ||
                              ranked.candidate.name() == pair.names[1]);
      });
      const auto c = static_cast<std::size_t>(start - ranking.begin());
      if (start != ranking.end() && std::find(starts.begin(), starts.end(), c) == starts.end())
        starts.push_back(c);
    }
    return starts;
  }

  // To first order; but for what the rounds have seen beside what is there.
  bool promises_more(const CandidatePair& pair) const {
    if (std::all_of(found_.begin(), found_.end(), [&](const FoundEffect& f) {
          return f.candidate.name() == pair.names[0] || f.candidate.name() == pair.names[1];
        }))
      return false;
    const BaseFit &without = model_.without, &with = model_.fit;
    const double more = promise(pair.explained, pair.columns, with.values) -
                        promise(without.squared_error - with.squared_error,
                                with.estimated - without.estimated, with.values);
    return 0.5 * exponent_of(with) * more > doubtful;
  }

  void keep_first(std::size_t count) {
    model_.present.erase(model_.present.begin() + static_cast<std::ptrdiff_t>(count),
                         model_.present.end());
    model_.stages.resize(count);
    model_.fit = count == 0 ? model_.without : *model_.stages.back();
    found_.erase(found_.begin() + static_cast<std::ptrdiff_t>(count), found_.end());
  }

  // What a fit with one more effect shares with each that is present.
  std::vector<double> shared_with(const BaseFit& next) const {
    std::vector<double> shared;
    if (model_.stages.size() != model_.present.size()) return shared;
    const Eigen::ArrayXd own = (model_.fit.at.residual - next.at.residual).array().abs();
    const BaseFit* before = &model_.without;
    for (const std::optional<BaseFit>& stage : model_.stages) {
      if (!stage) return {};
      const Eigen::ArrayXd its = (before->at.residual - stage->at.residual).array().abs();
      const double lengths = own.matrix().norm() * its.matrix().norm();
      shared.push_back(lengths > 0 ? (own * its).sum() / lengths : 1);
      before = &*stage;
    }
    return shared;
  }

  // Without their states, which are most of what they take: no fit starts there.
  void keep_alone(std::vector<BaseFit> fits) {
    for (BaseFit& fit : fits) fit.model = {};
    model_.alone = std::move(fits);
  }

  // Something that is far more probable than nothing must predict, too: where it seems not to, by
  // the linear model about its fit, it is fitted anew without the readings that it predicts.
  void check_prediction(std::vector<Candidate> present, const BaseFit& without,
                        const std::vector<BaseFit>& fits, DiagnosisStep& step) const {
    if (step.ranking.empty() || !step.ranking[0].fit) return;
    CandidateFit& best = *step.ranking[0].fit;
    if (!step.is_worth_a_look() || best.log_score_gain > best.log_score_deviation ||
        best.log_evidence - step.log_evidence_without <= doubtful)
      return;
    const auto plain = refit_.error(present, without, progress_);
    present.push_back(step.ranking[0].candidate);
    present.back().effect.values = best.values;
    if (!plain) return;
    if (const auto with = refit_.error(present, fits[0], progress_))
      refit_.score(*plain, *with, best);
  }

  // With all of them in the model each must still be needed, and the best in its place: of the
  // first `count`.
  std::optional<Revision> weigh_again(std::size_t count) {
    if (auto smaller = without_undetermined()) return smaller;
    for (std::size_t k = 0; k < count; ++k) {
      const std::vector<Candidate> others = all_but(model_.present, k);
      std::optional<BaseFit> without_it = fit_if_possible(fitter_, others, model_.fit, progress_);
      if (!without_it) continue;  // then it is needed all the more
      search_.screen(others, *without_it);
      std::vector<BaseFit> fits;
      const auto known = known_fit(others, k);
      DiagnosisStep step = search_.step(others, *without_it, fits, known ? &*known : nullptr);
      check_prediction(others, *without_it, fits, step);
      const bool needed =
          log_odds_over(*without_it) > 3 * doubtful ||
          (step.max_score.p_value <= significance_level && !decide(step).is_none_needed);
      if (needed && is_replaced(step, found_[k], model_.fit.squared_error)) {
        grown_.steps.push_back(step);
        return Revision{k, std::move(fits[0]), found_effect(step)};
      }
      if (needed) confirm(step, found_[k]);
      grown_.steps.push_back(std::move(step));
      if (!needed) return Revision{k, *std::move(without_it)};
    }
    return std::nullopt;
  }

  // That of the model, with one of its effects behind the others. Of a series the round seeks
  // another order.
  std::optional<KnownFit> known_fit(std::vector<Candidate> others, std::size_t k) const {
    const Candidate& own = model_.present[k];
    if (is_of_series(*own.effect.kind)) return std::nullopt;
    others.push_back(own);
    auto fit = fit_if_possible(fitter_, others, model_.fit, progress_);
    return fit ? std::optional(KnownFit{own.name(), *std::move(fit)}) : std::nullopt;
  }

  // Values that only together are known, as those of a spring and its arms, may still be needed.
  std::optional<Revision> without_undetermined() const {
    const std::vector<FittedValues> fitted = fitted_values(model_.fit, model_.present);
    for (std::size_t k = 0; k < model_.present.size() && model_.present.size() > 1; ++k) {
      if (is_determined(model_.present[k], fitted[k])) continue;
      auto without_it = fit_if_possible(fitter_, all_but(model_.present, k), model_.fit, progress_);
      if (without_it && log_odds_over(*without_it) <= doubtful)
        return Revision{k, *std::move(without_it)};
    }
    return std::nullopt;
  }

  // Of what is there over another model, with the priors of kinds and places.
  double log_odds_over(const Model& model, const std::vector<FoundEffect>& found) const {
    const auto prior = [](double sum, const FoundEffect& one) { return sum + one.log_prior; };
    return log_odds_over(model.fit) + std::accumulate(found_.begin(), found_.end(), 0.0, prior) -
           std::accumulate(found.begin(), found.end(), 0.0, prior);
  }

  // Signatures, at usual sizes, may miss what a law with corners does where it was fitted.
  double log_odds_over(const BaseFit& smaller) const {
    const double exponent = common_exponent(smaller, {model_.fit});
    return evidence(model_.fit, exponent).log - evidence(smaller, exponent).log;
  }

  void revise(Revision revision) {
    const auto k = static_cast<std::ptrdiff_t>(revision.which);
    model_.present.erase(model_.present.begin() + k);
    model_.fit = std::move(revision.fit);
    found_.erase(found_.begin() + k);
    if (revision.instead) {
      model_.present.push_back(revision.instead->candidate);
      found_.push_back(*std::move(revision.instead));
    } else if (found_.size() == 1) {
      confirm(grown_.steps[0], found_[0]);
    }
    model_.stages.clear();
    for (std::size_t n = 1; n < model_.present.size(); ++n)
      model_.stages.push_back(fit_if_possible(
          fitter_,
          {model_.present.begin(), model_.present.begin() + static_cast<std::ptrdiff_t>(n)},
          model_.fit, progress_));
    if (!model_.present.empty()) model_.stages.emplace_back(model_.fit);
  }

  const CandidateFitter& fitter_;
  const HeldOutRefit& refit_;
  Search& search_;
  const DiagnosisOptions& options_;
  common::Progress& progress_;
  Model model_;
  std::vector<FoundEffect> found_;
  Growth grown_;
};

// One effect that does the work of several is the likelier one.
void doubt_beside_one(const std::vector<BaseFit>& alone, const DiagnosisStep& first,
                      const BaseFit& together, std::vector<FoundEffect>& found) {
  const double exponent = common_exponent(together, alone);
  const double of_all = evidence(together, exponent).log;
  for (std::size_t c = 0; c < alone.size(); ++c) {
    const Candidate& one = first.ranking[c].candidate;
    if (alone[c].values == 0 || of_all - evidence(alone[c], exponent).log > doubtful) continue;
    for (FoundEffect& f : found)
      if (f.candidate.name() != one.name() &&
          std::none_of(f.instead.begin(), f.instead.end(),
                       [&](const Candidate& other) { return other.name() == one.name(); }))
        f.instead.push_back(one);
  }
}

}  // namespace

std::optional<BaseFit> fit_if_possible(const CandidateFitter& fitter,
                                       const std::vector<Candidate>& added, const BaseFit& start,
                                       common::Progress& progress) {
  return if_possible([&] { return fitter.fit(added, &start, progress); });
}

double above_free_form(const Model& model, const std::vector<FoundEffect>& found,
                       const Search& search, FreeFormEvidence& instead) {
  const BaseFit& without = model.without;
  const double exponent = std::max(common_exponent(without, model.alone), exponent_of(model.fit));
  instead = search.free_form().evidence({-without.at.residual, without.at.jacobian}, exponent);
  double prior = 0;
  bool is_usual = true;
  for (const FoundEffect& one : found) {
    prior += one.log_prior;
    is_usual &= one.times_usual <= unusual;
  }
  return evidence(model.fit, exponent, is_usual ? Sizes::usual : Sizes::any).log + prior -
         evidence(without, exponent).log - instead.log;
}

FreeFormEvidence smooth_error_beside(const BaseFit& fit, const Search& search) {
  FreeFormEvidence left =
      search.free_form().evidence({-fit.at.residual, fit.at.jacobian}, exponent_of(fit));
  left.log -= search.correlated_noise().gain(fit);
  return left;
}

Growth grow(const CandidateFitter& fitter, const HeldOutRefit& refit, Search& search,
            const DiagnosisOptions& options, const BaseFit& fit, common::Progress& progress) {
  Grower grower(fitter, refit, search, options, fit, progress);
  grower.add_effects();
  if (grower.may_hide_a_pair())
    grower.find_masked_pair();
  else
    grower.eliminate_and_add();
  grower.start_again();
  grower.give_up_doubted();
  Growth grown = std::move(grower).result();
  if (grown.model.present.size() > 1)
    doubt_beside_one(grown.model.alone, grown.steps[0], grown.model.fit, grown.found);
  return grown;
}

}  // namespace kinetostat::calibration

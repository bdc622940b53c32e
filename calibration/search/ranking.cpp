#include "kinetostat/calibration/search/ranking.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "kinetostat/calibration/regression/evidence.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Gain of the held-out score, and its standard error.
void score(const HeldOut& plain, const HeldOut& with, CandidateFit& fit) {
  fit.log_score_gain = with.total() - plain.total();
  double squares = 0;
  const auto groups = static_cast<double>(plain.log_score.size());
  for (std::size_t g = 0; g < plain.log_score.size(); ++g)
    squares += std::pow(with.log_score[g] - plain.log_score[g] - fit.log_score_gain / groups, 2);
  fit.log_score_deviation = groups > 1 ? std::sqrt(squares * groups / (groups - 1)) : 0;
}

CandidateFit candidate_fit(const BaseFit& full, const Candidate& candidate, double exponent,
                           const HeldOutGroups& groups, const HeldOut& plain) {
  const FittedValues fitted = fitted_values(full, {candidate}).front();
  const Evidence known = evidence(full, exponent);
  CandidateFit fit{.values = fitted.values,
                   .deviations = fitted.deviations,
                   .squared_error = full.squared_error,
                   .degrees_of_freedom = full.degrees_of_freedom(),
                   .log_evidence = known.log};
  score(plain, held_out(full.at, known.information, groups, exponent), fit);
  return fit;
}

void share_probability(DiagnosisStep& step) {
  const double free_form = step.log_evidence_without + step.free_form.log;
  double most = free_form, sum = 0;
  for (const RankedCandidate& ranked : step.ranking)
    if (ranked.fit) most = std::max(most, ranked.fit->log_evidence);
  const auto share = [&](double log) { return std::exp(learning_rate * (log - most)); };
  sum += share(free_form);
  for (const RankedCandidate& ranked : step.ranking)
    if (ranked.fit) sum += share(ranked.fit->log_evidence);
  step.free_form_probability = share(free_form) / sum;
  for (RankedCandidate& ranked : step.ranking)
    if (ranked.fit) ranked.fit->probability = share(ranked.fit->log_evidence) / sum;
}

// Part of the signature of one candidate that the others do not have: as they are fitted, or with a
// small change of that (large signatures are curved).
void distinguish(const BaseFit& without, const std::vector<const BaseFit*>& fits, std::size_t from,
                 DiagnosisStep& step) {
  const VectorXd& best = fits[from]->at.residual;
  const VectorXd signature = best - without.at.residual;
  for (std::size_t c = 0; c < fits.size(); ++c) {
    if (!step.ranking[c].fit) continue;
    double& discriminability = step.ranking[c].fit->discriminability;
    discriminability = signature.norm();
    if (c == from) continue;
    const Linearisation& at = fits[c]->at;
    const VectorXd left =
        ResidualSpace(VectorXd::Zero(signature.size()), at.jacobian).left_of(signature);
    discriminability = std::min(left.norm(), (best - at.residual).norm());
  }
}

// Every kind is as likely as the others, and so are its places, and its designs at each.
double log_prior(const DiagnosisStep& step, const RankedCandidate& ranked) {
  const auto places =
      std::count_if(step.ranking.begin(), step.ranking.end(), [&](const RankedCandidate& other) {
        return other.candidate.effect.kind == ranked.candidate.effect.kind;
      });
  return -std::log(static_cast<double>(places) * static_cast<double>(ranked.candidate.designs));
}

// One order more, any of the others that its design may have: where that is the likelier.
bool take_order(const BaseFit& with_order, double exponent, const CorrelatedNoise& correlated,
                RankedCandidate& ranked) {
  if (with_order.values == 0) return false;
  const auto others = static_cast<double>(ranked.candidate.designs) - 1;
  const double log_evidence = evidence(with_order, exponent).log + correlated.gain(with_order) +
                              ranked.fit->log_prior - std::log(others);
  if (!(log_evidence > ranked.fit->log_evidence)) return false;
  ranked.fit->log_evidence = log_evidence;
  ranked.fit->squared_error = with_order.squared_error;
  ranked.fit->degrees_of_freedom = with_order.degrees_of_freedom();
  return true;
}

// The most probable first; where only rounding differs, the most significant.
std::vector<std::size_t> order_of(const DiagnosisStep& step) {
  std::vector<std::size_t> order(step.ranking.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto key = [&](std::size_t i) {
    constexpr double rounding = 1e-6;  // of log evidence
    const RankedCandidate& r = step.ranking[i];
    return std::tuple(r.fit                    ? 0
                      : r.unobservable.empty() ? 1
                                               : 2,
                      r.fit ? -std::round(r.fit->log_evidence / rounding) : 0, -r.significance);
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  return order;
}

// The number of candidates when none has a fit.
std::size_t most_probable(const DiagnosisStep& step) {
  const std::vector<std::size_t> order = order_of(step);
  return order.empty() || !step.ranking[order[0]].fit ? order.size() : order[0];
}

// A value at the end of its range, which design has not put there.
bool at_a_bound(const RankedCandidate& ranked) {
  const auto& parameters = ranked.candidate.effect.kind->parameters;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const double value = ranked.fit->values[static_cast<Index>(k)];
    if (parameters[k].usual_angular.empty() && value != parameters[k].none &&
        (value == parameters[k].lower || value == parameters[k].upper))
      return true;
  }
  return false;
}

// Whether readings leave open which of two fitted candidates it is. How much more the prior likes
// the one is no reason to drop the other. Laws are idealisations: two of one joint are
// distinguished by more than a tenth of what they do, and one at the end of its range stands for a
// relative.
bool leaves_open(const DiagnosisStep& step, const RankedCandidate& best,
                 const RankedCandidate& other) {
  const bool relatives = are_laws_of_one_joint(best.candidate, other.candidate);
  const double limit =
      std::hypot(discriminable_from, relatives ? law_error * best.fit->discriminability : 0.0);
  const double worse = other.fit->squared_error - best.fit->squared_error;
  if (best.fit->log_evidence - other.fit->log_evidence < doubtful) return true;
  if (other.fit->discriminability < limit && worse < limit * limit) return true;
  const double explained = step.squared_error_without - best.fit->squared_error;
  return relatives && at_a_bound(best) && worse < explained / 2;
}

// Candidates of the first in the ranking that may be what is really missing.
std::vector<std::size_t> indistinguishable(const DiagnosisStep& step) {
  std::vector<std::size_t> set;
  if (step.ranking.empty() || !step.ranking[0].fit) return set;
  set.push_back(0);
  for (std::size_t i = 1; i < step.ranking.size(); ++i) {
    const RankedCandidate& ranked = step.ranking[i];
    const bool imitates = ranked.falls_short.value_or(2 * doubtful) < 2 * doubtful;
    if (imitates || (ranked.fit && leaves_open(step, step.ranking[0], ranked))) set.push_back(i);
  }
  return set;
}

}  // namespace

bool act_at_one_joint(const Candidate& a, const Candidate& b) {
  const auto is_at_joint = [](const Candidate& c) {
    return c.effect.kind->place == vjm::EffectPlace::joint;
  };
  const auto shared = [&](const vjm::EffectSite& x) {
    return std::any_of(b.effect.sites.begin(), b.effect.sites.end(), [&](const vjm::EffectSite& y) {
      return x.chain == y.chain && x.element == y.element;
    });
  };
  return is_at_joint(a) && is_at_joint(b) &&
         std::any_of(a.effect.sites.begin(), a.effect.sites.end(), shared);
}

bool are_laws_of_one_joint(const Candidate& a, const Candidate& b) {
  return a.effect.kind->history == 0 && b.effect.kind->history == 0 && act_at_one_joint(a, b);
}

double times_usual(const RankedCandidate& ranked) {
  return times_usual(ranked.candidate, ranked.fit->values);
}

double common_exponent(const BaseFit& without, const std::vector<BaseFit>& fits) {
  double exponent = exponent_of(without);
  for (const BaseFit& fit : fits)
    if (fit.values > 0) exponent = std::max(exponent, exponent_of(fit));
  return exponent;
}

std::size_t weigh(const BaseFit& without, const CandidateFits& all, const HeldOutGroups& groups,
                  const FreeForm& free_form, const CorrelatedNoise& correlated,
                  DiagnosisStep& step) {
  const std::vector<BaseFit>& fits = all.alone;
  const double exponent = common_exponent(without, fits);
  const Evidence known = evidence(without, exponent);
  const double noise_without = correlated.gain(without);
  step.log_evidence_without = known.log + noise_without;
  step.squared_error_without = without.squared_error;
  step.free_form = free_form.evidence({-without.at.residual, without.at.jacobian}, exponent);
  step.free_form.log -= noise_without;
  std::vector<double> noise(fits.size());
  std::vector<const BaseFit*> known_by;  // the fit that evidence is of
  const HeldOut plain = held_out(without.at, known.information, groups, exponent);
  for (std::size_t c = 0; c < fits.size(); ++c) {
    known_by.push_back(&fits[c]);
    if (fits[c].values == 0) continue;
    RankedCandidate& ranked = step.ranking[c];
    ranked.fit = candidate_fit(fits[c], ranked.candidate, exponent, groups, plain);
    ranked.fit->log_prior = log_prior(step, ranked);
    noise[c] = correlated.gain(fits[c]);
    ranked.fit->log_evidence += ranked.fit->log_prior + noise[c];
    if (take_order(all.with_order[c], exponent, correlated, ranked))
      known_by.back() = &all.with_order[c];
  }
  std::size_t best = most_probable(step);
  if (best == fits.size()) return best;
  // Only where a fit is that large: others might go anywhere in a model that is linear in them. The
  // larger, the less likely.
  if (times_usual(step.ranking[best]) > unusual) {
    for (std::size_t c = 0; c < fits.size(); ++c) {
      auto& fit = step.ranking[c].fit;
      if (!fit || known_by[c] != &fits[c] || !(times_usual(step.ranking[c]) > unusual)) continue;
      fit->log_evidence = evidence(fits[c], exponent, Sizes::any).log + fit->log_prior + noise[c] -
                          std::log(times_usual(step.ranking[c]) / unusual);
    }
    best = most_probable(step);
  }
  step.share_left = correlated.share_left(without, *known_by[best]);
  share_probability(step);
  distinguish(without, known_by, best, step);
  return best;
}

void arrange(DiagnosisStep& step, std::vector<BaseFit>& fits) {
  const std::vector<std::size_t> order = order_of(step);
  std::vector<RankedCandidate> ranking;
  std::vector<BaseFit> arranged;
  for (const std::size_t i : order) {
    ranking.push_back(std::move(step.ranking[i]));
    arranged.push_back(std::move(fits[i]));
  }
  step.ranking = std::move(ranking);
  fits = std::move(arranged);
  step.indistinguishable = indistinguishable(step);
}

}  // namespace kinetostat::calibration

#include "kinetostat/calibration/search/search.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/datum.h"
#include "kinetostat/calibration/regression/evidence.h"
#include "kinetostat/calibration/search/fit_starts.h"
#include "kinetostat/calibration/search/pair_screen.h"
#include "kinetostat/calibration/search/usual_values.h"
#include "kinetostat/calibration/statistics/goodness_of_fit.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/memory.h"
#include "kinetostat/common/thread_pool.h"
#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t most_fits = 16;  // in one round
constexpr std::size_t most_pairs = 4;  // that are looked at
constexpr double least_kept = 0.3;     // of what a signature explains: a fit with less has failed
constexpr double first_gain = 1;       // of the squared error, for which a first fit goes on
constexpr double hopeless = 50;        // in log evidence: fits that are so much worse are left so

// Reason why a candidate is not observable although it has signatures.
std::string why_unobservable(const Candidate& candidate, double longest,
                             const CandidateFitter& fitter) {
  if (longest > least_visible) return confounded_with_fit;
  const bool is_weight = candidate.effect.kind->parameters[0].linear == spatial::dimension::mass;
  if (is_weight && !fitter.has_gravity())
    return "no reading depends on it: it acts by its weight, and the robot file states no "
           "'gravity'";
  if (fitter.campaign().displacement == DisplacementKind::difference &&
      candidate.effect.kind->place != vjm::EffectPlace::joint)
    return "no reading depends on it: in differences from the unloaded state it cancels";
  return "no reading depends on it";
}

// Those that are worth a fit, the most significant first.
std::vector<std::size_t> most_significant(const DiagnosisStep& step) {
  std::vector<std::size_t> order;
  for (std::size_t c = 0; c < step.ranking.size(); ++c)
    if (step.ranking[c].unobservable.empty()) order.push_back(c);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return step.ranking[a].significance > step.ranking[b].significance;
  });
  if (order.size() > most_fits) order.resize(most_fits);
  return order;
}

// What noise alone leaves of the squared error.
double noise_in(const BaseFit& fit) {
  return static_cast<double>(std::max<Index>(1, fit.degrees_of_freedom()));
}

double most_believable(const BaseFit& fit) {
  return believable_noise * believable_noise * noise_in(fit);
}

bool leaves_noise_alone(const BaseFit& fit) {
  constexpr double nearly = 2;
  return fit.values > 0 && fit.squared_error < nearly * noise_in(fit);
}

// So much that no signature is wrong by it: beside a fit that leaves noise alone, a candidate that
// promises to leave more is hopeless.
double far_from_noise(const BaseFit& fit) {
  constexpr double times = 10, least = 1000;
  return std::max(least, times * noise_in(fit));
}

// Logarithm of how many readings it was chosen from to be of.
double handicap_of(const Candidate& candidate) {
  return candidate.effect.kind->offsets_readings ? std::log(static_cast<double>(candidate.designs))
                                                 : 0;
}

// A fit, or nothing and why there is none.
template <class Fit>
std::optional<BaseFit> tried(const Fit& fit, std::string& failure) {
  try {
    return fit();
  } catch (const common::Cancelled&) {
    throw;
  } catch (const std::runtime_error& error) {
    failure = error.what();
    return std::nullopt;
  }
}

// Why a candidate is not tried beside others; empty: it is.
std::string why_not_beside(const std::vector<Candidate>& present, const Candidate& candidate) {
  const vjm::EffectKind& own = *candidate.effect.kind;
  for (const Candidate& other : present) {
    if (other.name() == candidate.name() && !may_act_again(own))
      return "it is in the model already";
    if (vjm::has_one_law(own.effect_class) && other.effect.kind->effect_class == own.effect_class &&
        other.effect.at == candidate.effect.at)
      return fmt::format("the place has {} already", other.effect.kind->name);
    // Its five values would follow the next order.
    if (own.balances_weight && is_of_series(*other.effect.kind) &&
        other.effect.kind->effect_class == own.moves_like && other.effect.at == candidate.effect.at)
      return fmt::format("{} moves the joint alike", other.effect.kind->name);
  }
  return "";
}

// Name of the work on a candidate for others that do the same; only a journal asks for it.
std::string item_of(const FitJournal* journal, std::string_view phase, const FittedModel& beside,
                    const Candidate& candidate) {
  if (journal == nullptr) return "";
  return fmt::format("{} of {} beside {}", phase, candidate.name(), beside.key());
}

}  // namespace

void Search::screen(const std::vector<Candidate>& present, const BaseFit& fit) {
  candidate_signatures_.clear();
  signatures_.clear();
  owner_.clear();
  const FittedModel beside = fitter_.beside(present, fit, candidates_);
  candidate_signatures_.resize(candidates_.size());
  shared_out("screening", beside, candidates_, [&](std::size_t c) {
    common::SilentPart silent(progress_);
    const std::string reason = why_not_beside(present, candidates_[c]);
    candidate_signatures_[c] = reason.empty()
                                   ? fitter_.signatures_of(candidates_[c], beside, silent)
                                   : CandidateFitter::Signatures{{}, {}, reason};
  });
  for (std::size_t c = 0; c < candidates_.size(); ++c) {
    std::vector<Signature> own = std::exchange(candidate_signatures_[c].all, {});
    for (std::size_t s = 0; s < own.size(); ++s) {
      signatures_.push_back(std::move(own[s]));
      signatures_.back().handicap = handicap_of(candidates_[c]);
      owner_.emplace_back(c, s);
    }
  }
}

// Work on candidates beside a fitted model, each by whoever is free: threads, and other workers
// that use the same journal. Those that another one works on are left for later, when what it has
// found is in the journal, or when it is gone.
void Search::shared_out(std::string_view phase, const FittedModel& beside,
                        const std::vector<Candidate>& items,
                        const std::function<void(std::size_t)>& work) const {
  const std::thread::id caller = std::this_thread::get_id();
  common::ThreadPool pool(std::min(threads_, static_cast<int>(items.size())));
  std::vector<std::size_t> left(items.size());
  std::iota(left.begin(), left.end(), 0);
  while (!left.empty()) {
    const std::size_t before = items.size() - left.size();
    std::vector<char> is_done(left.size());
    pool.for_each(static_cast<int>(left.size()), [&](int i) {
      const auto at = static_cast<std::size_t>(i);
      if (std::this_thread::get_id() == caller)
        progress_.report(phase,
                         static_cast<double>(before + at) / static_cast<double>(items.size()));
      Claim claim(options_.journal, item_of(options_.journal, phase, beside, items[left[at]]));
      if (!claim.try_once()) return;
      work(left[at]);
      is_done[at] = 1;
    });
    std::vector<std::size_t> others;
    for (std::size_t at = 0; at < left.size(); ++at)
      if (is_done[at] == 0) others.push_back(left[at]);
    if (others.size() == left.size()) wait_a_moment();
    left = std::move(others);
  }
}

void Search::take_signatures(Search& wider) {
  std::vector<Index> rows;
  std::size_t row = 0;
  for (const Value& value : values_) {
    while (wider.values_[row].reading != value.reading ||
           wider.values_[row].component != value.component)
      ++row;
    rows.push_back(static_cast<Index>(row));
  }
  candidate_signatures_ = wider.candidate_signatures_;
  owner_ = std::exchange(wider.owner_, {});
  signatures_ = std::exchange(wider.signatures_, {});
  if (rows.size() == wider.values_.size()) return;
  for (Signature& s : signatures_) s.columns = s.columns(rows, Eigen::all).eval();
}

double Search::longest_signature(std::size_t candidate) const {
  double longest = 0;
  for (std::size_t i = 0; i < signatures_.size(); ++i)
    if (owner_[i].first == candidate) longest = std::max(longest, signatures_[i].columns.norm());
  return longest;
}

// What is of some readings is an effect of its own at each of them: a second one beside the first.
Search::ByEffect Search::signatures_by_effect() const {
  ByEffect result;
  for (std::size_t i = 0; i < signatures_.size(); ++i) {
    const bool goes_on = i > 0 && owner_[i].first == owner_[i - 1].first;
    const bool is_alone = candidates_[owner_[i].first].effect.kind->offsets_readings;
    if (!goes_on || is_alone) {
      EffectEntry entry{.handicap = signatures_[i].handicap};
      if (goes_on) entry.beside = result.entries.size() - 1;
      result.entries.push_back(entry);
      result.signatures.emplace_back();
    }
    result.signatures.back().push_back(i);
  }
  return result;
}

std::vector<std::size_t> Search::outliers(const BaseFit& fit) const {
  // Each reading by itself: whitened by what they share, one gross error would be in many. Where
  // the drives of a pose stopped is no error of it.
  const SharedNoise shared(fitter_.noise(), values_);
  VectorXd deviations = VectorXd::Ones(std::ssize(values_));
  if (fitter_.campaign().displacement == DisplacementKind::absolute)
    deviations = shared.deviations(std::ssize(values_));
  const auto of_each = [&](MatrixXd columns) -> MatrixXd {
    shared.restore(columns);
    return deviations.cwiseInverse().asDiagonal() * columns;
  };
  const ByEffect effects = signatures_by_effect();
  const auto effect = [&](std::size_t e) {
    MatrixXd columns(fit.at.residual.size(), 0);
    for (const std::size_t i : effects.signatures[e])
      columns = beside(columns, signatures_[i].of_usual_size());
    return of_each(std::move(columns));
  };
  return calibration::outliers(-of_each(fit.at.residual), of_each(fit.at.jacobian),
                               effects.entries.size(), effect, effects.entries);
}

SignatureTable Search::signature_table(const BaseFit& fit) const {
  SignatureTable table{.values = values_,
                       .residual = -fit.at.residual,
                       .fitted = {},
                       .by_fitted = fit.at.jacobian,
                       .candidates = {},
                       .by_candidates = MatrixXd(fit.at.residual.size(), 0)};
  for (const ParameterEstimate& estimate : fit.parameters)
    table.fitted.push_back(estimate.parameter.name);
  while (std::ssize(table.fitted) < table.by_fitted.cols())
    table.fitted.push_back(
        fmt::format("frame {}", table.fitted.size() - fit.parameters.size() + 1));
  for (std::size_t i = 0; i < signatures_.size(); ++i) {
    const MatrixXd columns = signatures_[i].of_usual_size();
    if (owner_[i].second != 0 || columns.col(0).norm() < least_visible) continue;
    table.candidates.insert(table.candidates.end(), static_cast<std::size_t>(columns.cols()),
                            candidates_[owner_[i].first].name());
    table.by_candidates = beside(table.by_candidates, columns);
  }
  return table;
}

std::vector<Candidate> Search::like_the_fit(const BaseFit& nominal, const BaseFit& fitted) const {
  constexpr double most_left =
      0.2;  // of the change's length: what refitting does is no straight line
  const auto parameters = static_cast<Index>(fitted.parameters.size());
  const MatrixXd& all = fitted.at.jacobian;
  const Screen beside(ResidualSpace(-fitted.at.residual, all), signatures_);
  const ResidualSpace space(nominal.at.residual - fitted.at.residual,
                            all.rightCols(all.cols() - parameters));
  std::vector<Candidate> result;
  for (std::size_t i = 0; i < signatures_.size(); ++i) {
    const Candidate& candidate = candidates_[owner_[i].first];
    if (!result.empty() && result.back().name() == candidate.name()) continue;
    if (beside.detectability(i) / signatures_[i].growth[0] > discriminable_from) continue;
    const MatrixXd span = span_of(space.left_of(signatures_[i].columns), least_visible);
    const double left = (space.residual() - span * (span.transpose() * space.residual())).norm();
    if (span.cols() > 0 && left < most_left * space.residual().norm()) result.push_back(candidate);
  }
  return result;
}

double Search::explained_by_kinematics(const BaseFit& fit) const {
  const ResidualSpace space(-fit.at.residual, fit.at.jacobian);
  MatrixXd all(space.residual().size(), 0);
  std::optional<std::size_t> last;
  for (std::size_t i = 0; i < signatures_.size(); ++i) {
    const vjm::EffectKind& kind = *candidates_[owner_[i].first].effect.kind;
    const bool is_kinematic =
        kind.effect_class == vjm::EffectClass::geometry ||
        (kind.place == vjm::EffectPlace::sensor && kind.moves_like == vjm::EffectClass::geometry);
    if (!is_kinematic || last == owner_[i].first) continue;
    last = owner_[i].first;
    const MatrixXd& columns = signatures_[i].columns;
    all.conservativeResize(Eigen::NoChange, all.cols() + columns.cols());
    all.rightCols(columns.cols()) = columns;
  }
  const MatrixXd span = span_of(space.left_of(all), least_visible);
  const Index left = space.dimension() - span.cols();
  const double before = space.residual().squaredNorm();
  if (left < 1 || before == 0) return 0;
  const double after = before - (span.transpose() * space.residual()).squaredNorm();
  return 1 - after / before * static_cast<double>(space.dimension()) / static_cast<double>(left);
}

// A law with corners has several minima, and its starts here are those of its signature.
void Search::keep_better(const KnownFit& known, DiagnosisStep& step, std::vector<BaseFit>& fits) {
  for (std::size_t c = 0; c < fits.size(); ++c) {
    RankedCandidate& own = step.ranking[c];
    if (own.candidate.name() != known.name) continue;
    if (fits[c].values > 0 && penalised_error(fits[c]) <= penalised_error(known.fit)) continue;
    own.not_fitted.clear();
    own.is_hopeless = false;
    fits[c] = known.fit;
    return;
  }
}

DiagnosisStep Search::step(const std::vector<Candidate>& present, const BaseFit& fit,
                           std::vector<BaseFit>& fits, const KnownFit* known) {
  common::give_back_free_memory();  // what comes next needs most
  DiagnosisStep step;
  for (const Candidate& candidate : present) step.beside.push_back(candidate.name());
  const ResidualSpace space(-fit.at.residual, fit.at.jacobian);
  progress_.report("detection threshold", 0);
  // However errors last, what is twice the noise is something that is missing.
  std::optional<std::size_t> correlated = correlated_.prevailing(fit);
  if (present.empty() &&
      correlated_.squared_error_where_shared(fit, correlated) > most_believable(fit))
    correlated.reset();
  if (correlated && excludes_correlated_noise(fit)) correlated.reset();
  step.takes_rest_for_noise = correlated.has_value();
  if (correlated) step.max_score = correlated_max_score_test(fit, *correlated);
  std::optional<Screen> screen(std::in_place, space, signatures_);
  if (!correlated)
    step.max_score =
        max_score_test(*screen, space, significance_level, options_.draws, options_.seed, threads_);
  for (std::size_t c = 0; c < candidates_.size(); ++c)
    step.ranking.emplace_back().candidate = candidates_[c];
  std::vector<bool> seen(candidates_.size(), false);
  std::vector<double> explained;  // of the squared residual, by each signature
  for (std::size_t i = 0; i < signatures_.size(); ++i) {
    RankedCandidate& ranked = step.ranking[owner_[i].first];
    const Score score = screen->score(i, space.residual());
    explained.push_back(score.explained);
    if (score.dimension > 0) seen[owner_[i].first] = true;
    const double usual = score.detectability / signatures_[i].growth[0];
    if (owner_[i].second == 0) ranked.detectability = usual;
    ranked.most_detectability = std::max(ranked.most_detectability, usual);
    ranked.significance =
        std::max(ranked.significance, screen->significance(score, space.residual()));
  }
  for (std::size_t c = 0; c < candidates_.size(); ++c)
    if (!seen[c])
      step.ranking[c].unobservable =
          candidate_signatures_[c].failure.empty()
              ? why_unobservable(candidates_[c], longest_signature(c), fitter_)
              : candidate_signatures_[c].failure;
  confuse(*screen, step);
  if (present.empty() && step.max_score.p_value <= significance_level)
    find_pairs(*screen, space.residual(), step);
  screen.reset();  // as large as all signatures; fits need memory
  CandidateFits all(candidates_.size());
  if (step.is_worth_a_look()) {
    fit_survivors(present, fit, explained, space, step, all);
    if (known != nullptr) keep_better(*known, step, all.alone);
  }
  const std::size_t best = weigh(fit, all, groups_, *free_form_, correlated_, step);
  fits = std::move(all.alone);
  if (best < fits.size()) find_confounded(fit, fits[best], step);
  arrange(step, fits);
  return step;
}

// Whether one signature with independent noise is far more probable than noise that is correlated,
// and leaves none that is: a drift looks like errors that last, while it is not known.
bool Search::excludes_correlated_noise(const BaseFit& fit) const {
  const ResidualSpace space(-fit.at.residual, fit.at.jacobian);
  const Screen screen(space, signatures_);
  std::optional<std::size_t> best;
  Score most;
  for (std::size_t i = 0; i < signatures_.size(); ++i) {
    const Score score = screen.score(i, space.residual());
    if (score.dimension == 0 || (best && score.explained <= most.explained)) continue;
    best = i;
    most = score;
  }
  if (!best) return false;
  BaseFit with;
  const MatrixXd& columns = signatures_[*best].columns;
  with.at.residual = fit.at.residual;
  with.at.jacobian.resize(columns.rows(), fit.at.jacobian.cols() + columns.cols());
  with.at.jacobian << fit.at.jacobian, columns;
  if (correlated_.prevailing(with)) return false;
  const double penalty =  // of its values, and of the choice among all
      0.5 * static_cast<double>(most.dimension) * std::log(static_cast<double>(columns.rows())) +
      std::log(static_cast<double>(candidates_.size()));
  return most.explained / 2 - penalty + correlated_.gain(with) - correlated_.gain(fit) > doubtful;
}

// With noise that is correlated in the way that a fit seems to have.
MaxScoreTest Search::correlated_max_score_test(const BaseFit& fit, std::size_t way) const {
  const auto decorrelated = [&](const MatrixXd& columns) {
    return correlated_.decorrelated(way, columns);
  };
  const ResidualSpace space(decorrelated(-fit.at.residual), decorrelated(fit.at.jacobian));
  return max_score_test(Screen(space, signatures_, decorrelated), space, significance_level,
                        options_.draws, options_.seed, threads_);
}

// Rows of the ranking are still those of the candidates.
void Search::confuse(const Screen& screen, DiagnosisStep& step) const {
  const std::vector<std::size_t> order = most_significant(step);
  const auto n = static_cast<Index>(order.size());
  step.confusion = MatrixXd::Identity(n, n);
  for (const std::size_t c : order) step.confused.push_back(candidates_[c].name());
  for (Index a = 0; a < n; ++a)
    for (Index b = 0; b < a; ++b)
      for (std::size_t i = 0; i < signatures_.size(); ++i)
        for (std::size_t j = 0; j < signatures_.size(); ++j)
          if (owner_[i].first == order[static_cast<std::size_t>(a)] &&
              owner_[j].first == order[static_cast<std::size_t>(b)])
            step.confusion(a, b) = step.confusion(b, a) =
                std::max(step.confusion(a, b), screen.confusion(i, j));
}

FitStarts Search::starts_of(std::size_t candidate, const FittedModel& beside,
                            const std::vector<double>& explained,
                            const ResidualSpace& space) const {
  FitStarts starts(candidates_[candidate], space, fitter_.bare());
  for (std::size_t i = 0; i < signatures_.size(); ++i)
    if (owner_[i].first == candidate)
      starts.add(candidate_signatures_[candidate].starts[owner_[i].second], signatures_[i],
                 explained[i]);
  common::SilentPart silent(progress_);
  starts.add_other_phases(fitter_, beside, silent);
  return starts;
}

std::vector<std::vector<Candidate>> Search::masked_pairs(const BaseFit& fit) const {
  const ResidualSpace space(-fit.at.residual, fit.at.jacobian);
  const Screen screen(space, signatures_);
  std::vector<std::size_t> members;  // of each candidate the first signature that can be seen
  for (std::size_t i = 0; i < signatures_.size(); ++i) {
    const bool is_first = members.empty() || owner_[members.back()].first != owner_[i].first;
    // A pair is tested as it is, not as one of many.
    if (is_first && screen.span(i).cols() > 0 && signatures_[i].handicap == 0) members.push_back(i);
  }
  if (members.size() < 2) return {};
  const PairScreen pairs(screen, members);
  if (pairs.pairs().empty()) return {};
  progress_.report("detection threshold of pairs", 0);
  const MaxScoreTest passed = max_score_test(
      [&](const MatrixXd& residuals) { return pairs.largest_significance(residuals); }, space,
      significance_of_pairs, options_.draws, options_.seed, threads_);
  if (passed.p_value > significance_of_pairs) return {};
  const VectorXd significances = pairs.significances(space.residual());
  std::vector<std::size_t> order(pairs.pairs().size());
  for (std::size_t p = 0; p < order.size(); ++p) order[p] = p;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return significances[static_cast<Index>(a)] > significances[static_cast<Index>(b)];
  });
  order.resize(std::min(order.size(), most_pairs));
  std::vector<std::vector<Candidate>> result;
  for (const std::size_t p : order) {
    const auto [a, b] = pairs.pairs()[p];
    MatrixXd signatures(space.residual().size(), 2);
    signatures << signatures_[a].columns.col(0), signatures_[b].columns.col(0);
    const VectorXd sizes =
        spatial::least_squares_solution(space.left_of(signatures), space.residual());
    const auto start = [&](std::size_t i, double size) {
      return resized(candidate_signatures_[owner_[i].first].starts[owner_[i].second], size);
    };
    result.push_back({start(a, sizes[0]), start(b, sizes[1])});
  }
  return result;
}

// Of the candidates that explain most, the signature that does.
std::vector<std::size_t> Search::most_explaining(const Screen& screen,
                                                 const VectorXd& residual) const {
  constexpr std::size_t most = 40;
  std::vector<std::pair<double, std::size_t>> best;  // of each candidate
  for (std::size_t i = 0; i < signatures_.size(); ++i) {
    const std::pair own(screen.score(i, residual).explained, i);
    if (i == 0 || owner_[i].first != owner_[i - 1].first) best.push_back(own);
    best.back() = std::max(best.back(), own);
  }
  std::stable_sort(best.begin(), best.end(), std::greater<>());
  best.resize(std::min(best.size(), most));
  std::vector<std::size_t> signatures;
  for (const auto& [explained, i] : best)
    if (screen.span(i).cols() > 0) signatures.push_back(i);
  return signatures;
}

// Of candidates that are not alike, those that promise most.
void Search::find_pairs(const Screen& screen, const VectorXd& residual, DiagnosisStep& step) const {
  constexpr double alike = 0.9;
  const std::vector<std::size_t> members = most_explaining(screen, residual);
  if (members.size() < 2) return;
  const PairScreen pairs(screen, members);
  const auto explained = pairs.explained(residual);
  std::vector<CandidatePair> found;
  for (std::size_t p = 0; p < explained.size(); ++p) {
    const auto [a, b] = pairs.pairs()[p];
    if (screen.confusion(a, b) < alike)
      found.push_back({{candidates_[owner_[a].first].name(), candidates_[owner_[b].first].name()},
                       explained[p].first,
                       explained[p].second});
  }
  const auto n = static_cast<Index>(values_.size());
  std::stable_sort(found.begin(), found.end(), [n](const auto& a, const auto& b) {
    return promise(a.explained, a.columns, n) > promise(b.explained, b.columns, n);
  });
  found.resize(std::min(found.size(), most_pairs));
  step.pairs = std::move(found);
}

void Search::fit_survivors(const std::vector<Candidate>& present, const BaseFit& fit,
                           const std::vector<double>& explained, const ResidualSpace& space,
                           DiagnosisStep& step, CandidateFits& all) {
  std::vector<BaseFit>& fits = all.alone;
  const std::vector<std::size_t> order = most_significant(step);
  std::vector<Candidate> survivors;
  survivors.reserve(order.size());
  for (const std::size_t c : order) survivors.push_back(candidates_[c]);
  const FittedModel beside = fitter_.beside(present, fit, survivors);
  std::vector<std::optional<FitStarts>> starts(survivors.size());
  shared_out("starts of fits", beside, survivors, [&](std::size_t o) {
    starts[o].emplace(starts_of(order[o], beside, explained, space));
  });
  const auto left = [&](std::size_t o) { return fit.squared_error - starts[o]->promised(); };
  const auto fit_all = [&](const std::vector<std::size_t>& of_them) {
    std::vector<Candidate> items;
    items.reserve(of_them.size());
    for (const std::size_t o : of_them) items.push_back(survivors[o]);
    shared_out("fits", beside, items, [&](std::size_t i) {
      const std::size_t o = of_them[i], c = order[o];
      fits[c] =
          best_fit(beside, starts[o]->promised(), starts[o]->best(), step.ranking[c].not_fitted);
    });
  };
  std::vector<std::size_t> hopeful, others;
  for (std::size_t o = 0; o < order.size(); ++o)
    (left(o) < far_from_noise(fit) ? hopeful : others).push_back(o);
  fit_all(hopeful);
  if (std::none_of(fits.begin(), fits.end(), leaves_noise_alone)) {
    fit_all(others);
  } else {
    for (const std::size_t o : others) {
      RankedCandidate& ranked = step.ranking[order[o]];
      ranked.is_hopeless = true;
      ranked.not_fitted = fmt::format(
          "others leave noise alone, it would leave {:.2g} times as much", left(o) / noise_in(fit));
    }
  }
  finish(beside, step, fits);
  add_orders(beside, step, all);
}

namespace {

// Whether an effect is so much larger than usual that its prior holds back more than noise might.
bool is_held_back(const BaseFit& fit) {
  return std::any_of(fit.parameters.begin(), fit.parameters.end(), [](const auto& estimate) {
    constexpr double deviations = 2;
    const auto& prior = estimate.parameter.prior;
    return prior && prior->group >= 0 &&
           std::abs(estimate.value - prior->mean) > deviations * prior->deviation;
  });
}

}  // namespace

// Takes a fit to its end. The prior of an effect that is far larger than usual would hold its size
// back: it grows with it.
BaseFit Search::to_the_end(const FittedModel& beside, Candidate& candidate, BaseFit fit) const {
  constexpr int most_rounds = 5;
  constexpr double alike = 1.2;
  common::SilentPart silent(progress_);
  for (int round = 0;; ++round) {
    std::vector<Candidate> added = beside.present();
    added.push_back(candidate);
    added.back().effect.values = fitted_values(fit, {candidate}).front().values;
    fit = fitter_.finished(added, fit, silent);
    const double times = times_usual(candidate, fitted_values(fit, {candidate}).front().values);
    if (round == most_rounds || times < alike * candidate.widest) return fit;
    candidate.widest = times;
  }
}

// Takes those fits to their ends that may still be what is missing.
void Search::finish(const FittedModel& beside, DiagnosisStep& step,
                    std::vector<BaseFit>& fits) const {
  const double exponent = common_exponent(beside.fit(), fits);
  double least = std::numeric_limits<double>::infinity();
  for (const BaseFit& fit : fits)
    if (fit.values > 0) least = std::min(least, penalised_error(fit));
  std::vector<std::size_t> open;
  std::vector<Candidate> candidates;
  for (std::size_t c = 0; c < fits.size(); ++c) {
    const bool may_win =
        fits[c].values > 0 &&
        (exponent * (penalised_error(fits[c]) - least) < 2 * hopeless || is_held_back(fits[c]));
    if (!may_win) continue;
    open.push_back(c);
    candidates.push_back(step.ranking[c].candidate);
  }
  shared_out("fits to the end", beside, candidates, [&](std::size_t o) {
    const std::size_t c = open[o];
    const auto finished = [&] { return to_the_end(beside, step.ranking[c].candidate, fits[c]); };
    fits[c] = tried(finished, step.ranking[c].not_fitted).value_or(BaseFit());
  });
}

// Of a series of orders the first alone may leave what a law with more values does not. Where one
// of its joint does, two orders are fitted: the next may come only after it has been found.
void Search::add_orders(const FittedModel& beside, const DiagnosisStep& step,
                        CandidateFits& fits) const {
  const auto is_left_behind = [&](std::size_t c) {
    const Candidate& own = step.ranking[c].candidate;
    for (std::size_t d = 0; d < fits.alone.size(); ++d)
      if (d != c && fits.alone[d].values > 0 && act_at_one_joint(own, step.ranking[d].candidate) &&
          penalised_error(fits.alone[c]) - penalised_error(fits.alone[d]) > 2 * doubtful)
        return true;
    return false;
  };
  std::vector<std::size_t> series;
  std::vector<Candidate> items;
  for (std::size_t c = 0; c < fits.alone.size(); ++c) {
    const Candidate& candidate = step.ranking[c].candidate;
    if (!is_of_series(*candidate.effect.kind) || fits.alone[c].values == 0 || !is_left_behind(c))
      continue;
    series.push_back(c);
    items.push_back(candidate);
  }
  shared_out("fits of two orders", beside, items, [&](std::size_t i) {
    fits.with_order[series[i]] = with_one_more_order(beside, items[i], fits.alone[series[i]]);
  });
}

// The best of all other orders; none where no fit succeeds.
BaseFit Search::with_one_more_order(const FittedModel& beside, Candidate candidate,
                                    const BaseFit& fit) const {
  constexpr double small = 0.2;
  BaseFit best;
  candidate.effect.values = fitted_values(fit, {candidate}).front().values;
  std::vector<Candidate> present = beside.present();
  present.push_back(candidate);
  for (const Candidate& design : fitter_.designs_beside(candidate, present)) {
    std::vector<Candidate> added = present;
    added.push_back(at_size(design, small, 1));
    common::SilentPart silent(progress_);
    std::string failure;
    auto found = tried(
        [&] { return fitter_.fit_on_one_thread(added, fit, std::nullopt, first_gain, silent); },
        failure);
    if (found && (best.values == 0 || penalised_error(*found) < penalised_error(best)))
      best = *std::move(found);
  }
  return best;
}

// Starts of one candidate with where their fits end roughly, the best end first, each end once;
// then those of which that is not known.
std::vector<Search::Start> Search::with_ends(const FittedModel& beside,
                                             const std::vector<Candidate>& starts) const {
  std::vector<Start> all;
  for (const Candidate& start : starts) {
    all.push_back({beside.present(), std::nullopt});
    all.back().added.push_back(start);
    common::SilentPart silent(progress_);
    all.back().end = fitter_.fit_condensed(all.back().added, beside, silent);
  }
  const auto cost = [&](std::size_t s) {
    return all[s].end ? all[s].end->cost : std::numeric_limits<double>::infinity();
  };
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return cost(a) < cost(b); });
  constexpr double alike = 1e-3;
  double last = -1;
  std::vector<Start> result;
  for (const std::size_t s : order) {
    if (all[s].end && last >= 0 && cost(s) - last <= alike * last) continue;
    last = cost(s);
    result.push_back(std::move(all[s]));
  }
  return result;
}

// The best of the fits from some starts; none, and a reason, where no fit explains what the
// candidate's signature promised.
BaseFit Search::best_fit(const FittedModel& beside, double promised,
                         const std::vector<Candidate>& starts, std::string& reason) const {
  // Ends that are farther from the best than so many times what its rough cost was wrong by.
  constexpr double times_wrong = 10, and_more = 20;
  const BaseFit& fit = beside.fit();
  const double slack = std::min(promised / 2, discriminable_from * discriminable_from);
  BaseFit best;
  double most = std::numeric_limits<double>::infinity();  // rough cost
  std::string failure;
  for (const Start& start : with_ends(beside, starts)) {
    if (start.end && start.end->cost > most) continue;
    common::SilentPart silent(progress_);
    auto found = tried(
        [&] { return fitter_.fit_on_one_thread(start.added, fit, start.end, first_gain, silent); },
        failure);
    if (!found) continue;
    if (best.values == 0 || penalised_error(*found) < penalised_error(best)) {
      best = *std::move(found);
      const double cost = penalised_error(best);
      if (start.end) most = cost + times_wrong * std::abs(cost - start.end->cost) + and_more;
    }
    // What its signature promised; far less is a minimum that is not the lowest.
    if (fit.squared_error - best.squared_error > promised - slack) break;
  }
  // An unhappy fit proves nothing against a candidate; where little was promised, there is no
  // other.
  constexpr double little = 1;
  if (best.values > 0 && promised > little &&
      fit.squared_error - best.squared_error < least_kept * promised) {
    best = {};
    failure = "its fits ended in minima that explain far less than its signature does";
  }
  if (best.values == 0) reason = failure;
  return best;
}

namespace {

// Of the columns of an effect's signature, its values in their order: those that can only grow.
std::vector<bool> one_sided_columns(const Candidate& candidate, const vjm::Manipulator& bare) {
  std::vector<bool> result;
  const auto& parameters = candidate.effect.kind->parameters;
  for (const Index value : values_of_columns(candidate.effect, bare)) {
    const vjm::EffectParameter& p = parameters[static_cast<std::size_t>(value)];
    result.push_back(!p.is_shape && can_only_grow(p));
  }
  return result;
}

// What is left of a signature beside the columns of another effect: one of one sign is not
// confounded with its own opposite.
double left_beside(const MatrixXd& columns, const std::vector<bool>& one_sided,
                   const VectorXd& signature) {
  std::vector<Index> used;
  for (Index k = 0; k < columns.cols(); ++k)
    if (columns.col(k).norm() > least_visible) used.push_back(k);
  while (!used.empty()) {
    const MatrixXd some = columns(Eigen::all, used);
    const VectorXd share = spatial::shortest_least_squares_solution(some, signature, 1e-9);
    std::optional<std::size_t> worst;  // that is most beyond its sign
    double most = 0;
    for (std::size_t k = 0; k < used.size(); ++k) {
      const auto at = static_cast<Index>(k);
      const double beyond = -share[at] * some.col(at).norm();
      if (one_sided[static_cast<std::size_t>(used[k])] && beyond > most) most = beyond, worst = k;
    }
    if (!worst) return (signature - some * share).norm();
    used.erase(used.begin() + static_cast<std::ptrdiff_t>(*worst));
  }
  return signature.norm();
}

}  // namespace

// Candidates without a fit that do what the best does just as well, as far as their signatures
// tell: they look like it, and explain half as much at least.
void Search::find_confounded(const BaseFit& without, const BaseFit& best,
                             DiagnosisStep& step) const {
  const ResidualSpace space(-without.at.residual, without.at.jacobian);
  const VectorXd signature = space.left_of(best.at.residual - without.at.residual);
  const double explained = without.squared_error - best.squared_error;
  for (std::size_t i = 0; i < signatures_.size(); ++i) {
    RankedCandidate& ranked = step.ranking[owner_[i].first];
    if (ranked.fit || ranked.is_hopeless || ranked.not_fitted.empty()) continue;
    const MatrixXd columns = space.left_of(signatures_[i].columns);
    const MatrixXd span = span_of(columns, least_visible);
    const double part = (span.transpose() * space.residual()).norm();
    if (part * part < explained / 2) continue;
    // It would have to be larger than any that is known, and no fit has come to that.
    const double usual = space.left_of(signatures_[i].of_usual_size()).norm();
    if (part > unusual * usual) continue;
    const double left =
        left_beside(columns, one_sided_columns(ranked.candidate, fitter_.bare()), signature);
    if (!(left < discriminable_from)) continue;
    const double short_of = std::max(0.0, explained - part * part);
    ranked.falls_short = std::min(ranked.falls_short.value_or(short_of), short_of);
  }
}

}  // namespace kinetostat::calibration

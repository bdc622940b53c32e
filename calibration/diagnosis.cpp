#include "kinetostat/calibration/diagnosis.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <fmt/format.h>

#include "kinetostat/calibration/load_history.h"
#include "kinetostat/calibration/wrench_noise.h"
#include "kinetostat/files/error.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t most_fits = 16;  // in one step
constexpr int most_starts = 4;         // of one fit
constexpr double least_kept = 0.3;     // of what a mark explains: a fit with less has failed
constexpr double told_apart_from = 4;  // d' that names an effect against a rival
constexpr double doubtful = 4.6;       // difference of log evidence below which both remain
constexpr double at_bound = 5;         // what a value at the end of its range costs in log evidence
constexpr double significance_of_more = 0.01;  // of a further effect beside one that was found
constexpr double unexplained_share = 0.3;  // of the misfit: more is another effect, not this one

// How much of the readings' weight is left when the misfit is all noise: 1, or less.
double temper_of(const BaseFit& fit) {
  const auto freedom = static_cast<double>(std::max<Index>(1, fit.degrees_of_freedom()));
  return std::min(1.0, freedom / std::max(fit.squared_error, 1e-300));
}

// What a fit minimises.
double penalised(const BaseFit& fit) {
  double sum = fit.squared_error;
  for (const ParameterEstimate& estimate : fit.parameters)
    if (const auto& prior = estimate.parameter.prior)
      sum += std::pow((estimate.value - prior->mean) / prior->deviation, 2);
  return sum;
}

double log_determinant(const MatrixXd& columns) {
  Eigen::HouseholderQR<MatrixXd> qr(columns);
  return 2 * qr.matrixQR().diagonal().cwiseAbs().cwiseMax(1e-300).array().log().sum();
}

// Laplace's approximation of the evidence. What is refitted under every model has a flat prior and
// the same units everywhere, so its constants cancel between models.
double log_evidence(const BaseFit& fit, double temper) {
  const VectorXd information = prior_information(fit);
  double penalty = 0, normalisation = 0;
  std::vector<Index> kept;
  for (Index k = 0; k < information.size(); ++k) {
    const bool is_parameter = k < static_cast<Index>(fit.parameters.size());
    const ParameterEstimate* estimate =
        is_parameter ? &fit.parameters[static_cast<std::size_t>(k)] : nullptr;
    if (information[k] > 0) {
      const double d = estimate->value - estimate->parameter.prior->mean;
      penalty += d * d * information[k];
      normalisation += std::log(information[k]);
      // The range ends where the law has become another one, or absurd.
      const Parameter& parameter = estimate->parameter;
      const bool at_end = estimate->value == parameter.lower || estimate->value == parameter.upper;
      if (at_end && estimate->value != parameter.prior->mean) penalty += 2 * at_bound;
      // A range that ends where there is no effect holds all of the prior on one side.
      if (estimate->parameter.prior->mean == estimate->parameter.lower ||
          estimate->parameter.prior->mean == estimate->parameter.upper)
        normalisation += 2 * std::log(2.0);
    }
    if (estimate == nullptr || estimate->hit == BoundHit::none || information[k] > 0)
      kept.push_back(k);
  }
  const auto n = static_cast<Index>(kept.size());
  MatrixXd rows(fit.at.jacobian.rows() + n, n);
  rows << std::sqrt(temper) * fit.at.jacobian(Eigen::all, kept),
      MatrixXd(information(kept).cwiseSqrt().asDiagonal());
  return -0.5 * (temper * fit.squared_error + penalty) + 0.5 * normalisation -
         0.5 * log_determinant(rows);
}

// What a fit cannot absorb of marks that are there.
std::string why_unobservable(const Candidate& candidate, const Rivals::Marks& marks,
                             const Campaign& campaign) {
  if (!marks.failure.empty()) return marks.failure;
  double largest = 0;
  for (const Signature& signature : marks.signatures)
    largest = std::max(largest, signature.columns.norm());
  if (largest > least_visible)
    return "what it does, the refitted parameters do just as well in these readings";
  if (campaign.displacement == DisplacementKind::difference &&
      candidate.effect.kind->place != vjm::EffectPlace::joint)
    return "no reading depends on it: in differences from the unloaded state it cancels";
  return "no reading depends on it";
}

// Those that are worth a fit, the most surprising first.
std::vector<std::size_t> most_surprising(const DiagnosisStep& step) {
  std::vector<std::size_t> order;
  for (std::size_t c = 0; c < step.ranking.size(); ++c)
    if (step.ranking[c].unobservable.empty()) order.push_back(c);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return step.ranking[a].surprise > step.ranking[b].surprise;
  });
  if (order.size() > most_fits) order.resize(most_fits);
  return order;
}

// Effects one after the other.
class Search {
 public:
  Search(const Rivals& rivals, const std::vector<Candidate>& candidates,
         const DiagnosisOptions& options, int threads, files::Progress& progress)
      : rivals_(rivals),
        candidates_(candidates),
        options_(options),
        threads_(threads),
        progress_(progress),
        values_(values_in_use(rivals.campaign())),
        groups_(held_out_groups(rivals.campaign(), values_)) {}

  const std::vector<Value>& values() const { return values_; }
  const HeldOutGroups& groups() const { return groups_; }

  /// Screens all candidates beside what is present.
  void screen(const std::vector<Candidate>& present, const BaseFit& fit) {
    marks_.clear();
    signatures_.clear();
    owner_.clear();
    for (std::size_t c = 0; c < candidates_.size(); ++c) {
      progress_.report("screening",
                       static_cast<double>(c) / static_cast<double>(candidates_.size()));
      files::Progress silent;
      const bool there = std::any_of(present.begin(), present.end(), [&](const Candidate& p) {
        return p.name() == candidates_[c].name();
      });
      marks_.push_back(there ? Rivals::Marks{{}, {}, "it is in the model already"}
                             : rivals_.marks_of(candidates_[c], present, fit, silent));
      for (std::size_t s = 0; s < marks_.back().signatures.size(); ++s) {
        signatures_.push_back(marks_.back().signatures[s]);
        owner_.emplace_back(c, s);
      }
    }
  }

  /// Takes over the marks from a search with the same readings and more.
  void take_marks(const Search& wider) {
    std::vector<Index> rows;
    std::size_t row = 0;
    for (const Value& value : values_) {
      while (wider.values_[row].reading != value.reading ||
             wider.values_[row].component != value.component)
        ++row;
      rows.push_back(static_cast<Index>(row));
    }
    marks_ = wider.marks_;
    owner_ = wider.owner_;
    for (const Signature& s : wider.signatures_)
      signatures_.push_back({s.columns(rows, Eigen::all)});
  }

  /// Values that not all the catalogue together explains, though most of the others fit: outliers.
  std::vector<std::size_t> outliers(const BaseFit& fit) const;

  DiagnosisStep step(const std::vector<Candidate>& present, const BaseFit& fit,
                     std::vector<BaseFit>& fits);

 private:
  void fit_survivors(const std::vector<Candidate>& present, const BaseFit& fit,
                     const Screen& screen, const ResidualSpace& space, DiagnosisStep& step,
                     std::vector<BaseFit>& fits);
  double explained_by(std::size_t candidate, const Screen& screen,
                      const ResidualSpace& space) const;
  std::vector<Candidate> starts_of(std::size_t candidate, const Screen& screen,
                                   const ResidualSpace& space) const;
  void find_imitators(const BaseFit& without, const BaseFit& best, DiagnosisStep& step) const;
  void confuse(const Screen& screen, DiagnosisStep& step) const;
  void weigh(const BaseFit& without, DiagnosisStep& step, const std::vector<BaseFit>& fits) const;

  const Rivals& rivals_;
  const std::vector<Candidate>& candidates_;
  const DiagnosisOptions& options_;
  int threads_;
  files::Progress& progress_;
  std::vector<Value> values_;
  HeldOutGroups groups_;
  std::vector<Rivals::Marks> marks_;  // one a candidate
  std::vector<Signature> signatures_;
  std::vector<std::pair<std::size_t, std::size_t>> owner_;  // candidate, its mark
};

std::vector<std::size_t> Search::outliers(const BaseFit& fit) const {
  constexpr double far = 5, bend = 2;
  Index extra = 0;
  for (const Signature& s : signatures_) extra += s.columns.cols();
  const Index n = fit.at.residual.size(), base = fit.at.jacobian.cols();
  MatrixXd x(n, base + extra);
  x.leftCols(base) = fit.at.jacobian;
  Index at = base;
  for (const Signature& s : signatures_) {
    x.middleCols(at, s.columns.cols()) = s.columns;
    at += s.columns.cols();
  }
  const VectorXd y = -fit.at.residual;
  VectorXd weights = VectorXd::Ones(n), left = y;
  for (Index j = 0; j < base; ++j)
    if (const double length = x.col(j).norm(); length > 0)
      x.col(j) *= std::sqrt(double(n)) / length;
  for (int round = 0; round < 8; ++round) {
    MatrixXd a = x.transpose() * weights.asDiagonal() * x;
    a.diagonal().tail(extra).array() += 1;
    a.diagonal().head(base).array() += 1e-9;
    const VectorXd solution = a.ldlt().solve(x.transpose() * weights.cwiseProduct(y));
    left = y - x * solution;
    for (Index i = 0; i < n; ++i)
      weights[i] = std::min(1.0, bend / std::max(1e-300, std::abs(left[i])));
  }
  std::vector<std::size_t> found;
  for (Index i = 0; i < n; ++i)
    if (std::abs(left[i]) > far) found.push_back(static_cast<std::size_t>(i));
  // Many far values are no outliers but something that the catalogue lacks.
  if (found.size() * 25 > static_cast<std::size_t>(n)) return {};
  return found;
}

DiagnosisStep Search::step(const std::vector<Candidate>& present, const BaseFit& fit,
                           std::vector<BaseFit>& fits) {
  DiagnosisStep step;
  for (const Candidate& candidate : present) step.beside.push_back(candidate.name());
  const ResidualSpace space(-fit.at.residual, fit.at.jacobian);
  const Screen screen(space, signatures_);
  progress_.report("gate", 0);
  step.gate = gate(screen, space, significance_level, options_.draws, options_.seed, threads_);
  for (std::size_t c = 0; c < candidates_.size(); ++c)
    step.ranking.emplace_back().candidate = candidates_[c];
  std::vector<bool> seen(candidates_.size(), false);
  for (std::size_t i = 0; i < signatures_.size(); ++i) {
    Rival& rival = step.ranking[owner_[i].first];
    const Score score = screen.score(i, space.residual());
    if (score.dimension > 0) seen[owner_[i].first] = true;
    if (owner_[i].second == 0) rival.detectability = score.detectability;
    rival.surprise = std::max(rival.surprise, screen.surprise(score, space.residual()));
  }
  for (std::size_t c = 0; c < candidates_.size(); ++c)
    if (!seen[c])
      step.ranking[c].unobservable =
          why_unobservable(candidates_[c], marks_[c], rivals_.campaign());
  confuse(screen, step);
  fits.assign(candidates_.size(), {});
  if (step.gate.p_value <= significance_level)
    fit_survivors(present, fit, screen, space, step, fits);
  return step;
}

// Rows of the ranking are still those of the candidates.
void Search::confuse(const Screen& screen, DiagnosisStep& step) const {
  const std::vector<std::size_t> order = most_surprising(step);
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

double Search::explained_by(std::size_t candidate, const Screen& screen,
                            const ResidualSpace& space) const {
  double most = 0;
  for (std::size_t i = 0; i < signatures_.size(); ++i)
    if (owner_[i].first == candidate)
      most = std::max(most, screen.score(i, space.residual()).explained);
  return most;
}

// Where fits of a candidate begin: from the marks that explain most, at the size that each asks
// for, then as they are. Gaps, breakaway forces and corners have several minima.
std::vector<Candidate> Search::starts_of(std::size_t candidate, const Screen& screen,
                                         const ResidualSpace& space) const {
  std::vector<std::pair<double, std::size_t>> marks;  // what each explains, negative; which it is
  for (std::size_t i = 0; i < signatures_.size(); ++i)
    if (owner_[i].first == candidate)
      marks.emplace_back(-screen.score(i, space.residual()).explained, i);
  std::stable_sort(marks.begin(), marks.end());
  std::vector<Candidate> starts, as_they_are;
  for (const auto& [explained, i] : marks) {
    Candidate start = marks_[candidate].starts[owner_[i].second];
    as_they_are.push_back(start);
    const VectorXd mark = space.left_of(signatures_[i].columns.col(0));
    const double size = mark.dot(space.residual()) / std::max(1e-300, mark.squaredNorm());
    const vjm::EffectParameter& leading = start.effect.kind->parameters.front();
    const bool one_sided = leading.lower >= leading.none;
    const double value = leading.none + std::clamp(size, one_sided ? 0.002 : -20.0, 20.0) *
                                            (start.effect.values[0] - leading.none);
    start.effect.values[0] = std::clamp(value, leading.lower, leading.upper);
    starts.push_back(std::move(start));
  }
  starts.insert(starts.end(), as_they_are.begin(), as_they_are.end());
  return starts;
}

void Search::fit_survivors(const std::vector<Candidate>& present, const BaseFit& fit,
                           const Screen& screen, const ResidualSpace& space, DiagnosisStep& step,
                           std::vector<BaseFit>& fits) {
  const std::vector<std::size_t> order = most_surprising(step);
  for (std::size_t o = 0; o < order.size(); ++o) {
    progress_.report("fits", static_cast<double>(o) / static_cast<double>(order.size()));
    const std::size_t c = order[o];
    const double promised = explained_by(c, screen, space);
    std::string reason;
    int tried = 0;
    for (const Candidate& start : starts_of(c, screen, space)) {
      if (++tried > most_starts) break;
      std::vector<Candidate> added = present;
      added.push_back(start);
      try {
        files::Progress silent;
        BaseFit found = rivals_.fit(added, &fit, silent);
        if (fits[c].values == 0 || penalised(found) < penalised(fits[c]))
          fits[c] = std::move(found);
        // What its mark promised; less is a minimum that is not the lowest.
        if (fit.squared_error - fits[c].squared_error > 0.5 * promised) break;
      } catch (const files::Cancelled&) {
        throw;
      } catch (const std::runtime_error& error) {
        reason = error.what();
      }
    }
    // An unhappy fit proves nothing against a candidate.
    if (fits[c].values > 0 && fit.squared_error - fits[c].squared_error < least_kept * promised) {
      fits[c] = {};
      reason = "its fits ended in minima that explain far less than its mark does";
    }
    if (fits[c].values == 0) step.ranking[c].not_fitted = reason;
  }
  weigh(fit, step, fits);
}

// Evidence, held-out scores and what tells the best from the others.
void Search::weigh(const BaseFit& without, DiagnosisStep& step,
                   const std::vector<BaseFit>& fits) const {
  double temper = temper_of(without);
  for (const BaseFit& fit : fits)
    if (fit.values > 0) temper = std::max(temper, temper_of(fit));
  const HeldOut plain = held_out(without.at, prior_information(without), groups_, temper);
  double best_evidence = -std::numeric_limits<double>::infinity();
  std::size_t best = fits.size();
  for (std::size_t c = 0; c < fits.size(); ++c) {
    if (fits[c].values == 0) continue;
    RivalFit fit;
    const BaseFit& full = fits[c];
    const Index count = step.ranking[c].candidate.effect.values.size();
    const FittedValues fitted =
        fitted_values(full, full.parameters.size() - static_cast<std::size_t>(count), count);
    fit.values = fitted.values;
    fit.deviations = fitted.deviations;
    fit.squared_error = full.squared_error;
    fit.degrees_of_freedom = full.degrees_of_freedom();
    fit.log_evidence = log_evidence(full, temper);
    const HeldOut with = held_out(full.at, prior_information(full), groups_, temper);
    fit.log_score_gain = with.total() - plain.total();
    double squares = 0;
    const auto groups = static_cast<double>(groups_.members.size());
    for (std::size_t g = 0; g < groups_.members.size(); ++g)
      squares += std::pow(with.log_score[g] - plain.log_score[g] - fit.log_score_gain / groups, 2);
    fit.log_score_deviation = groups > 1 ? std::sqrt(squares * groups / (groups - 1)) : 0;
    if (fit.log_evidence > best_evidence) {
      best_evidence = fit.log_evidence;
      best = c;
    }
    step.ranking[c].fit = std::move(fit);
  }
  if (best == fits.size()) return;
  double sum = 0;
  for (const Rival& rival : step.ranking)
    if (rival.fit) sum += std::exp(rival.fit->log_evidence - best_evidence);
  const VectorXd mark = fits[best].at.residual - without.at.residual;
  for (std::size_t c = 0; c < fits.size(); ++c) {
    if (!step.ranking[c].fit) continue;
    RivalFit& fit = *step.ranking[c].fit;
    fit.probability = std::exp(fit.log_evidence - best_evidence) / sum;
    fit.told_apart =
        c == best
            ? mark.norm()
            : ResidualSpace(VectorXd::Zero(mark.size()), fits[c].at.jacobian).left_of(mark).norm();
  }
  find_imitators(without, fits[best], step);
}

// Rivals without a fit that do what the best does just as well, as far as their marks tell.
void Search::find_imitators(const BaseFit& without, const BaseFit& best,
                            DiagnosisStep& step) const {
  const ResidualSpace space(VectorXd::Zero(without.at.residual.size()), without.at.jacobian);
  const VectorXd mark = space.left_of(best.at.residual - without.at.residual);
  for (std::size_t i = 0; i < signatures_.size(); ++i) {
    Rival& rival = step.ranking[owner_[i].first];
    if (rival.fit || rival.not_fitted.empty()) continue;
    const MatrixXd columns = space.left_of(signatures_[i].columns);
    const MatrixXd span = span_of(columns, least_visible);
    const double left = (mark - span * (span.transpose() * mark)).norm();
    // What only exists in one direction does not imitate with the other.
    const vjm::EffectParameter& leading = rival.candidate.effect.kind->parameters.front();
    const bool one_sided = leading.lower >= leading.none;
    if (one_sided && columns.colPivHouseholderQr().solve(mark)[0] < 0) continue;
    rival.imitates |= left < told_apart_from;
  }
}

// The most probable first.
std::vector<std::size_t> order_of(const DiagnosisStep& step) {
  std::vector<std::size_t> order(step.ranking.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto key = [&](std::size_t i) {
    const Rival& r = step.ranking[i];
    return std::tuple(r.fit                    ? 0
                      : r.unobservable.empty() ? 1
                                               : 2,
                      r.fit ? -r.fit->log_evidence : -r.surprise);
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  return order;
}

// Rivals of the first in the ranking that may be what is really missing.
std::vector<std::size_t> indistinguishable(const DiagnosisStep& step) {
  std::vector<std::size_t> set;
  if (step.ranking.empty() || !step.ranking[0].fit) return set;
  const RivalFit& best = *step.ranking[0].fit;
  set.push_back(0);
  for (std::size_t i = 1; i < step.ranking.size(); ++i) {
    if (step.ranking[i].imitates) set.push_back(i);
    if (!step.ranking[i].fit) continue;
    const RivalFit& fit = *step.ranking[i].fit;
    const bool as_probable = best.log_evidence - fit.log_evidence < doubtful;
    const bool as_good =
        fit.told_apart < told_apart_from &&
        fit.squared_error - best.squared_error < told_apart_from * told_apart_from &&
        best.log_evidence - fit.log_evidence < 2 * doubtful;
    if (as_probable || as_good) set.push_back(i);
  }
  return set;
}

void arrange(DiagnosisStep& step, std::vector<BaseFit>& fits) {
  const std::vector<std::size_t> order = order_of(step);
  std::vector<Rival> ranking;
  std::vector<BaseFit> arranged;
  for (const std::size_t i : order) {
    ranking.push_back(std::move(step.ranking[i]));
    arranged.push_back(std::move(fits[i]));
  }
  step.ranking = std::move(ranking);
  fits = std::move(arranged);
  step.indistinguishable = indistinguishable(step);
}

// What passes the gate and helps to predict readings that it has not seen. What comes beside an
// effect may be what that one's law does not get quite right, so it must stand out further.
bool is_found(const DiagnosisStep& step) {
  const bool first = step.beside.empty();
  if (step.gate.p_value > (first ? significance_level : significance_of_more)) return false;
  if (step.indistinguishable.empty()) return false;
  const RivalFit& best = *step.ranking[0].fit;
  return best.log_score_gain > best.log_score_deviation &&
         (first || best.told_apart >= told_apart_from);
}

FoundEffect found_effect(const DiagnosisStep& step) {
  const Rival& best = step.ranking[0];
  FoundEffect found{.candidate = best.candidate,
                    .deviations = best.fit->deviations,
                    .probability = best.fit->probability,
                    .gate_p_value = step.gate.p_value};
  found.candidate.effect.values = best.fit->values;
  for (std::size_t i = 1; i < step.indistinguishable.size(); ++i)
    found.instead.push_back(step.ranking[step.indistinguishable[i]].candidate.name());
  return found;
}

std::optional<BaseFit> fit_if_possible(const Rivals& rivals, const std::vector<Candidate>& added,
                                       const BaseFit& start, files::Progress& progress) {
  try {
    return rivals.fit(added, &start, progress);
  } catch (const files::NoConvergence&) {
    return std::nullopt;
  } catch (const files::NotIdentifiable&) {
    return std::nullopt;
  }
}

// What a round beside all the other effects says of one that was found earlier.
void confirm(const DiagnosisStep& step, FoundEffect& found) {
  const std::string name = found.candidate.name();
  const auto it = std::find_if(step.ranking.begin(), step.ranking.end(),
                               [&](const Rival& r) { return r.candidate.name() == name; });
  found.gate_p_value = step.gate.p_value;
  found.probability = it != step.ranking.end() && it->fit ? it->fit->probability : 0;
  found.instead.clear();
  for (const std::size_t i : step.indistinguishable)
    if (step.ranking[i].candidate.name() != name)
      found.instead.push_back(step.ranking[i].candidate.name());
}

// One effect that does the work of several is the likelier one.
void doubt_beside_one(const std::vector<BaseFit>& alone, const DiagnosisStep& first,
                      const BaseFit& together, std::vector<FoundEffect>& found) {
  double temper = temper_of(together);
  for (const BaseFit& fit : alone)
    if (fit.values > 0) temper = std::max(temper, temper_of(fit));
  const double evidence = log_evidence(together, temper);
  for (std::size_t c = 0; c < alone.size(); ++c) {
    const std::string name = first.ranking[c].candidate.name();
    if (alone[c].values == 0 || evidence - log_evidence(alone[c], temper) > doubtful) continue;
    for (FoundEffect& f : found)
      if (f.candidate.name() != name &&
          std::find(f.instead.begin(), f.instead.end(), name) == f.instead.end())
        f.instead.push_back(name);
  }
}

// Where no load is taken back or reversed, friction only takes up a part of the load, as a gap
// takes up a part of the way; the details of either law are no evidence.
void doubt_friction(const Campaign& campaign, Diagnosis& d) {
  const std::vector<LoadDirection> directions = branches(campaign);
  const bool unloads = std::any_of(directions.begin(), directions.end(), [](LoadDirection branch) {
    return branch == LoadDirection::unloading;
  });
  if (unloads || !reversed_pairs(campaign).empty()) return;
  for (FoundEffect& found : d.found) {
    if (found.candidate.effect.kind->name != "friction") continue;
    const std::string gap = "clearance at " + found.candidate.effect.at;
    if (std::find(found.instead.begin(), found.instead.end(), gap) == found.instead.end())
      found.instead.push_back(gap);
    d.missing.push_back(
        "loads that are taken back or reversed: without them friction looks like a clearance");
  }
}

// Values and deviations of all that was found, from the fit that has all of it.
void take_values(const BaseFit& fit, std::vector<FoundEffect>& found) {
  std::size_t at = fit.parameters.size();
  for (auto f = found.rbegin(); f != found.rend(); ++f) {
    at -= static_cast<std::size_t>(f->candidate.effect.values.size());
    const FittedValues fitted = fitted_values(fit, at, f->candidate.effect.values.size());
    f->candidate.effect.values = fitted.values;
    f->deviations = fitted.deviations;
  }
}

std::optional<ChiSquareTest> test_of(const BaseFit& fit, NoiseSource source) {
  if (source == NoiseSource::unknown || fit.degrees_of_freedom() < 1) return std::nullopt;
  return chi_square_test(fit.squared_error, fit.degrees_of_freedom());
}

// Readings of some values, masked.
Campaign without(const Campaign& campaign, const std::vector<Value>& values,
                 const std::vector<std::size_t>& far, std::vector<std::string>& said) {
  Campaign result = campaign;
  for (const std::size_t v : far) {
    Reading& reading = result.readings[values[v].reading];
    if (reading.masked) continue;
    reading.masked = true;
    reading.mask_reason = "more than 5 standard deviations from all that any effect explains";
    said.push_back(fmt::format("reading '{}' ({}:{}): {}", reading.id,
                               campaign.readings_file.filename().string(), reading.line,
                               reading.mask_reason));
  }
  return result;
}

// Readings that are kept to confirm the outcome take no part in it.
Campaign without_confirming(Campaign campaign) {
  for (Reading& reading : campaign.readings)
    if (reading.role == Role::confirm && !reading.masked) {
      reading.masked = true;
      reading.mask_reason = "kept to confirm";
    }
  return campaign;
}

double excess(const std::optional<ChiSquareTest>& test) {
  return test ? test->statistic - static_cast<double>(test->degrees_of_freedom) : 0;
}

bool can_show_anything(const DiagnosisStep& step) {
  return std::any_of(step.ranking.begin(), step.ranking.end(),
                     [](const Rival& r) { return r.detectability >= told_apart_from; });
}

void judge(Diagnosis& d) {
  const bool misfit = d.after && d.after->p_value < 1e-3;
  const bool structure_left = d.structure.p_value < 0.01;
  const double before = excess(d.before);
  const double share_left = before > 0 ? std::max(0.0, excess(d.after)) / before : 0;
  if (d.found.empty()) {
    if (structure_left)
      d.verdict = Verdict::none_of_the_above;
    else if (d.steps.empty() || !can_show_anything(d.steps.front()))
      d.verdict = Verdict::cannot_tell;
    else
      d.verdict = Verdict::no_effect_needed;
    return;
  }
  if (misfit && structure_left && share_left > unexplained_share)
    d.verdict = Verdict::none_of_the_above;
  else
    d.verdict = d.ambiguous.size() > 1 ? Verdict::ambiguous : Verdict::named_effect;
}

Diagnosis cannot_tell_without_noise() {
  Diagnosis d;
  d.missing.push_back(
      "how exact the readings are: state the instrument's noise in the campaign file, or repeat "
      "readings under the same load; noise is never taken from the misfit of the model itself");
  return d;
}

}  // namespace

std::string to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::no_effect_needed:
      return "no effect needed";
    case Verdict::named_effect:
      return "named effect";
    case Verdict::ambiguous:
      return "ambiguous";
    case Verdict::none_of_the_above:
      return "none of the above";
    case Verdict::cannot_tell:
      break;
  }
  return "these data cannot tell";
}

Diagnosis diagnose(const vjm::Robot& robot, const Campaign& whole, const DiagnosisOptions& options,
                   int threads, files::Progress& progress) {
  const std::vector<Candidate> tried = candidates(robot, options.kinds);
  const Campaign given = without_confirming(whole);
  const Noise noise = noise_of(robot, whole, threads, progress);
  if (noise.source == NoiseSource::unknown) return cannot_tell_without_noise();
  Diagnosis d;
  d.noise = noise.source;
  const Rivals all(robot, given, noise, threads, progress);
  Search whole_search(all, tried, options, threads, progress);
  BaseFit fit = all.fit({}, nullptr, progress);
  whole_search.screen({}, fit);
  const Campaign campaign =
      without(given, whole_search.values(), whole_search.outliers(fit), d.set_aside);
  const Rivals rivals(robot, campaign, noise, threads, progress);
  Search search(rivals, tried, options, threads, progress);
  search.take_marks(whole_search);
  if (!d.set_aside.empty()) fit = rivals.fit({}, &fit, progress);
  const Structure structure(campaign, search.values());
  d.before = test_of(fit, noise.source);
  d.weak = fit.weak;
  d.held_out = search.groups().what;
  const Campaign kept = only(whole, Role::confirm);
  const auto add_stage = [&](const std::string& name, const BaseFit& stage,
                             const std::vector<Candidate>& added) {
    d.waterfall.push_back(
        waterfall_stage(name, stage, search.values(), noise, search.groups(), options.seed));
    if (has_role(whole, Role::confirm))
      d.waterfall.back().confirmed = rivals.error_on(kept, stage, added, progress);
  };
  {
    const Predictor predictor(robot.without_effects(), robot.effects, campaign, threads, progress);
    add_stage("as designed", fit_base(predictor, campaign, noise, {}, progress), {});
  }
  if (!fit.parameters.empty()) add_stage("refitted", fit, {});
  std::vector<Candidate> present;
  std::vector<BaseFit> alone;  // models with one effect
  while (present.size() < options.most_effects) {
    if (!present.empty()) search.screen(present, fit);
    std::vector<BaseFit> fits;
    DiagnosisStep step = search.step(present, fit, fits);
    arrange(step, fits);
    d.steps.push_back(step);
    if (!is_found(step)) break;
    fit = fits[0];
    if (present.empty()) alone = std::move(fits);
    present.push_back(step.ranking[0].candidate);
    present.back().effect.values = step.ranking[0].fit->values;
    d.found.push_back(found_effect(step));
    add_stage("+ " + present.back().name(), fit, present);
  }
  // With all of them in the model each must still be what is best in its place.
  for (std::size_t k = 0; k + 1 < present.size(); ++k) {
    std::vector<Candidate> others = present;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    const std::optional<BaseFit> without_it = fit_if_possible(rivals, others, fit, progress);
    if (!without_it) continue;  // then it is needed all the more
    search.screen(others, *without_it);
    std::vector<BaseFit> fits;
    DiagnosisStep step = search.step(others, *without_it, fits);
    arrange(step, fits);
    confirm(step, d.found[k]);
    d.steps.push_back(std::move(step));
  }
  if (present.size() > 1) doubt_beside_one(alone, d.steps[0], fit, d.found);
  take_values(fit, d.found);
  doubt_friction(campaign, d);
  for (const FoundEffect& found : d.found) {
    if (found.instead.empty()) continue;
    d.ambiguous.push_back(found.candidate.name());
    d.ambiguous.insert(d.ambiguous.end(), found.instead.begin(), found.instead.end());
  }
  d.waterfall.push_back(noise_floor(search.values(), noise));
  d.after = test_of(fit, noise.source);
  d.structure = structure_test(structure, {-fit.at.residual, fit.at.jacobian}, options.draws,
                               options.seed, threads);
  judge(d);
  if (options.profiles > 0) d.profiles = profiles(rivals, present, fit, options.profiles, progress);
  return d;
}

}  // namespace kinetostat::calibration

// One round of the search for the missing effect: screen all candidates beside a fitted model,
// compare the largest score with the detection threshold, fit the survivors.
#pragma once

#include <functional>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "kinetostat/calibration/search/diagnosis_options.h"
#include "kinetostat/calibration/search/fit_starts.h"
#include "kinetostat/calibration/search/outliers.h"
#include "kinetostat/calibration/search/ranking.h"
#include "kinetostat/calibration/search/signature_table.h"

namespace kinetostat::calibration {

/// A fit that has been found already, with a candidate behind what is present.
struct KnownFit {
  std::string name;  // of the candidate
  BaseFit fit;
};

/// Rounds on the same readings with the same candidates. Keeps references.
class Search {
 public:
  Search(const CandidateFitter& fitter, const std::vector<Candidate>& candidates,
         const DiagnosisOptions& options, int threads, common::Progress& progress)
      : fitter_(fitter),
        candidates_(candidates),
        options_(options),
        threads_(threads),
        progress_(progress),
        values_(values_in_use(fitter.campaign())),
        groups_(held_out_groups(fitter.campaign(), values_)),
        correlated_(fitter.campaign(), values_, fitter.noise()) {}

  /// Prepares the unmodelled smooth error from the fit of the model without anything added.
  void prepare_free_form(const BaseFit& fit) {
    free_form_.emplace(fitter_.campaign(), values_, fitter_.free_form_ways(fit, progress_));
  }
  const FreeForm& free_form() const { return *free_form_; }
  const CorrelatedNoise& correlated_noise() const { return correlated_; }

  const std::vector<Value>& values() const { return values_; }
  const HeldOutGroups& groups() const { return groups_; }

  /// Screens all candidates beside what is present.
  void screen(const std::vector<Candidate>& present, const BaseFit& fit);

  /// Takes over the signatures from a search with the same readings and more, which then has none.
  void take_signatures(Search& wider);

  /// Values that no likely effects explain (outliers.h). After screen() without anything added.
  std::vector<std::size_t> outliers(const BaseFit& fit) const;

  /// Signatures at their usual sizes beside a fit. After screen() without anything added.
  SignatureTable signature_table(const BaseFit& fit) const;

  /// Pairs of candidates that are significant together though none is alone, sized as their
  /// signatures ask, the most significant first; empty unless they exceed their own detection
  /// threshold. After screen().
  std::vector<std::vector<Candidate>> masked_pairs(const BaseFit& fit) const;

  /// Candidates that are confounded with the fitted parameters, of which some signature alone is
  /// about the change from nominal to fitted predictions. After screen() without anything added.
  std::vector<Candidate> like_the_fit(const BaseFit& nominal, const BaseFit& fitted) const;

  /// Share of the squared residual, per degree of freedom, that all candidates which move the
  /// target as errors of the kinematics do explain together, to first order. 0 or less where that
  /// is no more than so many columns of noise would. After screen() without anything added.
  double explained_by_kinematics(const BaseFit& fit) const;

  /// The round itself, after screen(); `fit` is that of the model with what is present. `fits`: of
  /// the candidates, in the order of the ranking; without values where there is none. `known`
  /// takes the place of a worse fit of that candidate.
  DiagnosisStep step(const std::vector<Candidate>& present, const BaseFit& fit,
                     std::vector<BaseFit>& fits, const KnownFit* known = nullptr);

 private:
  // Of what each effect has among signatures_, when it is looked for beside outliers.
  struct ByEffect {
    std::vector<std::vector<std::size_t>> signatures;
    std::vector<EffectEntry> entries;
  };
  ByEffect signatures_by_effect() const;
  void fit_survivors(const std::vector<Candidate>& present, const BaseFit& fit,
                     const std::vector<double>& explained, const ResidualSpace& space,
                     DiagnosisStep& step, CandidateFits& fits);
  // What is present with one candidate more; where its fit ends, where that is known roughly.
  struct Start {
    std::vector<Candidate> added;
    std::optional<CondensedFit> end;
  };
  std::vector<Start> with_ends(const FittedModel& beside,
                               const std::vector<Candidate>& starts) const;
  BaseFit best_fit(const FittedModel& beside, double promised, const std::vector<Candidate>& starts,
                   std::string& reason) const;
  BaseFit to_the_end(const FittedModel& beside, Candidate& candidate, BaseFit fit) const;
  void finish(const FittedModel& beside, DiagnosisStep& step, std::vector<BaseFit>& fits) const;
  void add_orders(const FittedModel& beside, const DiagnosisStep& step, CandidateFits& fits) const;
  BaseFit with_one_more_order(const FittedModel& beside, Candidate candidate,
                              const BaseFit& fit) const;
  void shared_out(std::string_view phase, const FittedModel& beside,
                  const std::vector<Candidate>& items,
                  const std::function<void(std::size_t)>& work) const;
  MaxScoreTest correlated_max_score_test(const BaseFit& fit, std::size_t way) const;
  bool excludes_correlated_noise(const BaseFit& fit) const;
  double longest_signature(std::size_t candidate) const;
  FitStarts starts_of(std::size_t candidate, const FittedModel& beside,
                      const std::vector<double>& explained, const ResidualSpace& space) const;
  static void keep_better(const KnownFit& known, DiagnosisStep& step, std::vector<BaseFit>& fits);
  void find_confounded(const BaseFit& without, const BaseFit& best, DiagnosisStep& step) const;
  void confuse(const Screen& screen, DiagnosisStep& step) const;
  std::vector<std::size_t> most_explaining(const Screen& screen,
                                           const Eigen::VectorXd& residual) const;
  void find_pairs(const Screen& screen, const Eigen::VectorXd& residual, DiagnosisStep& step) const;

  const CandidateFitter& fitter_;
  const std::vector<Candidate>& candidates_;
  const DiagnosisOptions& options_;
  int threads_;
  common::Progress& progress_;
  std::vector<Value> values_;
  HeldOutGroups groups_;
  CorrelatedNoise correlated_;
  std::optional<FreeForm> free_form_;
  std::vector<CandidateFitter::Signatures> candidate_signatures_;  // one a candidate, without `all`
  std::vector<Signature> signatures_;
  std::vector<std::pair<std::size_t, std::size_t>> owner_;  // candidate, its signature
};

}  // namespace kinetostat::calibration

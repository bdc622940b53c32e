// One round of the search for what is missing: screen all candidates beside a fitted model, pass
// the gate, fit what survives.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "kinetostat/calibration/diagnosis/diagnosis_options.h"
#include "kinetostat/calibration/diagnosis/ranking.h"

namespace kinetostat::calibration {

/// Rounds on the same readings with the same candidates. Keeps references.
class Search {
 public:
  Search(const Rivals& rivals, const std::vector<Candidate>& candidates,
         const DiagnosisOptions& options, int threads, common::Progress& progress)
      : rivals_(rivals),
        candidates_(candidates),
        options_(options),
        threads_(threads),
        progress_(progress),
        values_(values_in_use(rivals.campaign())),
        groups_(held_out_groups(rivals.campaign(), values_)),
        correlated_(rivals.campaign(), values_, rivals.noise()) {}

  /// What the free-form rival may act through: that of the model without anything added.
  void prepare_free_form(const BaseFit& fit) {
    free_form_.emplace(rivals_.campaign(), values_, rivals_.free_form_ways(fit, progress_));
  }
  const FreeForm& free_form() const { return *free_form_; }
  const CorrelatedNoise& correlated_noise() const { return correlated_; }

  const std::vector<Value>& values() const { return values_; }
  const HeldOutGroups& groups() const { return groups_; }

  /// Screens all candidates beside what is present.
  void screen(const std::vector<Candidate>& present, const BaseFit& fit);

  /// Takes over the marks from a search with the same readings and more.
  void take_marks(const Search& wider);

  /// Values that not all the catalogue together explains: outliers, where they are few.
  std::vector<std::size_t> outliers(const BaseFit& fit) const;

  /// Pairs of candidates that show together though none shows alone, sized as their marks ask, the
  /// most surprising first; empty unless their own gate lets them pass. After screen().
  std::vector<std::vector<Candidate>> masked_pairs(const BaseFit& fit) const;

  /// Candidates that do not show beside the refit, of which some mark alone is about what refitting
  /// does to the predictions of the model as designed. After screen() without anything added.
  std::vector<Candidate> like_the_refit(const BaseFit& designed, const BaseFit& refitted) const;

  /// The round itself, after screen(); `fit` is that of the model with what is present. `fits`: of
  /// the rivals, in the order of the ranking; without values where there is none.
  DiagnosisStep step(const std::vector<Candidate>& present, const BaseFit& fit,
                     std::vector<BaseFit>& fits);

 private:
  void fit_survivors(const std::vector<Candidate>& present, const BaseFit& fit,
                     const Screen& screen, const ResidualSpace& space, DiagnosisStep& step,
                     std::vector<BaseFit>& fits);
  Gate gate_under_noise_of(const BaseFit& fit, const Screen& screen,
                           const ResidualSpace& space) const;
  double explained_by(std::size_t candidate, const Screen& screen,
                      const ResidualSpace& space) const;
  struct Look {
    double explained;  // of the squared residual
    Candidate as_it_is, resized;
  };
  std::vector<Look> looks_of(std::size_t candidate, const std::vector<Candidate>& present,
                             const BaseFit& fit, const Screen& screen,
                             const ResidualSpace& space) const;
  static std::vector<Candidate> starts_of(const std::vector<Look>& looks);
  void find_imitators(const BaseFit& without, const BaseFit& best, DiagnosisStep& step) const;
  void confuse(const Screen& screen, DiagnosisStep& step) const;

  const Rivals& rivals_;
  const std::vector<Candidate>& candidates_;
  const DiagnosisOptions& options_;
  int threads_;
  common::Progress& progress_;
  std::vector<Value> values_;
  HeldOutGroups groups_;
  CorrelatedNoise correlated_;
  std::optional<FreeForm> free_form_;
  std::vector<Rivals::Marks> marks_;  // one a candidate
  std::vector<Signature> signatures_;
  std::vector<std::pair<std::size_t, std::size_t>> owner_;  // candidate, its mark
};

}  // namespace kinetostat::calibration

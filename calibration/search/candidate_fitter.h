// The models that have something more than the robot file says.
#pragma once

#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/regression/base_fit.h"
#include "kinetostat/calibration/search/candidate.h"
#include "kinetostat/calibration/search/fit_journal.h"
#include "kinetostat/calibration/search/free_form.h"
#include "kinetostat/calibration/statistics/residual_space.h"

namespace kinetostat::calibration {

/// A fitted model beside which candidates are looked at. Keeps references, and what looks share,
/// found when first asked for: its key, and the model with those joints condensed in which
/// candidates act alone.
class FittedModel {
 public:
  FittedModel(const std::vector<Candidate>& present, const BaseFit& fit,
              const std::vector<Candidate>& looked_at, const vjm::Manipulator& bare);

  const std::vector<Candidate>& present() const { return present_; }
  const BaseFit& fit() const { return fit_; }
  /// Of the journal: fitted_key().
  const std::string& key() const;

 private:
  friend class CandidateFitter;
  const std::vector<Candidate>& present_;
  const BaseFit& fit_;
  std::vector<vjm::JointPlace> joints_;
  mutable std::once_flag is_condensed_, has_key_;
  mutable CondensedModel condensed_;
  mutable std::string key_;
};

/// How far a fit is taken.
struct FitEffort {
  int max_iterations = 60;
  double least_gain = 0;  // BaseFitOptions::least_gain
};

/// A robot, a campaign, and the fits of models with something more.
class CandidateFitter {
 public:
  /// Throws what Predictor does. Keeps references. Fits and signatures that `journal` (or nullptr)
  /// has are not computed.
  CandidateFitter(const vjm::Robot& robot, const Campaign& campaign, const Noise& noise,
                  int threads, common::Progress& progress, FitJournal* journal = nullptr);

  /// Fits the parameters that are fitted under every candidate (declared uncertain by the user,
  /// zero offsets, frames) and the values of the added effects. Where the first fit (without
  /// `start`) cannot determine a stiffness, and no unit error or sign error explains that, every
  /// uncertain stiffness without stated bounds gets a prior: its nominal value, to a factor of e,
  /// and no farther off than e^3. The prior holds in that fit and in those that start at it. Throws
  /// common::NotIdentifiable where that does not help.
  BaseFit fit(const std::vector<Candidate>& added, const BaseFit* start,
              common::Progress& progress) const;
  /// The same on one thread, for fits that are shared out among threads, as long as it gains so
  /// much (BaseFitOptions::least_gain); from where it ended roughly, where that is known.
  BaseFit fit_on_one_thread(const std::vector<Candidate>& added, const BaseFit& start,
                            const std::optional<CondensedFit>& rough, double least_gain,
                            common::Progress& progress) const;
  /// Where the fit of the last of the added ones would end beside a fitted model with the others:
  /// fit_condensed(), where it is a law in one joint that can be condensed.
  std::optional<CondensedFit> fit_condensed(const std::vector<Candidate>& added,
                                            const FittedModel& beside,
                                            common::Progress& progress) const;
  /// Goes on from such a fit until it has settled.
  BaseFit finished(const std::vector<Candidate>& added, const BaseFit& fit,
                   common::Progress& progress) const;

  /// fit() as far as `effort` goes, for a first look at many starts: nothing of it is in the
  /// journal.
  BaseFit fit_roughly(const std::vector<Candidate>& added, const BaseFit& start,
                      const FitEffort& effort, int threads, common::Progress& progress) const;

  /// All parameters of a fit with these effects held, against the readings here: zero offsets and
  /// frames are fitted anew.
  BaseFit as_fitted(const std::vector<Candidate>& added, const BaseFit& fit,
                    common::Progress& progress) const;

  /// fit() with one parameter held at a value, starting at a fit with the same effects.
  BaseFit fit_held(const std::vector<Candidate>& added, const BaseFit& start, std::size_t held,
                   double value, common::Progress& progress) const;

  /// The values of the last of the added ones, as a fit has them; those that design fixes have no
  /// range.
  std::vector<Parameter> own_parameters(const std::vector<Candidate>& added) const;

  /// Signatures of one candidate beside a model that is fitted already (with `present` effects): of
  /// its usual size, and of other sizes where its shape depends on that. Empty with a reason where
  /// the model has no equilibrium with it. On one thread: candidates may be shared out.
  using Signatures = CandidateSignatures;
  Signatures signatures_of(const Candidate& candidate, const FittedModel& beside,
                           common::Progress& progress) const;
  Signatures signatures_of(const Candidate& candidate, const std::vector<Candidate>& present,
                           const BaseFit& fit, common::Progress& progress) const {
    return signatures_of(
        candidate, FittedModel(present, fit, {candidate}, robot_.without_effects()), progress);
  }
  FittedModel beside(const std::vector<Candidate>& present, const BaseFit& fit,
                     const std::vector<Candidate>& looked_at) const {
    return {present, fit, looked_at, robot_.without_effects()};
  }

  /// Ways in which the unmodelled smooth error may act, in `fit` of the model without anything
  /// added.
  FreeFormWays free_form_ways(const BaseFit& fit, common::Progress& progress) const;

  /// Other readings of the campaign, predicted by such a fit that did not use them
  /// (predict_others).
  BaseFit predicted(const Campaign& others, const BaseFit& fit, const std::vector<Candidate>& added,
                    common::Progress& progress) const;
  /// Rms error, in units of the noise, of other readings of the campaign, predicted by such a fit
  /// that did not use them; NaN where the model has no equilibrium for one.
  double error_on(const Campaign& others, const BaseFit& fit, const std::vector<Candidate>& added,
                  common::Progress& progress) const;

  /// Predictor of the robot as its file has it.
  const Predictor& predictor() const { return predictor_; }
  const Campaign& campaign() const { return campaign_; }
  const vjm::Manipulator& bare() const { return robot_.without_effects(); }
  /// designs_of() beside those of the robot file and these.
  std::vector<Candidate> designs_beside(const Candidate& candidate,
                                        const std::vector<Candidate>& present) const {
    return designs_of(candidate, bare(), effects_with(robot_, present));
  }
  bool has_gravity() const { return !robot_.manipulator.gravity().isZero(0); }
  const Noise& noise() const { return noise_; }
  /// Uncertain parameters that stay at their nominal values, because these readings do not
  /// determine them, in sentences.
  const std::vector<std::string>& kept_nominal() const { return kept_; }

 private:
  Eigen::MatrixXd by_force(const BaseFit& fit, common::Progress& progress) const;
  std::vector<FreeFormWays::Drive> drives(const BaseFit& fit, common::Progress& progress) const;
  std::vector<Parameter> parameters(const std::vector<vjm::Effect>& effects,
                                    const std::vector<Candidate>& added) const;
  std::vector<Parameter> unknowns_near(const std::vector<vjm::Effect>& effects,
                                       const std::vector<Candidate>& added,
                                       const BaseFit& start) const;
  BaseFit fitted(const std::vector<vjm::Effect>& effects, const std::vector<Parameter>& unknowns,
                 const BaseFit* near, const FitEffort& effort, int threads,
                 common::Progress& progress) const;
  BaseFit fitted_as_given(const std::vector<vjm::Effect>& effects,
                          const std::vector<Parameter>& unknowns, const BaseFit* near,
                          const FitEffort& effort, int threads, common::Progress& progress) const;
  // Of a model with effects added: what is uncertain anyway near its design; nothing where it is.
  std::optional<std::vector<Parameter>> with_design(std::vector<Parameter> unknowns) const;
  BaseFit computed(const std::vector<vjm::Effect>& effects, const std::vector<Parameter>& unknowns,
                   const BaseFit* near, const FitEffort& effort, int threads,
                   common::Progress& progress) const;
  // Which of the parameters that are fitted anyway is that of a joint's own spring.
  std::optional<std::size_t> stiffness_of(const vjm::JointPlace& joint) const;
  // Of the journal, or nothing; and to it. One thread at a time.
  std::optional<std::string> recorded(const std::string& key) const;
  void keep(const std::string& key, const std::string& record) const;
  const CondensedModel& condensed(const FittedModel& beside, common::Progress& progress) const;
  Signatures computed_signatures(const Candidate& candidate, const FittedModel& beside,
                                 common::Progress& progress) const;
  struct Look {
    Signature signature;
    double bend = 1;  // share of it that does not grow with the size of the effect
  };
  // At the last candidate with its current values, which are `growth` times usual; only
  // `for_direction` is its bend looked at. nullopt if the model has no equilibrium.
  std::optional<Look> look_at(const Predictor& predictor, const std::vector<Candidate>& added,
                              double growth, bool for_direction, const FittedModel& beside,
                              common::Progress& progress) const;
  std::optional<Look> first_look(const Predictor& predictor, std::vector<Candidate>& added,
                                 const Candidate& candidate, bool for_direction,
                                 const FittedModel& beside, common::Progress& progress) const;
  // Adds the signatures of one design, in the place of the last candidate. `firsts`: which are
  // those that designs were looked at first.
  void add_signatures(const Predictor& predictor, const Candidate& candidate,
                      std::vector<Candidate> added, const FittedModel& beside,
                      Signatures& signatures, std::vector<std::size_t>& firsts,
                      common::Progress& progress) const;

  Candidate resolved(Candidate candidate) const;

  const vjm::Robot& robot_;
  const Campaign& campaign_;
  const Noise& noise_;
  Predictor predictor_;  // of the robot as it is
  std::vector<Parameter> base_;
  std::vector<std::string> kept_;
  int threads_;
  FitJournal* journal_;
  mutable std::mutex journal_in_use_;
  std::string scope_;  // of the journal's keys
  double interval_;    // usual time between two readings of a cycle [s]; 0: there is none
};

}  // namespace kinetostat::calibration

// The models that have something more than the robot file says.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/diagnosis/candidate.h"
#include "kinetostat/calibration/diagnosis/fit_journal.h"
#include "kinetostat/calibration/diagnosis/free_form.h"
#include "kinetostat/calibration/regression/base_fit.h"
#include "kinetostat/calibration/statistics/residual_space.h"

namespace kinetostat::calibration {

/// A robot, a campaign, and the fits of models with something more.
class Rivals {
 public:
  /// Throws what Predictor does. Keeps references. What `journal` (or nullptr) has of fits and
  /// marks is not computed.
  Rivals(const vjm::Robot& robot, const Campaign& campaign, const Noise& noise, int threads,
         common::Progress& progress, FitJournal* journal = nullptr);

  /// What is fitted under every rival: what the user declared uncertain, zeros and frames. Where
  /// the first fit (without `start`) cannot determine a stiffness, and no slip in units or signs is
  /// why, all that are uncertain and without stated bounds are known by design to a factor of e,
  /// and no farther off than its third power, in it and in those that begin at it. Throws
  /// common::NotIdentifiable where that does not help.
  BaseFit fit(const std::vector<Candidate>& added, const BaseFit* start,
              common::Progress& progress) const;

  /// The same with one parameter held at a value, begun at a fit with the same effects.
  BaseFit fit_held(const std::vector<Candidate>& added, const BaseFit& start, std::size_t held,
                   double value, common::Progress& progress) const;

  /// The values of the last of the added ones, as a fit has them; those that design fixes have no
  /// range.
  std::vector<Parameter> own_parameters(const std::vector<Candidate>& added) const;

  /// Marks of one candidate beside a model that is fitted already (with `present` effects): of its
  /// usual size, and of other sizes where its shape depends on that. Empty with a reason where the
  /// model has no equilibrium with it.
  using Marks = CandidateMarks;
  Marks marks_of(const Candidate& candidate, const std::vector<Candidate>& present,
                 const BaseFit& fit, common::Progress& progress) const;

  /// What the free-form rival may act through, in `fit` of the model without anything added.
  FreeFormWays free_form_ways(const BaseFit& fit, common::Progress& progress) const;

  /// Rms over the noise of other readings of the campaign, predicted by such a fit that did not use
  /// them; NaN where the model has no equilibrium for one.
  double error_on(const Campaign& others, const BaseFit& fit, const std::vector<Candidate>& added,
                  common::Progress& progress) const;

  /// Of the robot as its file has it.
  const Predictor& predictor() const { return predictor_; }
  const Campaign& campaign() const { return campaign_; }
  bool has_gravity() const { return !robot_.manipulator.gravity().isZero(0); }
  const Noise& noise() const { return noise_; }
  /// What was declared uncertain and stays as designed, because these readings do not determine it,
  /// in sentences.
  const std::vector<std::string>& kept_as_designed() const { return kept_; }

 private:
  Eigen::MatrixXd by_force(const BaseFit& fit, common::Progress& progress) const;
  std::vector<FreeFormWays::Drive> drives(const BaseFit& fit, common::Progress& progress) const;
  std::vector<Parameter> parameters(const std::vector<vjm::Effect>& effects,
                                    const std::vector<Candidate>& added) const;
  BaseFit fitted(const std::vector<vjm::Effect>& effects, const std::vector<Parameter>& unknowns,
                 const BaseFit* near, common::Progress& progress) const;
  Marks computed_marks(const Candidate& candidate, const std::vector<Candidate>& present,
                       const BaseFit& fit, common::Progress& progress) const;
  // Of the last of the added ones, at its values, which are `growth` times usual; nothing where
  // there is no equilibrium.
  std::optional<Signature> mark_of(const Predictor& predictor, const std::vector<Candidate>& added,
                                   double growth, const BaseFit& fit,
                                   common::Progress& progress) const;
  // Of one design, in the place of the last of the added ones.
  void add_marks(const Predictor& predictor, const Candidate& candidate,
                 std::vector<Candidate> added, const BaseFit& fit, Marks& marks,
                 common::Progress& progress) const;

  Candidate resolved(Candidate candidate) const;

  const vjm::Robot& robot_;
  const Campaign& campaign_;
  const Noise& noise_;
  Predictor predictor_;  // of the robot as it is
  std::vector<Parameter> base_;
  std::vector<std::string> kept_;
  FitJournal* journal_;
  std::string scope_;  // of the journal's keys
  double interval_;    // usual time between two readings of a cycle [s]; 0: there is none
};

}  // namespace kinetostat::calibration

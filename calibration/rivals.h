// What could be missing from a model, and the models that have it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/base_fit.h"
#include "kinetostat/calibration/fit_journal.h"
#include "kinetostat/calibration/free_form.h"
#include "kinetostat/calibration/residual_space.h"

namespace kinetostat::calibration {

/// An effect of the catalogue (or of the user) at a place where the robot has none of its kind yet.
struct Candidate {
  /// Usual values: one prior standard deviation from where there is no effect, within the physical
  /// range, for the leading value and those that must be given; the others where there is none.
  vjm::Effect effect;
  std::vector<double> deviations;  // prior standard deviations of its values [SI]
  std::size_t designs = 1;         // in how many ways values that design fixes may be fixed

  std::string name() const;  // "clearance at x.rho"
};

/// All of them, in the order of the catalogue, then of the places. `kinds`: of these kinds only;
/// empty: all. A place that stands for several (a joint of each chain) is a candidate beside them.
std::vector<Candidate> candidates(const vjm::Robot& robot, const std::vector<std::string>& kinds);

/// A kind of effect that the robot has no place for, and why.
struct KindWithoutPlace {
  std::string name, reason;
};
/// Of the kinds that candidates() tries; those that the robot has already do not count.
std::vector<KindWithoutPlace> kinds_without_place(const vjm::Robot& robot,
                                                  const std::vector<std::string>& kinds);

/// Those of the robot, then the added ones.
std::vector<vjm::Effect> effects_with(const vjm::Robot& robot, const std::vector<Candidate>& added);

/// Of an effect that was added to a model.
struct FittedValues {
  Eigen::VectorXd values, deviations;  // NaN where a bound holds a value
};
/// Of each of the added effects: their values are the last parameters of the fit.
std::vector<FittedValues> fitted_values(const BaseFit& fit, const std::vector<Candidate>& added);

/// Whether stiffnesses are known by design in such a fit, because readings alone drive one to
/// infinity or zero.
bool is_held_near_design(const BaseFit& fit);

/// A robot, a campaign, and the fits of models with something more.
class Rivals {
 public:
  /// Throws what Predictor does. Keeps references. What `journal` (or nullptr) has of fits and
  /// marks is not computed.
  Rivals(const vjm::Robot& robot, const Campaign& campaign, const Noise& noise, int threads,
         files::Progress& progress, FitJournal* journal = nullptr);

  /// What is fitted under every rival: what the user declared uncertain, zeros and frames. Where
  /// the first fit (without `start`) cannot determine a stiffness, and no slip in units or signs is
  /// why, all that are uncertain and without stated bounds are known by design to a factor of e,
  /// and no farther off than its third power, in it and in those that begin at it. Throws
  /// files::NotIdentifiable where that does not help.
  BaseFit fit(const std::vector<Candidate>& added, const BaseFit* start,
              files::Progress& progress) const;

  /// The same with one parameter held at a value, begun at a fit with the same effects.
  BaseFit fit_held(const std::vector<Candidate>& added, const BaseFit& start, std::size_t held,
                   double value, files::Progress& progress) const;

  /// The values of the last of the added ones, as a fit has them; those that design fixes have no
  /// range.
  std::vector<Parameter> own_parameters(const std::vector<Candidate>& added) const;

  /// Marks of one candidate beside a model that is fitted already (with `present` effects): of its
  /// usual size, and of other sizes where its shape depends on that. Empty with a reason where the
  /// model has no equilibrium with it.
  struct Marks {
    std::vector<Signature> signatures;
    std::vector<Candidate> starts;  // the candidate at the size of each signature
    std::string failure;
  };
  Marks marks_of(const Candidate& candidate, const std::vector<Candidate>& present,
                 const BaseFit& fit, files::Progress& progress) const;

  /// What the free-form rival may act through, in `fit` of the model without anything added.
  FreeFormWays free_form_ways(const BaseFit& fit, files::Progress& progress) const;

  /// Rms over the noise of other readings of the campaign, predicted by such a fit that did not use
  /// them; NaN where the model has no equilibrium for one.
  double error_on(const Campaign& others, const BaseFit& fit, const std::vector<Candidate>& added,
                  files::Progress& progress) const;

  /// Of the robot as its file has it.
  const Predictor& predictor() const { return predictor_; }
  const Campaign& campaign() const { return campaign_; }
  bool has_gravity() const { return !robot_.manipulator.gravity().isZero(0); }
  const Noise& noise() const { return noise_; }
  /// What was declared uncertain and stays as designed, because these readings do not determine it,
  /// in sentences.
  const std::vector<std::string>& kept_as_designed() const { return kept_; }

 private:
  Eigen::MatrixXd by_force(const BaseFit& fit, files::Progress& progress) const;
  std::vector<FreeFormWays::Drive> drives(const BaseFit& fit, files::Progress& progress) const;
  std::vector<Parameter> parameters(const std::vector<vjm::Effect>& effects,
                                    const std::vector<Candidate>& added) const;
  BaseFit fitted(const std::vector<vjm::Effect>& effects, const std::vector<Parameter>& unknowns,
                 const BaseFit* near, files::Progress& progress) const;
  Marks computed_marks(const Candidate& candidate, const std::vector<Candidate>& present,
                       const BaseFit& fit, files::Progress& progress) const;
  // Of the last of the added ones, at its values, which are `growth` times usual; nothing where
  // there is no equilibrium.
  std::optional<Signature> mark_of(const Predictor& predictor, const std::vector<Candidate>& added,
                                   double growth, const BaseFit& fit,
                                   files::Progress& progress) const;
  // Of one design, in the place of the last of the added ones.
  void add_marks(const Predictor& predictor, const Candidate& candidate,
                 std::vector<Candidate> added, const BaseFit& fit, Marks& marks,
                 files::Progress& progress) const;

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

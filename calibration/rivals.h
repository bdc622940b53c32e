// Candidates: effects that could be missing from a model, and the fitted models that have them.
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
/// Those of the kinds that candidates() tries; kinds that the robot has already do not count.
std::vector<KindWithoutPlace> kinds_without_place(const vjm::Robot& robot,
                                                  const std::vector<std::string>& kinds);

/// Those of the robot, then the added ones.
std::vector<vjm::Effect> effects_with(const vjm::Robot& robot, const std::vector<Candidate>& added);

/// Fitted values of an effect that was added to a model.
struct FittedValues {
  Eigen::VectorXd values, deviations;  // NaN where a bound holds a value
};
/// Fitted values of each of the added effects: they are the last parameters of the fit.
std::vector<FittedValues> fitted_values(const BaseFit& fit, const std::vector<Candidate>& added);

/// Whether stiffnesses have a prior at their nominal values in such a fit, because readings alone
/// drive one to infinity or to 0.
bool is_held_near_design(const BaseFit& fit);

/// A robot, a campaign, and the fits of models with something more.
class CandidateFitter {
 public:
  /// Throws what Predictor does. Keeps references. Fits and signatures that `journal` (or nullptr)
  /// has are not computed.
  CandidateFitter(const vjm::Robot& robot, const Campaign& campaign, const Noise& noise,
                  int threads, files::Progress& progress, FitJournal* journal = nullptr);

  /// Fits the parameters that are fitted under every candidate (declared uncertain by the user,
  /// zero offsets, frames) and the values of the added effects. Where the first fit (without
  /// `start`) cannot determine a stiffness, and no unit error or sign error explains that, every
  /// uncertain stiffness without stated bounds gets a prior: its nominal value, to a factor of e,
  /// and no farther off than e^3. The prior holds in that fit and in those that start at it. Throws
  /// files::NotIdentifiable where that does not help.
  BaseFit fit(const std::vector<Candidate>& added, const BaseFit* start,
              files::Progress& progress) const;

  /// The same with one parameter held at a value, starting at a fit with the same effects.
  BaseFit fit_held(const std::vector<Candidate>& added, const BaseFit& start, std::size_t held,
                   double value, files::Progress& progress) const;

  /// The values of the last of the added ones, as a fit has them; those that design fixes have no
  /// range.
  std::vector<Parameter> own_parameters(const std::vector<Candidate>& added) const;

  /// Signatures of one candidate beside a model that is fitted already (with `present` effects): at
  /// its usual size, and at other sizes where its shape depends on that. Empty with a reason where
  /// the model has no equilibrium with it.
  struct Signatures {
    std::vector<Signature> all;
    std::vector<Candidate> starts;  // the candidate at the size of each signature
    std::string failure;
  };
  Signatures signatures_of(const Candidate& candidate, const std::vector<Candidate>& present,
                           const BaseFit& fit, files::Progress& progress) const;

  /// Ways in which the unmodelled smooth error may act, in `fit` of the model without anything
  /// added.
  FreeFormWays free_form_ways(const BaseFit& fit, files::Progress& progress) const;

  /// Rms error, in units of the noise, of other readings of the campaign, predicted by such a fit
  /// that did not use them; NaN where the model has no equilibrium for one.
  double error_on(const Campaign& others, const BaseFit& fit, const std::vector<Candidate>& added,
                  files::Progress& progress) const;

  /// Predictor of the robot as its file has it.
  const Predictor& predictor() const { return predictor_; }
  const Campaign& campaign() const { return campaign_; }
  bool has_gravity() const { return !robot_.manipulator.gravity().isZero(0); }
  const Noise& noise() const { return noise_; }
  /// Uncertain parameters that stay at their nominal values, because these readings do not
  /// determine them, in sentences.
  const std::vector<std::string>& kept_nominal() const { return kept_; }

 private:
  Eigen::MatrixXd by_force(const BaseFit& fit, files::Progress& progress) const;
  std::vector<FreeFormWays::Drive> drives(const BaseFit& fit, files::Progress& progress) const;
  std::vector<Parameter> parameters(const std::vector<vjm::Effect>& effects,
                                    const std::vector<Candidate>& added) const;
  BaseFit fitted(const std::vector<vjm::Effect>& effects, const std::vector<Parameter>& unknowns,
                 const BaseFit* near, files::Progress& progress) const;
  Signatures computed_signatures(const Candidate& candidate, const std::vector<Candidate>& present,
                                 const BaseFit& fit, files::Progress& progress) const;
  // Signature of the last candidate at its current values, which are `growth` times usual. nullopt
  // if the model has no equilibrium.
  std::optional<Signature> signature_of(const Predictor& predictor,
                                        const std::vector<Candidate>& added, double growth,
                                        const BaseFit& fit, files::Progress& progress) const;
  // Adds the signatures of one design, in the place of the last candidate.
  void add_signatures(const Predictor& predictor, const Candidate& candidate,
                      std::vector<Candidate> added, const BaseFit& fit, Signatures& signatures,
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

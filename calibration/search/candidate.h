// What could be missing from a model.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "kinetostat/calibration/regression/base_fit.h"
#include "kinetostat/calibration/regression/evidence.h"
#include "kinetostat/calibration/statistics/residual_space.h"

namespace kinetostat::calibration {

/// An effect of the catalogue (or of the user) at a place where the robot has none of its kind yet.
struct Candidate {
  /// Usual values: one prior standard deviation from where there is no effect, within the physical
  /// range, for values that say how large it is and those that must be given; the others where
  /// there is none.
  vjm::Effect effect;
  std::vector<double> deviations;  // prior standard deviations of its values [SI]
  /// In how many ways values that design fixes may be fixed, without the few variants of one law.
  std::size_t designs = 1;
  std::vector<Eigen::Index> fixed = {};  // values of design that these readings leave at nothing
  double widest = widest_prior;          // times usual: how wide the priors of its size enter a fit

  std::string name() const;  // "clearance at x.rho"
};
std::vector<std::string> names_of(const std::vector<Candidate>& candidates);

/// All of them, in the order of the catalogue, then of the places. `kinds`: of these kinds only;
/// empty: all. A place that stands for several (a joint of each chain) is a candidate beside them.
/// `scales`: what the readings do to each joint, which usual sizes are counted in. What balances
/// weight is looked for only at drives that the readings move.
std::vector<Candidate> candidates(const vjm::Robot& robot, const std::vector<std::string>& kinds,
                                  const vjm::ReadingScales& scales = {});

/// A kind of effect that the robot has no place for, and why.
struct KindWithoutPlace {
  std::string name, reason;
};
/// Of the kinds that candidates() tries; those that the robot has already do not count.
std::vector<KindWithoutPlace> kinds_without_place(const vjm::Robot& robot,
                                                  const std::vector<std::string>& kinds,
                                                  const vjm::ReadingScales& scales = {});

/// Those of the robot, then the added ones.
std::vector<vjm::Effect> effects_with(const vjm::Robot& robot, const std::vector<Candidate>& added);

/// Of an effect that was added to a model.
struct FittedValues {
  Eigen::VectorXd values, deviations;  // NaN where a bound holds a value
};
/// Of each of the added effects: their values are the last parameters of the fit.
std::vector<FittedValues> fitted_values(const BaseFit& fit, const std::vector<Candidate>& added);

/// Whether a value says how large the effect is: the leading one; of effects on numbers that are
/// read one an axis, since nobody knows which are.
bool is_size(const vjm::EffectKind& kind, std::size_t value);

/// max over k of |x_k - none_k| / s_k: how many times its usual size an effect with these values
/// has.
double times_usual(const Candidate& candidate, const Eigen::VectorXd& values);

/// Whether a value cannot lie below where there is no effect.
bool can_only_grow(const vjm::EffectParameter& parameter);

/// The candidate with its leading value (all that say how large it is) at `leading` times its usual
/// distance from nothing, and what else must be given at `others` times.
Candidate at_size(const Candidate& candidate, double leading, double others);

/// As at_size() takes them.
struct TriedSize {
  double leading, others;
};
/// Sizes at which the shape of a signature is looked at, each list from large to small by
/// fifths: gaps, breakaway forces and corners show another shape when they are small beside what
/// the readings do to them.
using TriedSizes = std::vector<TriedSize>;
std::vector<TriedSizes> sizes_of(const vjm::EffectKind& kind);

/// Whether its law is one order of a series.
bool is_of_series(const vjm::EffectKind& kind);
/// Whether several of a kind may act at one place: offsets of other readings, orders of a series.
bool may_act_again(const vjm::EffectKind& kind);

/// The candidate with each of the values that design may have fixed, but for the orders of those
/// of its kind that act at its place already, and for what becomes of weight where nothing weighs.
std::vector<Candidate> designs_of(const Candidate& candidate, const vjm::Manipulator& bare,
                                  const std::vector<vjm::Effect>& present = {});

/// Signatures of one candidate, of its usual size and of others where its shape depends on that.
struct CandidateSignatures {
  std::vector<Signature> all;
  std::vector<Candidate> starts;  // the candidate at the size of each signature
  std::string failure;            // why there are none

  /// Drops those of which every column points as one of an earlier signature does.
  void drop_repetitions();
};

}  // namespace kinetostat::calibration

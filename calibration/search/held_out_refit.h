// How well a model predicts readings that it was not fitted to, by fitting it anew without them.
#pragma once

#include <optional>
#include <vector>

#include "kinetostat/calibration/regression/held_out.h"
#include "kinetostat/calibration/search/candidate_fitter.h"
#include "kinetostat/calibration/search/diagnosis_step.h"

namespace kinetostat::calibration {

/// held_out() takes one Gauss-Newton step from the fit of all readings. That is far off where the
/// values of an effect are known by few readings and the model is not linear in them, as with
/// friction: then this fits anew, without a part of the groups at a time. Keeps references.
class HeldOutRefit {
 public:
  HeldOutRefit(const vjm::Robot& robot, const CandidateFitter& fitter, const HeldOutGroups& groups,
               int threads)
      : robot_(robot), fitter_(fitter), groups_(groups), threads_(threads) {}

  /// Measured minus predicted, whitened, one a value; none where the model has no fit without some
  /// readings, or there are fewer than two groups. `fit`: of all readings, with `added`.
  std::optional<Eigen::VectorXd> error(const std::vector<Candidate>& added, const BaseFit& fit,
                                       common::Progress& progress) const;

  /// Takes the gain of the held-out log score over the errors of the model `without`, and its
  /// standard error, for noise alone.
  void score(const Eigen::VectorXd& without, const Eigen::VectorXd& with, CandidateFit& fit) const;

 private:
  std::vector<std::vector<Eigen::Index>> parts() const;

  const vjm::Robot& robot_;
  const CandidateFitter& fitter_;
  const HeldOutGroups& groups_;
  int threads_;
};

}  // namespace kinetostat::calibration

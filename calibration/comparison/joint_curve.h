// Load on one joint against its deflection: measured, and by two models. What backlash, friction
// and stiffening look like.
#pragma once

#include <optional>
#include <vector>

#include "kinetostat/calibration/comparison/compare.h"

namespace kinetostat::calibration {

/// One reading as the joint sees it. Loads and deflections are counted as the campaign counts
/// displacements: from the state without load, or from the command.
struct JointCurvePoint {
  std::size_t reading = 0;
  double load = 0;       // that its spring transmits [N or N m]
  double measured = 0;   // deflection [m or rad]
  double without = 0;    // of the first model
  double with = 0;       // of the second
  double spring = 0;     // what the joint's spring of the second model alone makes of the load
  double deviation = 0;  // standard deviation of `measured` by the noise of the reading
};

/// Let d be the deflection of the joint in the first model, e in the second, K and L the stiffness
/// of its spring there, and J = du/dd how the reading follows it, from the exact derivative by the
/// logarithm of K in the first model:
///
///     du/d ln K = -J d      load = K d      spring = K d / L
///     measured = e + (J' W r) / (J' W J)
///
/// r is the residual of the second model, W the inverse covariance of the noise (its diagonal):
/// what is left is taken to be of this joint alone, as a partial-residual plot takes it to be of
/// one variable (Larsen and McCleary 1972). J is that of the largest deflection in each posture.
///
/// `without` is an assessment by `first` and `with` one of the same campaign by `second`, which is
/// the same manipulator with effects. nullopt where the joint has no spring of its own, has an
/// effect in the first model, or does not deflect. Readings on which the joint hardly acts (a
/// deviation above three times the median) are left out.
std::optional<std::vector<JointCurvePoint>> joint_curve(
    const vjm::Robot& first, const vjm::Robot& second, const Campaign& campaign, const Noise& noise,
    const Assessment& without, const Assessment& with, const vjm::EffectSite& joint, int threads,
    common::Progress& progress);

}  // namespace kinetostat::calibration

// What readings do to each joint of the model, and what they can tell.
#pragma once

#include "kinetostat/calibration/regression/base_fit.h"

namespace kinetostat::calibration {

/// Whether each joint is moved between readings, and how far the nominal model has each joint
/// deflected and loaded by the changing part of the loads: within a configuration, or from its
/// command where there is but one load. A joint that is loaded a thousand times less than another
/// of its sort counts as if it were a thousandth of that. What slides and what turns have scales of
/// their own; a sort without any spring that is loaded has the usual scale. Where the nominal model
/// has no equilibrium for some reading, all have that. The largest change that is read is that
/// within a configuration, of poses also from what the fit predicts.
/// `bare`: the manipulator of `nominal` without its effects; `campaign`: that of `nominal`; `fit`:
/// of what is uncertain to it.
vjm::ReadingScales joint_scales(const Predictor& nominal, const vjm::Manipulator& bare,
                                const Campaign& campaign, const Noise& noise, const BaseFit& fit,
                                common::Progress& progress);

}  // namespace kinetostat::calibration

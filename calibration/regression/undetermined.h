// Parameters that were declared uncertain, but are not identifiable from the readings at hand.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kinetostat/calibration/campaign/noise.h"
#include "kinetostat/calibration/regression/base_fit.h"
#include "kinetostat/calibration/regression/predict.h"
#include "kinetostat/common/error.h"

namespace kinetostat::calibration {

/// A stiffness this many times its nominal value, or less than one in so many, is hardly what was
/// built: units, or something that the model lacks.
inline constexpr double doubtful_factor = 3;

/// Fixes at its start each parameter that no reading depends on, or that is confounded with those
/// before it: to within the noise, where that is known, else to within rounding. Predictions are
/// the same without it. Returns which, in sentences. A model without an equilibrium for some
/// reading keeps them all free.
std::vector<std::string> keep_undetermined(const Predictor& predictor, const Campaign& campaign,
                                           const Noise& noise, std::vector<Parameter>& parameters,
                                           common::Progress& progress);

/// Adds to each stiffness that is fitted that design tells it to a factor of e, one standard
/// deviation; returns whether there is any. Where no bounds are stated it may go to three of them,
/// for the effect that sets it right.
bool believe_design(std::vector<Parameter>& parameters);

/// Whether some stiffness of the fit is believed so.
bool is_held_near_design(const BaseFit& fit);

/// What a reader should know of how the values of a fit came about, in sentences: design that is
/// believed, an iteration that has not come to rest.
std::vector<std::string> cautions_about(const BaseFit& fit);

/// Sentence about stiffnesses that all come out the same number of times their nominal values:
/// loads or displacements in other units, rather than springs. Empty where they do not, or are
/// hardly off.
std::string common_factor(const std::vector<ParameterEstimate>& parameters);

/// Whether some stiffness without stated bounds is fitted to more than three times its nominal
/// value, or less than a third, by readings that know it less well than design does, or one with
/// stated bounds to one of these: readings that know it poorly would put there what they say of the
/// others.
bool strays_from_design(const BaseFit& fit);

/// The fit of parameters by `fit(parameters)`, once more with what design tells where the readings
/// alone drive a stiffness to zero or infinity (common::NotIdentifiable), or astray, or never to
/// rest. `may_believe`:
/// whether nothing speaks against it, asked only then.
template <class Fit, class MayBelieve>
BaseFit fit_near_design(std::vector<Parameter> parameters, const Fit& fit,
                        const MayBelieve& may_believe) {
  std::optional<BaseFit> alone;
  try {
    alone = fit(parameters);
  } catch (const common::NotIdentifiable&) {
    if (!may_believe() || !believe_design(parameters)) throw;
    return fit(parameters);
  } catch (const common::NoConvergence&) {
    if (!may_believe() || !believe_design(parameters)) throw;
    return fit(parameters);
  }
  const bool stands = alone->is_settled && !strays_from_design(*alone);
  if (stands || !may_believe() || !believe_design(parameters)) return *std::move(alone);
  try {
    return fit(parameters);
  } catch (const common::NotIdentifiable&) {
  } catch (const common::NoConvergence&) {
  }
  return *std::move(alone);
}

}  // namespace kinetostat::calibration

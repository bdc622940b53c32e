// Values of effects that design fixes.
#pragma once

#include <vector>

#include "kinetostat/vjm/effects/effect.h"

namespace kinetostat::calibration {

/// What design fixes about a value of an effect; empty when readings must tell it.
inline const std::vector<double>& usual_values(const vjm::Effect& effect, Eigen::Index value,
                                               const vjm::Manipulator& bare) {
  const vjm::EffectParameter& p = effect.kind->parameters[static_cast<std::size_t>(value)];
  return vjm::turns(effect, bare) ? p.usual_angular : p.usual_linear;
}

}  // namespace kinetostat::calibration

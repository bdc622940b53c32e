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

/// The values of an effect that columns of a signature are of: its size first, then what readings
/// must tell.
inline std::vector<Eigen::Index> values_of_columns(const vjm::Effect& effect,
                                                   const vjm::Manipulator& bare) {
  std::vector<Eigen::Index> values;
  for (Eigen::Index k = 0; k < effect.values.size(); ++k)
    if (k == 0 || usual_values(effect, k, bare).empty()) values.push_back(k);
  return values;
}

}  // namespace kinetostat::calibration

#include "kinetostat/vjm/chain/coordinate_law.h"

#include <cmath>
#include <stdexcept>

namespace kinetostat::vjm {

StopLaw::StopLaw(double lower, double upper, double stiffness)
    : lower_(lower), upper_(upper), stiffness_(stiffness) {
  if (!(lower < upper)) throw std::invalid_argument("the lower stop must be below the upper one");
  if (!(stiffness > 0)) throw std::invalid_argument("the stiffness of a stop must be positive");
}

double StopLaw::beyond(double x) const {
  return x > upper_ ? x - upper_ : x < lower_ ? x - lower_ : 0.0;
}

CoordinateLaw::Value StopLaw::at(const JointState& joint) const {
  const double x = beyond(joint.position);
  return {.force = stiffness_ * x, .tangent = x != 0 ? stiffness_ : 0};
}

double StopLaw::energy(const JointState& joint) const {
  const double x = beyond(joint.position);
  return 0.5 * stiffness_ * x * x;
}

double StopLaw::middle() const {
  if (std::isinf(lower_)) return std::isinf(upper_) ? 0 : upper_;
  return std::isinf(upper_) ? lower_ : (lower_ + upper_) / 2;
}

}  // namespace kinetostat::vjm

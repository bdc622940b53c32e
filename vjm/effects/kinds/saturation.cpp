// The saturation with which friction and play pass from sticking into slipping.
#include <algorithm>
#include <cmath>

#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {

Saturation::Saturation(double u) {
  constexpr double w = rounding;
  const double size = std::abs(u), t = std::clamp((size - (1 - w)) / (2 * w), 0.0, 1.0);
  const double inside = std::min(size, 1 + w);
  const double lost = 2 * w * t * t * t * (1 - t / 2);
  value = std::copysign(inside - lost, u);
  slope = 1 - t * t * (3 - 2 * t);
  const double bent = inside * inside / 2 - 4 * w * w * (std::pow(t, 4) / 4 - std::pow(t, 5) / 10);
  const double outside = size - inside;  // where it slips, and s = 1
  integral = bent + outside;
  const double bent_twice =
      std::pow(inside, 3) / 6 - 8 * w * w * w * (std::pow(t, 5) / 20 - std::pow(t, 6) / 60);
  second_integral = std::copysign(bent_twice + outside * bent + outside * outside / 2, u);
}

}  // namespace kinetostat::vjm::effects

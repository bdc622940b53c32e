// The saturation with which friction and play pass from sticking into slipping.
#include <algorithm>
#include <cmath>

#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {

namespace {

constexpr double w = Saturation::rounding;

}  // namespace

Saturation::Saturation(double at)
    : u(at),
      t(std::clamp((std::abs(u) - (1 - w)) / (2 * w), 0.0, 1.0)),
      inside(std::min(std::abs(u), 1 + w)),
      outside(std::abs(u) - inside) {
  const double lost = 2 * w * t * t * t * (1 - t / 2);
  value = std::copysign(inside - lost, u);
  slope = 1 - t * t * (3 - 2 * t);
}

double Saturation::bent() const {
  return inside * inside / 2 - 4 * w * w * (std::pow(t, 4) / 4 - std::pow(t, 5) / 10);
}

double Saturation::integral() const { return bent() + outside; }

double Saturation::second_integral() const {
  const double bent_twice =
      std::pow(inside, 3) / 6 - 8 * w * w * w * (std::pow(t, 5) / 20 - std::pow(t, 6) / 60);
  return std::copysign(bent_twice + outside * bent() + outside * outside / 2, u);
}

}  // namespace kinetostat::vjm::effects

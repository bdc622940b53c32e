// The dead zone that clearances and transmissions of piecewise stiffness are made of.
#include <cmath>

#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {

namespace {

double hypotenuse(double a, double b) { return std::sqrt(a * a + b * b); }

}  // namespace

DeadZone::DeadZone(double deflection, double half_width, double corner)
    : d(deflection), gap(half_width), width(corner) {
  if (gap == 0) {
    value = d;
    slope = 1;
    by_gap = d > 0 ? -1 : d < 0 ? 1 : 0;  // of the gap that opens
    return;
  }
  above = hypotenuse(d - gap, width);
  below = hypotenuse(d + gap, width);
  value = d + (above - below) / 2;
  slope = 1 + ((d - gap) / above - (d + gap) / below) / 2;
  by_gap = -((d - gap) / above + (d + gap) / below) / 2;
  by_width = width * (1 / above - 1 / below) / 2;
}

double DeadZone::integral() const {
  if (gap == 0) return d * d / 2;
  const auto primitive = [this](double u, double r) {
    return (u * r + width * width * std::asinh(u / width)) / 2;
  };
  const double zero = primitive(gap, hypotenuse(gap, width));
  return d * d / 2 + (primitive(d - gap, above) + zero - primitive(d + gap, below) + zero) / 2;
}

}  // namespace kinetostat::vjm::effects

// The temperatures of a day of measuring.
#pragma once

#include <cmath>
#include <numbers>

#include "hidden_effect.h"
#include "random.h"

namespace twin {

/// Air over a day, and links that follow it with a time constant of half an hour.
class Day {
 public:
  explicit Day(Random& random) : rise_(random.uniform(3, 6)), phase_(random.uniform(-0.5, 0.5)) {}
  /// Gives a row its temperatures; rows come in the order of their times.
  void tell(Row& row) {
    const double air = 20 + rise_ * std::sin(2 * std::numbers::pi * row.time / 28800 + phase_);
    link_ = seconds_ < 0 ? air : air + (link_ - air) * std::exp(-(row.time - seconds_) / 1800);
    seconds_ = row.time;
    row.temperature = std::round(air * 100) / 100;
    row.link_temperature = link_;
  }

 private:
  double rise_, phase_, link_ = 20, seconds_ = -1;
};

}  // namespace twin

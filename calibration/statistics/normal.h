// Standard normal numbers, the same on every platform, which std::normal_distribution is not.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace kinetostat::calibration {

class Normal {
 public:
  explicit Normal(std::uint64_t seed) : engine_(seed) {}

  double operator()() {
    const double radius = std::sqrt(-2 * std::log(uniform()));
    return radius * std::cos(2 * std::numbers::pi * uniform());
  }

 private:
  // In (0, 1]: 53 random bits.
  double uniform() { return static_cast<double>((engine_() >> 11) + 1) * 0x1p-53; }

  std::mt19937_64 engine_;
};

}  // namespace kinetostat::calibration

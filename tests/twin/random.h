// The twin's own random numbers: SplitMix64 (Steele, Lea and Flood, OOPSLA 2014), and normal
// numbers by Box and Muller. The same on every machine, unlike the distributions of the standard
// library.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "so3.h"

namespace twin {

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed * 0x2545F4914F6CDD1DULL + 1) {}

  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ULL);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }
  /// In (0, 1).
  double uniform() { return (static_cast<double>(bits() >> 11) + 0.5) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  double normal() {
    const double radius = std::sqrt(-2 * std::log(uniform()));
    return radius * std::cos(2 * std::numbers::pi * uniform());
  }
  Vector3 normal3() {
    const double x = normal(), y = normal();
    return {x, y, normal()};
  }
  Vector3 direction() { return normal3().normalized(); }
  int below(int n) { return static_cast<int>(bits() % static_cast<std::uint64_t>(n)); }
  double sign() { return uniform() < 0.5 ? -1 : 1; }

 private:
  std::uint64_t state_;
};

}  // namespace twin

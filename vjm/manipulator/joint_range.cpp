#include "kinetostat/vjm/manipulator/joint_range.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace kinetostat::vjm {
namespace {

bool is_within(const Coordinate& coordinate, double value) {
  const auto [least, largest] = *coordinate.range;
  constexpr double turn = 2 * std::numbers::pi;
  const double rounding = 1e-9 * (1 + std::abs(least) + std::abs(largest));
  if (is_rotation(coordinate.motion) && value < least - rounding)
    value += turn * std::ceil((least - rounding - value) / turn);
  else if (is_rotation(coordinate.motion) && value > largest + rounding)
    value -= turn * std::ceil((value - largest - rounding) / turn);
  return value >= least - rounding && value <= largest + rounding;
}

}  // namespace

std::string beyond_range(const Manipulator& manipulator, const Posture& posture) {
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const Chain& chain = manipulator.chains()[c];
    for (std::size_t k = 0; k < chain.coordinates().size(); ++k) {
      const Coordinate& coordinate = chain.coordinates()[k];
      if (!coordinate.range) continue;
      const double value = posture.coordinates[c][static_cast<Eigen::Index>(k)];
      if (is_within(coordinate, value)) continue;
      const bool turns = is_rotation(coordinate.motion);
      const double shown = turns ? 180 / std::numbers::pi : 1000;
      return fmt::format("{}.{} would stand at {:.6g} {}, beyond its range of {:.6g} to {:.6g}",
                         chain.name(), coordinate.name, shown * value, turns ? "deg" : "mm",
                         shown * (*coordinate.range)[0], shown * (*coordinate.range)[1]);
    }
  }
  return {};
}

}  // namespace kinetostat::vjm

#include "kinetostat/vjm/machine_elements/ball_screw.h"

#include <stdexcept>

#include <fmt/format.h>

namespace kinetostat::vjm {

double axial_stiffness(const BallScrew& screw, double place) {
  if (!(place >= 0 && place <= screw.length))
    throw std::invalid_argument(
        fmt::format("{:.6g} m is not on a shaft of {:.6g} m", place, screw.length));
  const double per_length = screw.shaft_area * screw.young_modulus;
  double ends = 1 / (place / per_length + 1 / screw.bearing);
  if (screw.other_bearing > 0)
    ends += 1 / ((screw.length - place) / per_length + 1 / screw.other_bearing);
  return 1 / (1 / screw.nut + 1 / ends);
}

}  // namespace kinetostat::vjm

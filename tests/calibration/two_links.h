// Two joints one after the other, pushed in their plane.
#pragma once

#include "calibration/laboratory.h"

namespace kinetostat::calibration::test {

/// Of a robot that turns about one axis in both joints; `more` are further lines of its file.
inline std::string two_links(const std::string& axis, const std::string& more = "") {
  return "kinetostat: 1\nname: two links\nunits: {length: mm, force: N, angle: rad}\n" + more +
         "chain_types:\n  arm:\n"
         "    - actuator: {name: q1, axis: " +
         axis +
         ", stiffness: 8.0e4 N m/rad}\n"
         "    - tool: [500, 0, 0]\n"
         "    - actuator: {name: q2, axis: " +
         axis +
         ", stiffness: 3.0e4 N m/rad}\n"
         "    - tool: [400, 0, 0]\n"
         "manipulator: {chain: arm}\nuncertain:\n  - {stiffness: q1}\n  - {stiffness: q2}\n";
}

class TwoLinks : public Laboratory {
 public:
  explicit TwoLinks(unsigned seed) : Laboratory(two_links("Rz")) {
    options().components = {true, true, false, false, false, false};
    options().translation_noise = 2e-6;
    options().seed = seed;
  }
};

/// The same, upright: both joints lift.
class TwoLinksThatLift : public Laboratory {
 public:
  TwoLinksThatLift(unsigned seed, double noise)
      : Laboratory(two_links("Ry", "gravity: {direction: [0, 0, -1]}\n")) {
    options().components = {true, false, true, false, false, false};
    options().translation_noise = noise;
    options().seed = seed;
  }
};

}  // namespace kinetostat::calibration::test

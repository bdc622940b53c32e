// Two joints one after the other, pushed in their plane.
#pragma once

#include "calibration/laboratory.h"

namespace kinetostat::calibration::test {

class TwoLinks : public Laboratory {
 public:
  explicit TwoLinks(unsigned seed)
      : Laboratory(
            "kinetostat: 1\nname: two links\nunits: {length: mm, force: N, angle: rad}\n"
            "chain_types:\n  arm:\n"
            "    - actuator: {name: q1, axis: Rz, stiffness: 8.0e4 N m/rad}\n"
            "    - tool: [500, 0, 0]\n"
            "    - actuator: {name: q2, axis: Rz, stiffness: 3.0e4 N m/rad}\n"
            "    - tool: [400, 0, 0]\n"
            "manipulator: {chain: arm}\nuncertain:\n  - {stiffness: q1}\n  - {stiffness: q2}\n") {
    options().components = {true, true, false, false, false, false};
    options().translation_noise = 2e-6;
    options().seed = seed;
  }
};

}  // namespace kinetostat::calibration::test

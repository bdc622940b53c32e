// Effects that hide one another, on a robot of a few lines.
#pragma once

#include <string>

#include <fmt/format.h>

namespace kinetostat::test {

/// Two arms in a plane, of which only the height is read: a torque in the one drive lifts the tool
/// nearly as one in the other does.
inline const std::string two_arms =
    "kinetostat: 1\nname: two arms\nunits: {length: mm, force: N, angle: deg}\n"
    "chain_types:\n  arm:\n"
    "    - actuator: {name: q1, axis: Ry, stiffness: 4.0e4 N m/rad}\n"
    "    - tool: [400, 0, 0]\n"
    "    - actuator: {name: q2, axis: Ry, stiffness: 2.0e4 N m/rad, home: 0}\n"
    "    - tool: [300, 0, 0]\n"
    "manipulator: {chain: arm}\nuncertain:\n  - {stiffness: q1}\n  - {stiffness: q2}\n";

/// Torques that nearly cancel.
inline const char* const torque_1 = "-1.45 N m";
inline const char* const torque_2 = "1.8 N m";

/// Loads up and down at many postures: a plan.
inline std::string lifts() {
  std::string csv = "id,session,cycle,step,time,q1,q2,fz\n";
  for (int i = 0; i < 80; ++i)
    csv += fmt::format("a{0},first,c{0},1,{1},{2},{3},{4}\n", i, 60 * i, -35 + 7 * ((i * 3) % 11),
                       -50 + 100 * ((i * 7) % 20) / 19.0,
                       i % 4 == 0   ? 60
                       : i % 4 == 2 ? -60
                                    : 0);
  return csv;
}

}  // namespace kinetostat::test

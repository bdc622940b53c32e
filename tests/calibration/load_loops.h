// Load cycles along z.
#pragma once

#include <string>

#include <fmt/format.h>

namespace kinetostat::calibration::test {

/// Up and down and reversed, one reading every 30 to 40 s.
inline std::string loops(int runs = 3) {
  std::string csv = "id,cycle,step,time,fz\n";
  int n = 0, time = 0;
  for (int run = 1; run <= runs; ++run)
    for (const int load : {0, 300, 600, 900, 600, 300, 0, -300, -600, -900, -600, -300, 0}) {
      time += 30 + 7 * n % 11;
      csv += fmt::format("a{0},{1},{0},{2},{3}\n", ++n, run, time, load);
    }
  return csv;
}

}  // namespace kinetostat::calibration::test

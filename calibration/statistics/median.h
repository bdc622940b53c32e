// The middle of numbers that stand in no order.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace kinetostat::calibration {

/// The upper one of the two in the middle where there are as many on either side. Requires a value.
inline double upper_median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace kinetostat::calibration

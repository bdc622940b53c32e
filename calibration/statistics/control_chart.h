// Control charts of single values.
#pragma once

#include <cstddef>
#include <vector>

namespace kinetostat::calibration {

/// Between the limits lie all but 0.27 % of values that vary by chance alone, if these are normal
/// and independent of each other.
struct ControlChart {
  double mean = 0, mean_moving_range = 0;
  double lower = 0, upper = 0;
  std::vector<std::size_t> outside = {};  // numbers of values

  /// What varies by chance alone: the mean moving range over 1.128.
  double deviation() const { return mean_moving_range / 1.128; }
};

/// Individuals chart of values in their order: mean +- 2.66 mean moving range, the mean of
/// |x_i - x_{i-1}|; 2.66 = 3 / d2, d2 = 1.128 of two values (ISO 7870-2:2013, 6.3; Montgomery,
/// Introduction to Statistical Quality Control, 6.4). The limits are of the first `baseline`
/// values; of all where it is 0 or more than there are. Throws std::invalid_argument for less than
/// two of them.
ControlChart individuals_chart(const std::vector<double>& values, std::size_t baseline = 0);

}  // namespace kinetostat::calibration

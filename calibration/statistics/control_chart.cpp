#include "kinetostat/calibration/statistics/control_chart.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace kinetostat::calibration {

ControlChart individuals_chart(const std::vector<double>& values, std::size_t baseline) {
  const std::size_t count = baseline == 0 ? values.size() : std::min(baseline, values.size());
  if (count < 2) throw std::invalid_argument("a control chart needs two values");
  ControlChart chart;
  const auto n = static_cast<double>(count);
  const auto end = values.begin() + static_cast<std::ptrdiff_t>(count);
  chart.mean = std::accumulate(values.begin(), end, 0.0) / n;
  for (std::size_t i = 1; i < count; ++i)
    chart.mean_moving_range += std::abs(values[i] - values[i - 1]) / (n - 1);
  chart.lower = chart.mean - 2.66 * chart.mean_moving_range;
  chart.upper = chart.mean + 2.66 * chart.mean_moving_range;
  // Equal values have no range, and their mean differs from them by rounding.
  constexpr double rounding = 1e-9;
  const double slack = rounding * std::abs(chart.mean);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] < chart.lower - slack || values[i] > chart.upper + slack)
      chart.outside.push_back(i);
  return chart;
}

}  // namespace kinetostat::calibration

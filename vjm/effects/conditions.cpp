#include "kinetostat/vjm/effects/conditions.h"

#include <algorithm>
#include <cmath>

namespace kinetostat::vjm {
namespace {

// Where the past starts that a part with that lag still knows, to rounding.
std::size_t start_of(const TemperaturePast& past, double lag) {
  constexpr double remembered = 40;  // times the lag: exp(-40) is below rounding
  const auto begin = past.of_session->begin(), last = begin + std::ptrdiff_t(past.count) - 1;
  const auto known =
      std::upper_bound(begin, last, last->time - remembered * lag,
                       [](double time, const TemperatureAt& at) { return time < at.time; });
  return static_cast<std::size_t>(std::max<std::ptrdiff_t>(1, known - begin));
}

}  // namespace

// Along a straight piece of slope s and length h, with E = exp(-h/lag),
//   T' - T = -s lag + (T'0 - T0 + s lag) E.
TemperatureLag temperature_lag(const TemperaturePast& past, double lag) {
  TemperatureLag result;
  if (past.count < 2) return result;
  for (std::size_t i = start_of(past, lag); i < past.count; ++i) {
    const TemperatureAt &from = (*past.of_session)[i - 1], &to = (*past.of_session)[i];
    const double h = to.time - from.time, rise = to.temperature - from.temperature;
    if (!(h > 0)) {
      result.behind -= rise;
      continue;
    }
    const double slope = rise / h;
    const double e = lag > 0 ? std::exp(-h / lag) : 0;
    const double e_by_lag = lag > 0 ? e * h / (lag * lag) : 0;
    const double apart = result.behind + slope * lag;
    result.by_lag = -slope + (result.by_lag + slope) * e + apart * e_by_lag;
    result.behind = -slope * lag + apart * e;
  }
  return result;
}

}  // namespace kinetostat::vjm

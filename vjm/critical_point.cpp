#include "kinetostat/vjm/critical_point.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <boost/math/tools/toms748_solve.hpp>

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

struct NoStation : std::runtime_error {
  NoStation() : std::runtime_error("no equilibrium here") {}
};

struct Located {
  double share = 0;  // of the step
  Station station;
  double width = 0;  // of the last bracket
  double jump = 0;   // of the function over it
};

// Zero of a function of the station that differs in sign at the two ends.
template <class Function>
Located locate(Continuation& continuation, const Station& from, const Station& to,
               const Function& function) {
  const auto station_at = [&](double share) {
    std::optional<Station> station = continuation.between(from, to, share);
    if (!station) throw NoStation();
    return *station;
  };
  std::uintmax_t iterations = 100;
  const auto [low, high] = boost::math::tools::toms748_solve(
      [&](double share) { return function(station_at(share)); }, 0.0, 1.0, function(from),
      function(to), boost::math::tools::eps_tolerance<double>(46), iterations);
  const double share = 0.5 * (low + high);
  return {share, station_at(share), high - low,
          low < high ? std::abs(function(station_at(high)) - function(station_at(low))) : 0.0};
}

int negative(const VectorXd& values) { return static_cast<int>((values.array() < 0).count()); }

// Indices of the eigenvalues that are smallest against their resolution.
std::vector<Index> vanishing(const EnergySpectrum& spectrum, int neutral, int count) {
  std::vector<Index> order = spectrum.by_size();
  // Where a motion costs nothing all along, it is among the smallest: the value does not say which
  // one is which, and all of them are offered as directions.
  order.resize(std::min(order.size(), static_cast<std::size_t>(neutral + count)));
  return order;
}

CriticalKind kind_of(const Station& from, const Station& to, const Located& at,
                     double size_of_function) {
  if (at.jump > 1e-3 * size_of_function) return CriticalKind::contact;
  constexpr double level = 1e-9;  // below, the parameter does not move at all
  const double before = from.parameter_rate(), after = to.parameter_rate();
  const bool turns = before * after < 0 && std::min(std::abs(before), std::abs(after)) > level;
  return turns ? CriticalKind::limit_point : CriticalKind::bifurcation;
}

// Where a small imperfection opens a bifurcation, no path leads through it and the equations have
// no solution nearby: as close as one comes from both sides.
template <class Function>
Located approach(Continuation& continuation, const Station& from, const Station& to,
                 const Function& function) {
  double low = 0, high = 1;
  Station nearest = from;
  const bool sign = function(from) > 0;
  for (bool narrowed = true; narrowed && high - low > 1e-12;) {
    narrowed = false;
    for (const double place : {0.5, 0.35, 0.65, 0.2, 0.8, 0.1, 0.9}) {
      const double share = low + place * (high - low);
      const std::optional<Station> station = continuation.between(from, to, share);
      if (!station) continue;
      narrowed = true;
      if ((function(*station) > 0) == sign) {
        low = share;
        nearest = *station;
      } else {
        high = share;
      }
      break;
    }
  }
  return {low, nearest, high - low, 0};
}

template <class Function>
Located locate_or_approach(Continuation& continuation, const Station& from, const Station& to,
                           const Function& function) {
  try {
    return locate(continuation, from, to, function);
  } catch (const NoStation&) {
    return approach(continuation, from, to, function);
  }
}

// The k-th eigenvalue that is not neutral passes through zero.
CriticalStation crossing(Continuation& continuation, const Station& from, const Station& to,
                         int neutral, Index k) {
  const auto value = [neutral, k](const Station& s) {
    return s.spectrum.without_neutral(neutral)[k];
  };
  const double size = std::abs(value(from)) + std::abs(value(to));
  const Located at = locate_or_approach(continuation, from, to, value);
  CriticalStation critical;
  critical.kind = kind_of(from, to, at, size);
  critical.station = at.station;
  critical.modes = vanishing(at.station.spectrum, neutral, 1);
  // Rounding of the eigenvalue, seen along the path.
  const double rounding = std::numeric_limits<double>::epsilon() *
                          at.station.spectrum.values.cwiseAbs().maxCoeff() / size;
  critical.uncertainty = (at.width + rounding) * std::abs(to.at.parameter - from.at.parameter);
  return critical;
}

// On a branch through the vertex of a pitchfork the eigenvalue touches zero only.
CriticalStation vertex(Continuation& continuation, const Station& from, const Station& to,
                       int neutral) {
  const Located at = locate_or_approach(continuation, from, to,
                                        [](const Station& s) { return s.parameter_rate(); });
  CriticalStation critical;
  critical.station = at.station;
  critical.modes = vanishing(at.station.spectrum, neutral, 1);
  critical.uncertainty = at.width * std::abs(to.at.parameter - from.at.parameter);
  const double least = at.station.spectrum.without_neutral(neutral).cwiseAbs().minCoeff();
  const double nearby = from.spectrum.without_neutral(neutral).cwiseAbs().minCoeff();
  critical.kind = at.jump > 1e-3 ? CriticalKind::contact
                                 : (least < 1e-3 * nearby ? CriticalKind::bifurcation
                                                          : CriticalKind::limit_point);
  return critical;
}

// Several motions may become free at one point, as in a column of square section.
template <class Along>
std::vector<CriticalStation> merged(std::vector<CriticalStation> all, const Along& along,
                                    int neutral) {
  std::vector<CriticalStation> apart;
  for (CriticalStation& c : all) {
    if (!apart.empty() && std::abs(along(c) - along(apart.back())) <= 1e-6 * std::abs(along(c))) {
      CriticalStation& same = apart.back();
      same.unstable_after = c.unstable_after;
      same.modes = vanishing(same.station.spectrum, neutral,
                             std::abs(same.unstable_after - same.unstable_before));
    } else {
      apart.push_back(std::move(c));
    }
  }
  return apart;
}

}  // namespace

std::vector<CriticalStation> critical_between(Continuation& continuation, const Station& from,
                                              const Station& to) {
  std::vector<CriticalStation> found;
  const int neutral = std::min(from.spectrum.neutral(), to.spectrum.neutral());
  const int before = negative(from.spectrum.without_neutral(neutral));
  const int after = negative(to.spectrum.without_neutral(neutral));
  const bool turns = from.parameter_rate() * to.parameter_rate() < 0 &&
                     std::abs(from.parameter_rate()) > 1e-9 && std::abs(to.parameter_rate()) > 1e-9;
  for (int k = std::min(before, after); k < std::max(before, after); ++k)
    found.push_back(crossing(continuation, from, to, neutral, k));
  if (before == after && turns) found.push_back(vertex(continuation, from, to, neutral));
  const auto along = [&](const CriticalStation& c) {
    return from.tangent.dot(continuation.difference(from, c.station));
  };
  std::stable_sort(found.begin(), found.end(),
                   [&](const auto& a, const auto& b) { return along(a) < along(b); });
  int unstable = before;
  const int direction = before == after ? 0 : (after > before ? 1 : -1);
  for (CriticalStation& c : found) {
    c.unstable_before = unstable;
    unstable += direction;
    c.unstable_after = unstable;
  }
  return merged(std::move(found), along, neutral);
}

}  // namespace kinetostat::vjm

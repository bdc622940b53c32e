#include "kinetostat/vjm/continuation/critical_point.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <boost/math/tools/toms748_solve.hpp>

#include "kinetostat/vjm/continuation/branch_point.h"

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

struct NoStation : std::runtime_error {
  NoStation() : std::runtime_error("no equilibrium here") {}
};

// Where a function of the station changes its sign on a step.
struct Located {
  double share = 0;       // of the step
  Station station;        // there
  Station before, after;  // ends of the last bracket
  double width = 0;       // of it, with the rounding of the function
  int change = 0;         // of the number of unstable directions
  bool turn = false;      // the parameter turns back
};

// The signs at the ends are given: there the function may be rounding.
template <class Function>
Located locate(Continuation& continuation, const Station& from, const Station& to,
               const Function& function, double at_from, double at_to) {
  const auto station_at = [&](double share) {
    std::optional<Station> station = continuation.between(from, to, share);
    if (!station) throw NoStation();
    return *station;
  };
  std::uintmax_t iterations = 100;
  const auto [low, high] = boost::math::tools::toms748_solve(
      [&](double share) { return function(station_at(share)); }, 0.0, 1.0, at_from, at_to,
      boost::math::tools::eps_tolerance<double>(46), iterations);
  const double share = 0.5 * (low + high);
  return {share, station_at(share), station_at(low), station_at(high), high - low};
}

// Where a small imperfection opens a bifurcation, no path leads through it and the equations have
// no solution nearby: as close as one comes from both sides.
template <class Function>
Located approach(Continuation& continuation, const Station& from, const Station& to,
                 const Function& function, double at_from) {
  double low = 0, high = 1;
  Station before = from, after = to;
  for (bool narrowed = true; narrowed && high - low > 1e-12;) {
    narrowed = false;
    for (const double place : {0.5, 0.35, 0.65, 0.2, 0.8, 0.1, 0.9}) {
      const double share = low + place * (high - low);
      const std::optional<Station> station = continuation.between(from, to, share);
      if (!station) continue;
      narrowed = true;
      const bool is_before = (function(*station) > 0) == (at_from > 0);
      (is_before ? low : high) = share;
      (is_before ? before : after) = *station;
      break;
    }
  }
  return {low, before, before, after, high - low};
}

template <class Function>
Located locate_or_approach(Continuation& continuation, const Station& from, const Station& to,
                           const Function& function, double at_from, double at_to) {
  try {
    return locate(continuation, from, to, function, at_from, at_to);
  } catch (const NoStation&) {
    return approach(continuation, from, to, function, at_from);
  }
}

int count_negative(const EnergySpectrum& spectrum) {
  int count = 0;
  for (Index i = 0; i < spectrum.values.size(); ++i)
    count += spectrum.values[i] < 0 && !spectrum.is_neutral(i);
  return count;
}

// The k-th eigenvalue beside those that are neutral all along. Where the loops leave fewer motions,
// those that they take away are as good as stiff.
double eigenvalue(const Station& station, int neutral, Index k) {
  const VectorXd values = station.spectrum.without_neutral(neutral);
  return k < values.size() ? values[k] : 1.0;
}

double largest(const VectorXd& values) {
  return values.size() > 0 ? values.cwiseAbs().maxCoeff() : 0;
}

// Where the k-th eigenvalue passes through zero, from below or from above.
Located crossing(Continuation& continuation, const Station& from, const Station& to, int neutral,
                 Index k, bool rises) {
  constexpr double least = std::numeric_limits<double>::min();
  const auto value = [neutral, k](const Station& s) { return eigenvalue(s, neutral, k); };
  // Zero to rounding is not negative.
  const double at_from = rises ? value(from) : std::max(value(from), least);
  const double at_to = rises ? std::max(value(to), least) : value(to);
  Located place = locate_or_approach(continuation, from, to, value, at_from, at_to);
  place.width += std::numeric_limits<double>::epsilon() * largest(place.station.spectrum.values) /
                 std::abs(at_to - at_from);
  place.change = rises ? -1 : 1;
  return place;
}

// Every place where an eigenvalue passes through zero or the parameter turns back.
std::vector<Located> all_places(Continuation& continuation, const Station& from,
                                const Station& to) {
  constexpr double level = 1e-9;  // rate below which the parameter does not move at all
  std::vector<Located> places;
  const int neutral = std::min(from.spectrum.neutral(), to.spectrum.neutral());
  const int before = count_negative(from.spectrum), after = count_negative(to.spectrum);
  for (int k = std::min(before, after); k < std::max(before, after); ++k)
    places.push_back(crossing(continuation, from, to, neutral, k, after < before));
  const double leaves = from.parameter_rate(), arrives = to.parameter_rate();
  if (leaves * arrives < 0 && std::min(std::abs(leaves), std::abs(arrives)) > level) {
    places.push_back(locate_or_approach(
        continuation, from, to, [](const Station& s) { return s.parameter_rate(); }, leaves,
        arrives));
    places.back().turn = true;
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const Located& a, const Located& b) { return a.share < b.share; });
  return places;
}

// Several motions may become free at one point, as in a column of square section; and at a limit
// point an eigenvalue passes through zero where the parameter turns.
std::vector<Located> merged(std::vector<Located> places) {
  std::vector<Located> apart;
  for (Located& place : places) {
    const double resolved = apart.empty() ? 0 : place.width + apart.back().width;
    if (apart.empty() || place.share - apart.back().share > 1e-9 + 1e-6 * place.share + resolved) {
      apart.push_back(std::move(place));
      continue;
    }
    apart.back().change += place.change;
    apart.back().turn |= place.turn;
  }
  return apart;
}

std::optional<Station> station_at(Continuation& continuation, const Station& from,
                                  const Station& to, double share) {
  if (share <= 0) return from;
  return share >= 1 ? to : continuation.between(from, to, share);
}

// Whether a place where the parameter turns is a branch point. There the distance to it falls in
// proportion from both sides, which also tells the place better than the turn does. Nearly so, with
// an imperfection, it stops falling. Short steps keep other branches away from the guesses.
bool move_to_branch_point(Continuation& continuation, Station from, Station to, int idle,
                          Located& place) {
  constexpr double apart = 1e-2;  // of the step, which becomes shorter each time
  double share = place.share;
  for (int level = 0; level < 2; ++level) {
    const auto before = station_at(continuation, from, to, share - apart);
    const auto behind = station_at(continuation, from, to, share + apart);
    if (!before || !behind) return place.width > 1e-6;  // no path leads through
    from = *before;
    to = *behind;
    const double a = distance_to_branch_point(continuation, from, idle);
    const double b = distance_to_branch_point(continuation, to, idle);
    share = a / (a + b);
    const std::optional<Station> at = station_at(continuation, from, to, share);
    if (!at || !(distance_to_branch_point(continuation, *at, idle) < 0.1 * std::min(a, b)))
      return false;
    place.station = *at;
    place.before = from;
  }
  return true;
}

// Whether a law is another one behind a place; one that is smooth changes in proportion to the
// width.
bool is_contact(Continuation& continuation, const Located& place) {
  return continuation.equations().law_differs(place.before.at, place.after.at,
                                              1e-3 + 10 * place.width);
}

// With a moment the tangent is not symmetric, and its symmetric part, which stability goes by, is
// singular a little beside where the parameter turns: one limit point all the same.
std::vector<Located> with_folds_whole(Continuation& continuation, const Station& from,
                                      const Station& to, int idle, std::vector<Located> places) {
  constexpr double close = 0.02;  // of the step
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (!places[k].turn || places[k].change != 0) continue;
    for (const std::size_t other : {k - 1, k + 1}) {
      if (other >= places.size() || places[other].turn ||
          std::abs(places[other].share - places[k].share) > close ||
          is_contact(continuation, places[other]))
        continue;
      Located alone = places[other];
      if (move_to_branch_point(continuation, from, to, idle, alone)) continue;
      places[k].change = places[other].change;
      places.erase(places.begin() + static_cast<std::ptrdiff_t>(other));
      if (other < k) --k;
      break;
    }
  }
  return places;
}

CriticalKind kind_of(Continuation& continuation, const Station& from, const Station& to, int idle,
                     Located& place) {
  if (is_contact(continuation, place)) return CriticalKind::contact;
  if (place.turn && !move_to_branch_point(continuation, from, to, idle, place))
    return CriticalKind::limit_point;
  return CriticalKind::bifurcation;
}

// A station just before or behind a place, whichever is further from another branch point.
Station station_beside(Continuation& continuation, const Station& from, const Station& to, int idle,
                       const Located& place) {
  const double apart = 1e-4 + place.width;
  const Station before = station_at(continuation, from, to, place.share - apart).value_or(from);
  const Station behind = station_at(continuation, from, to, place.share + apart).value_or(to);
  const double a = distance_to_branch_point(continuation, before, idle);
  return distance_to_branch_point(continuation, behind, idle) > 2 * a ? behind : before;
}

}  // namespace

std::vector<CriticalStation> critical_between(Continuation& continuation, const Station& from,
                                              const Station& to) {
  std::vector<Located> places = merged(all_places(continuation, from, to));
  if (places.empty()) return {};
  std::vector<CriticalStation> found;
  const int idle = std::min(idle_directions(continuation, from), idle_directions(continuation, to));
  places = with_folds_whole(continuation, from, to, idle, std::move(places));
  int unstable = count_negative(from.spectrum);
  for (Located& place : places) {
    CriticalStation critical;
    critical.kind = kind_of(continuation, from, to, idle, place);
    critical.beside =
        place.turn ? std::move(place.before) : station_beside(continuation, from, to, idle, place);
    critical.idle = idle;
    critical.multiplicity = std::max(1, std::abs(place.change));
    critical.uncertainty = place.width * std::abs(to.at.parameter - from.at.parameter);
    critical.unstable_before = unstable;
    critical.unstable_after = unstable += place.change;
    critical.station = std::move(place.station);
    found.push_back(std::move(critical));
  }
  return found;
}

}  // namespace kinetostat::vjm

#include "kinetostat/vjm/continuation/path.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include <fmt/format.h>

#include "kinetostat/vjm/continuation/branch_point.h"
#include "kinetostat/vjm/continuation/critical_point.h"

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double slowest = 1e-9;  // rate of what does not move

// A step of a branch that was followed. The path has a tangent at `from`, not always at `to`.
struct Segment {
  std::size_t branch;
  Station from;
  PathState to;
};

class Tracer {
 public:
  Tracer(const Manipulator& manipulator, const Posture& posture, const PathTask& task,
         const PathOptions& options, common::Progress& progress)
      : equations_(manipulator, posture, task),
        continuation_(equations_),
        options_(options),
        progress_(progress) {}

  Path run() &&;

 private:
  struct Known {
    PathState at;
    int idle;  // as branch_point.h has it
  };
  // A direction in which a branch leaves a critical point, to be followed later.
  struct Departure {
    std::size_t critical;
    VectorXd direction;
  };

  double reach() const { return equations_.scale().length; }
  double longest_step(const VectorXd& tangent) const;
  void follow(std::size_t branch, Station station);
  bool ends(std::size_t branch, const Station& from, const Station& to);
  void end(std::size_t branch, BranchEnd end) { path_.branches[branch].end = end; }
  void lose(std::size_t branch, const Station& last);
  bool visit_critical_points(std::size_t branch, const Station& from, const Station& to);
  /// Nothing when the step does not come to the end of the range.
  std::optional<Station> at_end_of_range(const Station& from, const Station& to);
  void meet_target(std::size_t branch, const Station& from, const Station& to);
  bool meet_followed(std::size_t branch, const Station& station);
  bool is_outside(const PathState& state) const;
  double margin(double limit) const { return 1e-12 * std::abs(limit); }
  const Segment* followed(const Station& station, std::size_t newest);
  std::optional<std::size_t> known(std::size_t branch, const PathState& state,
                                   double nearness) const;
  CriticalPoint described(std::size_t branch, const CriticalStation& critical) const;
  void add_critical(std::size_t branch, const CriticalStation& critical);
  void sort_at_target();
  void follow_departure(const Departure& departure);
  std::optional<Station> switched(const PathState& at, const VectorXd& direction);
  void add_point(std::size_t branch, const Station& station) {
    path_.branches[branch].points.push_back(equations_.describe(station.at, &station.tangent));
  }

  PathEquations equations_;
  Continuation continuation_;
  PathOptions options_;
  common::Progress& progress_;
  Path path_;
  std::vector<Known> known_;          // one per critical point
  std::vector<PathState> at_target_;  // one per point there
  std::vector<Segment> segments_;     // of all branches
  std::deque<Departure> departures_;
};

double Tracer::longest_step(const VectorXd& tangent) const {
  // Forces may grow without bound where hardly anything moves.
  const double by_motion = std::min(10.0, 0.1 / std::max(equations_.motion(tangent), slowest));
  const double rate = std::abs(tangent[tangent.size() - 1]);
  if (rate < slowest) return by_motion * reach();
  return std::min(by_motion * reach(), equations_.weight() / options_.points / rate);
}

void Tracer::follow(std::size_t b, Station station) {
  add_point(b, station);
  const double shortest = 1e-12 * reach();
  double length = std::min(longest_step(station.tangent), 0.02 * reach());
  int locked = 0;  // points in a row
  while (path_.branches[b].points.size() < static_cast<std::size_t>(options_.most_points)) {
    progress_.report(fmt::format("branch {}", b + 1),
                     std::clamp(std::abs(station.at.parameter), 0.0, 1.0));
    length = std::min(length, longest_step(station.tangent));
    const std::optional<Station> next = continuation_.step(station, length);
    if (!next) {
      length /= 2;
      if (!(length > shortest)) return lose(b, station);
      continue;
    }
    const int iterations = continuation_.iterations();
    if (ends(b, station, *next)) return;
    station = *next;
    const bool still =
        std::abs(station.parameter_rate()) < slowest && equations_.motion(station.tangent) < 1e-3;
    locked = still ? locked + 1 : 0;
    if (locked > options_.points) return end(b, BranchEnd::locked);
    if (iterations <= 4) length *= 1.5;
  }
  end(b, BranchEnd::limit);
}

void Tracer::lose(std::size_t b, const Station& last) {
  end(b, BranchEnd::lost);
  path_.branches[b].reason = fmt::format(
      "beyond parameter {:.6g} no equilibrium follows continuously: the model has no resistance "
      "there, or is rigid",
      last.at.parameter);
}

// Takes a step into the branch, or what of it lies in the range.
bool Tracer::ends(std::size_t b, const Station& from, const Station& to) {
  const std::optional<Station> last = at_end_of_range(from, to);
  const Station& next = last ? *last : to;
  if (visit_critical_points(b, from, next)) return true;
  meet_target(b, from, next);
  add_point(b, next);
  segments_.push_back({b, from, next.at});
  if (!last) return meet_followed(b, next);
  const bool target = next.at.parameter == options_.highest && options_.highest == 1;
  end(b, target ? BranchEnd::target : BranchEnd::range);
  return true;
}

// A critical point found before the step on which the branch is, at the same place.
std::optional<std::size_t> Tracer::known(std::size_t branch, const PathState& state,
                                         double nearness) const {
  std::optional<std::size_t> nearest;
  for (std::size_t c = 0; c < known_.size(); ++c) {
    const CriticalPoint& critical = path_.critical[c];
    if (critical.branch == branch && critical.after + 1 == path_.branches[branch].points.size())
      continue;
    if (std::abs(known_[c].at.parameter - state.parameter) > 1e-5 * (1 + std::abs(state.parameter)))
      continue;
    const double distance = equations_.separation(known_[c].at, state).norm();
    if (distance >= nearness) continue;
    nearest = c;
    nearness = distance;
  }
  return nearest;
}

CriticalPoint Tracer::described(std::size_t branch, const CriticalStation& critical) const {
  CriticalPoint point;
  point.kind = critical.kind;
  point.branch = branch;
  point.after = path_.branches[branch].points.size() - 1;
  point.point = equations_.describe(critical.station.at);
  point.multiplicity = critical.multiplicity;
  point.uncertainty = critical.uncertainty;
  point.unstable_before = critical.unstable_before;
  point.unstable_after = critical.unstable_after;
  return point;
}

void Tracer::add_critical(std::size_t branch, const CriticalStation& critical) {
  const std::size_t number = path_.critical.size();
  path_.critical.push_back(described(branch, critical));
  known_.push_back({critical.station.at, critical.idle});
  if (!options_.branches || critical.kind != CriticalKind::bifurcation) return;
  for (const VectorXd& direction :
       leaving_directions(continuation_, critical.beside, critical.station, critical.idle,
                          critical.multiplicity)) {
    departures_.push_back({number, direction});
    departures_.push_back({number, -direction});
  }
}

// True when the branch ends here, at a bifurcation that another branch has passed.
bool Tracer::visit_critical_points(std::size_t b, const Station& from, const Station& to) {
  const double chord = continuation_.difference(from, to).norm();
  const double nearness = std::clamp(1e-3 * chord, 1e-11 * reach(), 1e-6 * reach());
  for (const CriticalStation& critical : critical_between(continuation_, from, to)) {
    if (const auto met = known(b, critical.station.at, nearness)) {
      if (path_.critical[*met].kind != CriticalKind::bifurcation) continue;
      segments_.push_back({b, from, critical.station.at});
      path_.branches[b].points.push_back(path_.critical[*met].point);
      path_.branches[b].to = *met;
      end(b, BranchEnd::junction);
      return true;
    }
    add_critical(b, critical);
    if (!options_.until_critical) continue;
    end(b, BranchEnd::critical);
    return true;
  }
  return false;
}

// The last of equal steps may miss the target by rounding only.
void Tracer::meet_target(std::size_t b, const Station& from, const Station& to) {
  const double before = from.at.parameter - 1, after = to.at.parameter - 1;
  if (before * after > 0 && std::abs(after) > margin(1)) return;
  const std::optional<Station> at = continuation_.at_parameter(from, to, 1);
  if (!at) return;
  for (const PathState& other : at_target_)
    if (equations_.separation(other, at->at).norm() < 1e-7 * reach()) return;
  at_target_.push_back(at->at);
  path_.at_target.push_back({b, equations_.describe(at->at, &at->tangent)});
}

bool Tracer::is_outside(const PathState& state) const {
  return state.parameter > options_.highest + margin(options_.highest) ||
         state.parameter < options_.lowest - margin(options_.lowest);
}

std::optional<Station> Tracer::at_end_of_range(const Station& from, const Station& to) {
  const double p = to.at.parameter, highest = options_.highest, lowest = options_.lowest;
  const bool above = p > from.at.parameter && p >= highest - margin(highest);
  const bool below = p < from.at.parameter && p <= lowest + margin(lowest);
  if (!above && !below) return std::nullopt;
  return continuation_.at_parameter(from, to, above ? highest : lowest).value_or(to);
}

// The step of a branch on which a station lies. Of the newest branch the last steps do not count.
const Segment* Tracer::followed(const Station& station, std::size_t newest) {
  std::size_t own = 0;
  for (std::size_t i = segments_.size(); i-- > 0;) {
    const Segment& segment = segments_[i];
    if (segment.branch == newest && ++own <= 3) continue;
    const double low = std::min(segment.from.at.parameter, segment.to.parameter);
    const double high = std::max(segment.from.at.parameter, segment.to.parameter);
    const double aside = 0.2 * (high - low) + margin(high);
    if (station.at.parameter < low - aside || station.at.parameter > high + aside) continue;
    // Branches that cross share a state, too, but no tangent.
    const VectorXd& along = segment.from.tangent;
    if (std::abs(along.dot(station.tangent)) < 0.9) continue;
    const VectorXd chord = equations_.difference(segment.from.at, segment.to);
    const VectorXd change = equations_.separation(segment.from.at, station.at);
    const double share = along.dot(change) / along.dot(chord);
    if (!(share >= 0 && share <= 1) || (change - share * chord).norm() > 0.2 * chord.norm())
      continue;
    const std::optional<Station> there =
        continuation_.correct(segment.from.at, share * chord, along, along.dot(change), along);
    const double nearness = 1e-5 * chord.norm() + 1e-11 * reach();
    if (there && equations_.separation(there->at, station.at).norm() < nearness) return &segment;
  }
  return nullptr;
}

bool Tracer::meet_followed(std::size_t b, const Station& station) {
  const Segment* const segment = followed(station, b);
  if (!segment) return false;
  end(b, segment->branch == b ? BranchEnd::closed : BranchEnd::joined);
  if (segment->branch != b) path_.branches[b].onto = segment->branch;
  return true;
}

// A point beside the bifurcation, off the branch that led to it.
std::optional<Station> Tracer::switched(const PathState& at, const VectorXd& direction) {
  const double usual = std::min(longest_step(direction), 0.1 * reach());
  for (const double share : {1e-2, 1e-1, 1e-3, 0.3, 1e-4, 1e-5}) {
    const double offset = share * usual;
    std::optional<Station> station =
        continuation_.correct(at, offset * direction, direction, offset, direction);
    if (station && !is_outside(station->at) &&
        equations_.difference(at, station->at).norm() < 5 * offset)
      return station;
  }
  return std::nullopt;
}

void Tracer::follow_departure(const Departure& departure) {
  const auto& [at, idle] = known_[departure.critical];
  const std::size_t b = path_.branches.size();
  const std::optional<Station> station = switched(at, departure.direction);
  if (!station || followed(*station, b)) return;
  path_.branches.emplace_back().from = departure.critical;
  path_.branches[b].points.push_back(path_.critical[departure.critical].point);
  segments_.push_back({b, *station, at});
  if (idle_directions(continuation_, *station) <= idle) return follow(b, *station);
  add_point(b, *station);
  end(b, BranchEnd::free);
}

// The most stable first, then the lowest in energy.
void Tracer::sort_at_target() {
  const PathTask& task = equations_.task();
  std::stable_sort(path_.at_target.begin(), path_.at_target.end(),
                   [&](const TargetPoint& a, const TargetPoint& b) {
                     const int u = a.point.stability(task).unstable;
                     const int v = b.point.stability(task).unstable;
                     if (u != v) return u < v;
                     return a.point.potential.value_or(0) < b.point.potential.value_or(0);
                   });
}

Path Tracer::run() && {
  PathState start;
  path_.status = equations_.start(0, start, path_.reason);
  path_.branches.emplace_back();
  if (path_.status != EquilibriumStatus::converged) {
    path_.branches[0].reason = path_.reason;
    return std::move(path_);
  }
  equations_.balance_weight(start);
  if (const std::optional<Station> first = continuation_.first(start)) {
    follow(0, *first);
  } else {
    path_.branches[0].points.push_back(equations_.describe(start));
    path_.branches[0].reason =
        "the path does not leave its start: the load works on a motion that nothing resists, or "
        "the displacement meets one that is rigid";
  }
  while (!departures_.empty() &&
         path_.branches.size() < static_cast<std::size_t>(options_.most_branches)) {
    const Departure next = departures_.front();
    departures_.pop_front();
    follow_departure(next);
  }
  path_.not_tried = departures_.size();
  sort_at_target();
  return std::move(path_);
}

}  // namespace

Path trace(const Manipulator& manipulator, const Posture& posture, const PathTask& task,
           const PathOptions& options, common::Progress& progress) {
  return Tracer(manipulator, posture, task, options, progress).run();
}

}  // namespace kinetostat::vjm

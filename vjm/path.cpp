#include "kinetostat/vjm/path.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include <fmt/format.h>

#include "kinetostat/vjm/critical_point.h"

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double slowest = 1e-9;  // rate of a parameter that does not move

class Tracer {
 public:
  Tracer(const Manipulator& manipulator, const Posture& posture, const PathTask& task,
         const PathOptions& options, files::Progress& progress)
      : equations_(manipulator, posture, task),
        continuation_(equations_),
        options_(options),
        progress_(progress) {}

  Path run() &&;

 private:
  // A direction in which a branch leaves a critical point, to be followed later.
  struct Departure {
    std::size_t critical;
    VectorXd direction;
  };
  struct Known {
    Station station;
    std::vector<VectorXd> taken;  // directions in which branches that were followed leave
  };

  double reach() const { return equations_.scale().length; }
  double longest_step(const Station& at) const;
  void follow(std::size_t branch, Station station);
  bool visit_critical_points(std::size_t branch, const Station& from, const Station& to);
  bool leave_range(std::size_t branch, const Station& from, const Station& to);
  void meet_target(std::size_t branch, const Station& from, const Station& to);
  std::optional<std::size_t> known(std::size_t branch, const Station& station) const;
  void add_critical(std::size_t branch, const CriticalStation& critical, const Station& from);
  void sort_at_target();
  void follow_departure(const Departure& departure);
  std::optional<Station> switched(const Known& at, const VectorXd& direction);
  void add_point(std::size_t branch, const Station& station) {
    path_.branches[branch].points.push_back(equations_.describe(station.at, &station.tangent));
  }

  PathEquations equations_;
  Continuation continuation_;
  PathOptions options_;
  files::Progress& progress_;
  Path path_;
  std::vector<Known> known_;  // one per critical point
  std::deque<Departure> departures_;
};

double Tracer::longest_step(const Station& at) const {
  const double rate = std::abs(at.parameter_rate());
  if (rate < slowest) return 10 * reach();
  const double by_parameter =
      equations_.weight() / options_.points / std::max(rate, std::numeric_limits<double>::min());
  return std::min(by_parameter, 0.1 * reach());
}

void Tracer::follow(std::size_t b, Station station) {
  add_point(b, station);
  const Station start = station;
  const double shortest = 1e-12 * reach();
  double length = std::min(longest_step(station), 0.02 * reach());
  int locked = 0;  // points in a row
  while (path_.branches[b].points.size() < static_cast<std::size_t>(options_.most_points)) {
    progress_.report(fmt::format("branch {}", b + 1),
                     std::clamp(std::abs(station.at.parameter), 0.0, 1.0));
    length = std::min(length, longest_step(station));
    const std::optional<Station> next = continuation_.step(station, length);
    if (!next) {
      length /= 2;
      if (length > shortest) continue;
      path_.branches[b].end = BranchEnd::lost;
      path_.branches[b].reason = fmt::format(
          "beyond parameter {:.6g} no equilibrium follows continuously: the model has no "
          "resistance "
          "there, or is rigid",
          station.at.parameter);
      return;
    }
    const int iterations = continuation_.iterations();
    if (visit_critical_points(b, station, *next)) return;
    meet_target(b, station, *next);
    if (leave_range(b, station, *next)) return;
    add_point(b, *next);
    const bool back = continuation_.difference(start, *next).norm() < 0.5 * length &&
                      next->tangent.dot(start.tangent) > 0.9;
    if (back && path_.branches[b].points.size() > 5) {
      path_.branches[b].end = BranchEnd::closed;
      return;
    }
    station = *next;
    locked = std::abs(station.parameter_rate()) < slowest ? locked + 1 : 0;
    if (locked > options_.points) {
      path_.branches[b].end = BranchEnd::locked;
      return;
    }
    if (iterations <= 4) length *= 1.5;
  }
  path_.branches[b].end = BranchEnd::limit;
}

// A bifurcation, found before the step on which the branch is, at the same place.
std::optional<std::size_t> Tracer::known(std::size_t branch, const Station& station) const {
  for (std::size_t c = 0; c < known_.size(); ++c) {
    const CriticalPoint& critical = path_.critical[c];
    const bool of_this_step =
        critical.branch == branch && critical.after + 1 == path_.branches[branch].points.size();
    if (critical.kind == CriticalKind::bifurcation && !of_this_step &&
        equations_.difference(known_[c].station.at, station.at).norm() < 1e-6 * reach())
      return c;
  }
  return std::nullopt;
}

void Tracer::add_critical(std::size_t branch, const CriticalStation& critical,
                          const Station& from) {
  CriticalPoint point;
  point.kind = critical.kind;
  point.branch = branch;
  point.after = path_.branches[branch].points.size() - 1;
  point.point = equations_.describe(critical.station.at);
  point.multiplicity =
      std::max<int>(1, std::abs(critical.unstable_after - critical.unstable_before));
  point.uncertainty = critical.uncertainty;
  point.unstable_before = critical.unstable_before;
  point.unstable_after = critical.unstable_after;
  const std::size_t number = path_.critical.size();
  path_.critical.push_back(std::move(point));

  // The tangent at the critical point itself is not defined; that just before is.
  VectorXd through = continuation_.difference(from, critical.station);
  through = through.norm() > 1e-9 * reach() ? through.normalized() : from.tangent;
  known_.push_back({critical.station, {through, -through}});
  if (!options_.branches || critical.kind != CriticalKind::bifurcation) return;
  equations_.right_hand_side(critical.station.at);
  equations_.derivative();
  for (const Index mode : critical.modes) {
    VectorXd direction = equations_.eigenmotion(mode).normalized();
    direction -= direction.dot(through) * through;
    if (direction.norm() < 1e-3) continue;
    direction.normalize();
    departures_.push_back({number, direction});
    departures_.push_back({number, -direction});
  }
}

// True when the branch ends here, at a bifurcation that another branch has passed.
bool Tracer::visit_critical_points(std::size_t b, const Station& from, const Station& to) {
  for (const CriticalStation& critical : critical_between(continuation_, from, to)) {
    if (const auto met = known(b, critical.station)) {
      const VectorXd arrival = continuation_.difference(known_[*met].station, from).normalized();
      known_[*met].taken.push_back(arrival);
      path_.branches[b].points.push_back(path_.critical[*met].point);
      path_.branches[b].end = BranchEnd::junction;
      path_.branches[b].to = *met;
      return true;
    }
    add_critical(b, critical, from);
    if (!options_.until_critical) continue;
    path_.branches[b].end = BranchEnd::critical;
    return true;
  }
  return false;
}

void Tracer::meet_target(std::size_t b, const Station& from, const Station& to) {
  const double before = from.at.parameter - 1, after = to.at.parameter - 1;
  if (before == 0 || before * after > 0) return;
  const std::optional<Station> at = continuation_.at_parameter(from, to, 1);
  if (!at) return;
  path_.at_target.push_back({b, equations_.describe(at->at, &at->tangent)});
}

bool Tracer::leave_range(std::size_t b, const Station& from, const Station& to) {
  const double limit = std::clamp(to.at.parameter, options_.lowest, options_.highest);
  const double margin = 1e-12 * (options_.highest - options_.lowest);
  if (std::abs(to.at.parameter - limit) <= margin &&
      std::abs(to.at.parameter - options_.highest) > margin)
    return false;
  if (const std::optional<Station> last = continuation_.at_parameter(from, to, limit))
    add_point(b, *last);
  path_.branches[b].end =
      limit == options_.highest && limit == 1 ? BranchEnd::target : BranchEnd::range;
  return true;
}

// A point beside the bifurcation, off the branch that led to it.
std::optional<Station> Tracer::switched(const Known& at, const VectorXd& direction) {
  for (const double share : {1e-3, 1e-2, 1e-4, 3e-2}) {
    const double offset = share * reach();
    const std::optional<Station> station =
        continuation_.correct(at.station.at, offset * direction, direction, offset, direction);
    if (station && equations_.difference(at.station.at, station->at).norm() < 5 * offset)
      return station;
  }
  return std::nullopt;
}

void Tracer::follow_departure(const Departure& departure) {
  const std::optional<Station> station = switched(known_[departure.critical], departure.direction);
  if (!station) return;
  const VectorXd leaving =
      continuation_.difference(known_[departure.critical].station, *station).normalized();
  for (const VectorXd& taken : known_[departure.critical].taken)
    if (taken.dot(leaving) > 0.9) return;
  known_[departure.critical].taken.push_back(leaving);
  path_.branches.emplace_back().from = departure.critical;
  path_.branches.back().points.push_back(path_.critical[departure.critical].point);
  follow(path_.branches.size() - 1, *station);
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
        "the "
        "displacement meets one that is rigid";
  }
  while (!departures_.empty() &&
         path_.branches.size() < static_cast<std::size_t>(options_.most_branches)) {
    const Departure next = departures_.front();
    departures_.pop_front();
    follow_departure(next);
  }
  sort_at_target();
  return std::move(path_);
}

}  // namespace

Path trace(const Manipulator& manipulator, const Posture& posture, const PathTask& task,
           const PathOptions& options, files::Progress& progress) {
  return Tracer(manipulator, posture, task, options, progress).run();
}

}  // namespace kinetostat::vjm

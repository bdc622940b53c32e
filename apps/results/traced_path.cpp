#include "kinetostat/apps/results/traced_path.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/common/error.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/manipulators/path.h"
#include "kinetostat/report/manipulators/uncertainty.h"

namespace kinetostat::apps {
namespace {

vjm::Path trace(const TraceRequest& request, const vjm::Robot& robot,
                const vjm::PathOptions& options, Run& run) {
  return vjm::trace(robot.manipulator, request.posture.posture(robot), request.task(robot), options,
                    run.progress());
}

// Force and deflection at the first critical point of a path, else at its end; nothing where only
// nodes are loaded, or where a path has such a point and another one, `like`, has none.
std::optional<Eigen::VectorXd> numbers_of(const vjm::Path& path, const vjm::Path& like) {
  if (path.status != vjm::EquilibriumStatus::converged ||
      path.critical.empty() != like.critical.empty())
    return std::nullopt;
  const vjm::PathPoint& point =
      path.critical.empty() ? path.branches[0].points.back() : path.critical[0].point;
  if (!point.along) return std::nullopt;
  return Eigen::Vector2d(point.along->force, point.along->deflection);
}

std::optional<vjm::Uncertainty> uncertainty_of(const TraceRequest& request, const vjm::Robot& robot,
                                               const vjm::PathTask& task, const vjm::Path& path,
                                               Run& run) {
  vjm::PathOptions options = request.path;
  options.branches = false;
  options.until_critical = true;
  const vjm::Posture posture = request.posture.posture(robot);
  const auto numbers = [&](const vjm::Robot& other) {
    common::Progress silent;
    const auto own = request.posture.posture_like(posture, robot, other);
    return own ? numbers_of(vjm::trace(other.manipulator, *own, task, options, silent), path)
               : std::nullopt;
  };
  return numbers_of(path, path) ? request.uncertainty.of(robot, numbers, run) : std::nullopt;
}

// The force at the first critical point, with every beam in so many times its segments.
std::optional<double> first_critical_force(const TraceRequest& request, int multiple, Run& run) {
  const vjm::Robot robot = request.posture.read({.segment_multiple = multiple});
  vjm::PathOptions options = request.path;
  options.branches = false;
  options.until_critical = true;
  const vjm::Path path = trace(request, robot, options, run);
  if (path.critical.empty()) return std::nullopt;
  const auto& along = path.critical[0].point.along;
  return along ? std::optional(along->force) : std::nullopt;
}

// Whether finer beams may have critical points: the path shows one, or the equilibria at its ends,
// as the path has them, would not last.
bool may_buckle(const TraceRequest& request, const vjm::PathTask& task, const vjm::Path& path) {
  if (!path.critical.empty()) return true;
  const vjm::Robot finer =
      request.posture.read({.segment_multiple = vjm::SegmentCheck::stability_multiple});
  const vjm::Posture posture = request.posture.posture(finer);
  for (const vjm::Branch& branch : path.branches) {
    if (branch.points.empty()) continue;
    const double parameter = branch.points.back().parameter;
    vjm::Equilibrium given = branch.points.back().equilibrium;
    if (take_stability(equilibrium_at(finer.manipulator, posture, task, parameter),
                       task.platform_held, given))
      return true;
  }
  return false;
}

void require_valid(const TraceRequest& request) {
  if (!request.load.given())
    throw UsageError("--along", "nothing is given that grows along the path",
                     "Give --along dx,dy,dz for a displacement, or --wrench Fx,Fy,Fz or "
                     "--node-load for a load");
  if (request.hold && !request.load.wrench.empty())
    throw UsageError("--hold", "a platform that is held feels no --wrench",
                     "Load the chains with --node-load, or leave --hold out");
  const vjm::PathOptions& path = request.path;
  if (!std::isfinite(path.lowest) || !std::isfinite(path.highest))
    throw UsageError(std::isfinite(path.lowest) ? "--to" : "--from", "the range must be finite");
  if (!(path.lowest <= 0 && path.highest > 0))
    throw UsageError(path.lowest <= 0 ? "--to" : "--from",
                     fmt::format("the range {:g} to {:g} must hold the start, parameter 0",
                                 path.lowest, path.highest),
                     "Give --from 0 or less and --to more than 0");
}

// Where everything stays as it is, there is no path.
void check_that_something_grows(const TraceRequest& request, const vjm::PathTask& task) {
  if (task.platform_held && !task.displacement.isZero(0)) return;
  const vjm::Load& load = task.growing;
  bool grows = !task.platform_held && !(load.force.isZero(0) && load.moment.isZero(0));
  for (const vjm::NodeLoad& node : load.nodes)
    grows |= !(node.force.isZero(0) && node.moment.isZero(0));
  if (grows) return;
  const char* const option = !request.load.move.empty()     ? "--along"
                             : !request.load.wrench.empty() ? "--wrench"
                                                            : "--node-load";
  throw UsageError(option, "it is zero: nothing grows along the path",
                   "Give the displacement or load at the end of the path");
}

void add_uncertainty(const TracedPath& result, io::Json& json) {
  const vjm::Uncertainty& uncertainty = *result.uncertainty;
  json = report::settings_json(uncertainty);
  json["at"] = result.is_critical() ? "first critical point" : "end of the path";
  for (const auto& [name, number] : {std::pair("force", 0), std::pair("deflection", 1)})
    json[name] = report::number_json(uncertainty, number);
  json["of"] = result.shown() == 0 ? "force" : "deflection";
  json["budget"] = report::budget_json(uncertainty, result.shown());
}

}  // namespace

vjm::PathTask TraceRequest::task(const vjm::Robot& robot) const {
  vjm::PathTask task = load.task(robot);
  task.platform_held |= hold;
  return task;
}

TracedPath traced_path(const TraceRequest& request, Run& run) {
  require_valid(request);
  TracedPath result{.robot = request.posture.read()};
  const vjm::Robot& robot = result.robot;
  result.task = request.task(robot);
  check_that_something_grows(request, result.task);
  result.posture = request.posture.posture(robot);
  warn_beyond_ranges(robot, result.posture, run);
  result.path = trace(request, robot, request.path, run);
  if (result.path.status != vjm::EquilibriumStatus::converged)
    throw common::NoConvergence("there is no equilibrium to start from: " + result.path.reason);
  if (robot.has_beams && may_buckle(request, result.task, result.path))
    result.segments = vjm::study_segments(request.segments, [&](int multiple) {
      return first_critical_force(request, multiple, run);
    });
  result.uncertainty = uncertainty_of(request, robot, result.task, result.path, run);
  const vjm::Branch& first = result.path.branches[0];
  if (first.end == vjm::BranchEnd::lost) run.stop_short(first.reason);
  return result;
}

io::Json to_json(const TracedPath& result) {
  const vjm::Robot& robot = result.robot;
  io::Json json{{"headline", report::headline(robot, result.task, result.path)},
                {"inputs", report::provenance(robot)},
                {"path", report::to_json(robot, result.task, result.path)}};
  if (result.segments) json["segments"] = report::to_json(*result.segments);
  if (result.uncertainty) add_uncertainty(result, json["uncertainty"]);
  return json;
}

}  // namespace kinetostat::apps

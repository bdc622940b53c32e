// kinetostat trace: force against deflection, past limit points and through bifurcations.
#include <cmath>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/robot_request.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/manipulators/path.h"
#include "kinetostat/report/manipulators/uncertainty.h"
#include "kinetostat/report/screen/manipulator.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/vjm/statics/segments.h"

namespace kinetostat::apps {
namespace {

struct TraceRequest {
  PostureRequest posture;
  LoadRequest load;
  UncertaintyRequest uncertainty;
  vjm::PathOptions path;
  std::vector<int> segments{1, 2, 4};
  bool hold = false;

  vjm::PathTask task(const vjm::Robot& robot) const {
    vjm::PathTask task = load.task(robot);
    task.platform_held |= hold;
    return task;
  }
};

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

// The force where the path becomes unstable, or where it ends; what leads there when it is given.
void report_uncertainty(const TraceRequest& request, const vjm::Robot& robot,
                        const vjm::PathTask& task, const vjm::Path& path, io::Json& json,
                        Run& run) {
  const auto uncertainty = uncertainty_of(request, robot, task, path, run);
  if (!uncertainty) return;
  const bool is_critical = !path.critical.empty();
  const Eigen::Index shown = is_critical || task.platform_held ? 0 : 1;
  run.print(report::path_budget(robot, task, *uncertainty, shown, is_critical));
  json["uncertainty"] = report::settings_json(*uncertainty);
  json["uncertainty"]["at"] = is_critical ? "first critical point" : "end of the path";
  for (const auto& [name, number] : {std::pair("force", 0), std::pair("deflection", 1)})
    json["uncertainty"][name] = report::number_json(*uncertainty, number);
  json["uncertainty"]["of"] = shown == 0 ? "force" : "deflection";
  json["uncertainty"]["budget"] = report::budget_json(*uncertainty, shown);
}

// The force at the first critical point, with every beam in so many times its segments.
std::optional<double> first_critical_force(const TraceRequest& request, int multiple, Run& run) {
  const vjm::Robot robot =
      vjm::read_robot(request.posture.robot_file, {.segment_multiple = multiple});
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
  const vjm::Robot finer = vjm::read_robot(
      request.posture.robot_file, {.segment_multiple = vjm::SegmentCheck::stability_multiple});
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

io::Json trace(const TraceRequest& request, Run& run) {
  require_valid(request);
  const vjm::Robot robot = request.posture.read();
  const vjm::PathTask task = request.task(robot);
  check_that_something_grows(request, task);
  warn_beyond_ranges(robot, request.posture.posture(robot), run);
  const vjm::Path path = trace(request, robot, request.path, run);
  if (path.status != vjm::EquilibriumStatus::converged)
    throw common::NoConvergence("there is no equilibrium to start from: " + path.reason);
  io::Json json{{"headline", report::headline(robot, task, path)},
                {"inputs", report::provenance(robot)},
                {"path", report::to_json(robot, task, path)}};
  vjm::SegmentStudy study;
  if (robot.has_beams && may_buckle(request, task, path)) {
    study = vjm::study_segments(request.segments, [&](int multiple) {
      return first_critical_force(request, multiple, run);
    });
    json["segments"] = report::to_json(study);
  }
  run.print(report::wrapped(report::headline(robot, task, path)) +
            report::wrapped(report::warning(robot, task, study)));
  run.print(report::wrapped_lines(report::text(robot, task, study)));
  report_uncertainty(request, robot, task, path, json, run);
  run.print("\nevery critical point, branch and equilibrium: --verbose, or --html\n");
  run.print_more("\n" + fmt::format("{}\n", robot.name) +
                 report::text(robot, request.posture.posture(robot)) +
                 report::text(robot, task, path));
  if (run.wants_page()) run.draw(report::picture(robot, task, path));
  if (run.out()) io::write_atomically(*run.out(), report::csv(robot, task, path));
  if (path.branches[0].end == vjm::BranchEnd::lost) run.stop_short(path.branches[0].reason);
  return json;
}

}  // namespace

void add_trace(Program& program) {
  const auto request = std::make_shared<TraceRequest>();
  OptionList app = program.add(
      {.name = "trace",
       .summary = "Force against deflection along a path, with its critical points and branches",
       .example =
           "kinetostat trace data/robots/urrs_c.yaml --along -150,0,0 --branches -o path.csv",
       .out = "Write the path, one row a point, to a CSV file"},
      [request](Run& run) { return trace(*request, run); });
  request->posture.add_options(app);
  request->load.add_options(app);
  request->uncertainty.add_options(app);
  app.add_flag("--hold", request->hold, "Hold the platform where it is, under loads at nodes");
  app.add_flag("--branches", request->path.branches, "Follow what leaves at bifurcations, too");
  app.add_option("--points", request->path.points, "Least number of points from 0 to 1")
      .between(1, 100000);
  app.add_option("--most-points", request->path.most_points, "Most points of one branch")
      .between(2, 1000000);
  app.add_option("--from", request->path.lowest,
                 "Lowest parameter; branches end where they leave the range");
  app.add_option("--to", request->path.highest, "Highest parameter, 1 for the whole load");
  app.add_option("--segments", request->segments,
                 "Multiples of the beams' segments for which the first critical force is compared")
      .delimiter(',')
      .between(1, 1000);
}

}  // namespace kinetostat::apps

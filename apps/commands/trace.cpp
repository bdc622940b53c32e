// kinetostat trace: force against deflection, past limit points and through bifurcations.
#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/results/traced_path.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/manipulators/path.h"
#include "kinetostat/report/screen/manipulator.h"
#include "kinetostat/report/screen/wording.h"

namespace kinetostat::apps {
namespace {

io::Json trace(const TraceRequest& request, Run& run) {
  const TracedPath result = traced_path(request, run);
  const vjm::Robot& robot = result.robot;
  const vjm::PathTask& task = result.task;
  const vjm::SegmentStudy study = result.segments.value_or(vjm::SegmentStudy());
  run.print(report::wrapped(report::headline(robot, task, result.path)) +
            report::wrapped(report::warning(robot, task, study)));
  run.print(report::wrapped_lines(report::text(robot, task, study)));
  if (const auto& uncertainty = result.uncertainty)
    run.print(report::path_budget(robot, task, *uncertainty, result.shown(), result.is_critical()));
  run.print("\nevery critical point, branch and equilibrium: --verbose, or --html\n");
  run.print_more("\n" + fmt::format("{}\n", robot.name) + report::text(robot, result.posture) +
                 report::text(robot, task, result.path));
  if (run.wants_page()) run.draw(report::picture(robot, task, result.path));
  if (run.out()) io::write_atomically(*run.out(), report::csv(robot, task, result.path));
  return to_json(result);
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

// kinetostat deflect: the loaded equilibrium, for a given wrench or a given displacement.
#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/command.h"
#include "kinetostat/apps/commands.h"
#include "kinetostat/apps/robot_request.h"
#include "kinetostat/apps/segment_check.h"
#include "kinetostat/report/manipulator.h"

namespace kinetostat::apps {
namespace {

struct Request {
  PostureRequest posture;
  LoadRequest load;
};

files::Json deflect(const Request& request, Run& run) {
  const vjm::Robot robot = request.posture.read();
  if (!request.load.given() && robot.manipulator.is_relaxed_when_unloaded())
    throw UsageError(
        "--wrench", "no load is given, and the robot has no weight",
        "Give --wrench Fx,Fy,Fz[,Mx,My,Mz], --node-load, or --move for a displacement");
  const vjm::Posture posture = request.posture.posture(robot);
  const vjm::Equilibrium equilibrium = request.load.solve(robot, posture);
  run.print(fmt::format("{}\n", robot.name) + report::text(robot, posture) +
            report::text(robot, equilibrium));
  const std::optional<double> lumping =
      lumping_error(robot, request.posture, request.load, equilibrium);
  run.print(lumping_warning(lumping));
  if (equilibrium.status != vjm::EquilibriumStatus::converged) run.stop_short(equilibrium.reason);
  return {{"inputs", report::provenance(robot)},
          {"posture", report::to_json(robot, posture)},
          {"equilibrium", report::to_json(robot, equilibrium)},
          {"lumping_error", lumping ? files::Json(*lumping) : files::Json()}};
}

}  // namespace

void add_deflect(Program& program) {
  const auto request = std::make_shared<Request>();
  CLI::App& app = program.add(
      {.name = "deflect",
       .summary = "Where a manipulator goes under a wrench, or what wrench holds a displacement",
       .example = "kinetostat deflect data/robots/orthoglide.yaml --at 0,0,0 --wrench 100,0,0"},
      [request](Run& run) { return deflect(*request, run); });
  request->posture.add_options(app);
  request->load.add_options(app);
}

}  // namespace kinetostat::apps

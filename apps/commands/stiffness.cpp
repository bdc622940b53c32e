// kinetostat stiffness: the Cartesian stiffness matrix in a posture, without or under load.
#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/robot_request.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/manipulators/segment_check.h"
#include "kinetostat/report/manipulators/skeleton.h"
#include "kinetostat/report/screen/manipulator.h"

namespace kinetostat::apps {
namespace {

struct Request {
  PostureRequest posture;
  LoadRequest load;
};

io::Json stiffness(const Request& request, Run& run) {
  const vjm::Robot robot = request.posture.read();
  const vjm::Posture posture = request.posture.posture(robot);
  const vjm::UnloadedStiffness unloaded = unloaded_stiffness(robot.manipulator, posture);
  std::vector<vjm::SpringShare> shares;
  if (unloaded.compliance)
    shares = vjm::spring_shares(robot.manipulator, posture,
                                report::softest_direction(*unloaded.compliance).direction);
  run.print(report::first_screen(robot, posture, unloaded, shares));
  run.print_more(fmt::format("\n{}\n", robot.name) + report::text(robot, posture));
  run.print_more("Unloaded\n--------\n" + report::text(robot, unloaded));
  io::Json json = report::inputs_and_posture(robot, posture);
  json["headline"] = report::headline(robot, unloaded, shares);
  json["yields"] = report::to_json(robot, shares);
  json["unloaded"] = report::to_json(robot, unloaded);
  run.draw(report::picture(robot.manipulator, posture));
  if (!request.load.given() && robot.manipulator.is_relaxed_when_unloaded()) return json;

  vjm::Equilibrium loaded = request.load.solve(robot, posture);
  const vjm::SegmentCheck segments = check_segments(robot, request.posture, request.load, loaded);
  run.print("\n" + report::first_screen(robot, loaded) + report::text(robot, segments));
  run.print_more("\nLoaded\n------\n" + report::text(robot, loaded));
  report::add_to(json, segments);
  json["loaded"] = report::to_json(robot, loaded);
  run.draw(report::picture(robot.manipulator, posture, loaded));
  stop_short_unless_stable(request.load, robot, loaded, run);
  return json;
}

}  // namespace

void add_stiffness(Program& program) {
  const auto request = std::make_shared<Request>();
  OptionList app = program.add(
      {.name = "stiffness",
       .summary = "Cartesian stiffness of a manipulator in a posture, unloaded and under load",
       .example = "kinetostat stiffness data/robots/orthoglide.yaml --at 0,0,0"},
      [request](Run& run) { return stiffness(*request, run); });
  request->posture.add_options(app);
  request->load.add_options(app);
}

}  // namespace kinetostat::apps

// kinetostat stiffness: the Cartesian stiffness matrix in a posture, without or under load.
#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/robot_request.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/commands/link_models.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/manipulators/segment_check.h"
#include "kinetostat/report/manipulators/skeleton.h"
#include "kinetostat/report/manipulators/uncertainty.h"
#include "kinetostat/report/screen/manipulator.h"

namespace kinetostat::apps {
namespace {

struct StiffnessRequest {
  PostureRequest posture;
  LoadRequest load;
  UncertaintyRequest uncertainty;
  std::vector<std::string> links;
};

// Along the direction in which the robot of the file is softest.
void compare_stiffnesses(const StiffnessRequest& request, const vjm::Robot& robot,
                         const vjm::UnloadedStiffness& unloaded, io::Json& json, Run& run) {
  if (!unloaded.compliance)
    throw UsageError("--links", "some motion of the platform meets no resistance",
                     "Compare the links under a load: kinetostat deflect");
  const spatial::Vector3 direction = report::softest_direction(*unloaded.compliance).direction;
  const ScratchFolder folder;
  const LinkModels models(request.posture.robot_file, request.links, folder.path(), run);
  const auto rows = models.compare([&](const vjm::Robot& other) {
    return stiffness_along(other, request.posture.posture(other), direction);
  });
  const report::LinkModelFigure figure = report::stiffness_figure(robot.units);
  run.print("\n" + report::text(figure, rows));
  json["link_models"] = report::to_json(figure, rows);
}

// The unloaded robot in a posture, its softest direction, and what is known of both.
struct Unloaded {
  vjm::UnloadedStiffness stiffness;
  std::optional<spatial::Vector3> softest = {};  // none where a motion is free
  std::vector<vjm::SpringShare> shares = {};
  std::optional<vjm::Uncertainty> uncertainty = {};
};

Unloaded unloaded_robot(const StiffnessRequest& request, const vjm::Robot& robot,
                        const vjm::Posture& posture, Run& run) {
  Unloaded of{.stiffness = unloaded_stiffness(robot.manipulator, posture)};
  if (!of.stiffness.compliance) return of;
  const spatial::Vector3 softest = report::softest_direction(*of.stiffness.compliance).direction;
  of.softest = softest;
  of.shares = vjm::spring_shares(robot.manipulator, posture, softest);
  of.uncertainty = request.uncertainty.of(robot, request.posture, posture, softest, run);
  return of;
}

io::Json stiffness(const StiffnessRequest& request, Run& run) {
  const vjm::Robot robot = request.posture.read();
  const vjm::Posture posture = request.posture.posture(robot);
  warn_beyond_ranges(robot, posture, run);
  if (!request.uncertainty.drawn.empty() && request.load.given())
    throw UsageError("--drawn", "without and under the load there are two sets of draws",
                     "Ask 'kinetostat deflect' for those under the load");
  const Unloaded of = unloaded_robot(request, robot, posture, run);
  const vjm::UnloadedStiffness& unloaded = of.stiffness;
  run.print(report::first_screen(robot, posture, unloaded, of.shares, of.uncertainty));
  run.print_more(fmt::format("\n{}\n", robot.name) + report::text(robot, posture));
  run.print_more("Unloaded\n--------\n" + report::text(robot, unloaded));
  io::Json json = report::inputs_and_posture(robot, posture);
  json["headline"] = report::headline(robot, unloaded, of.shares, of.uncertainty);
  json["yields"] = report::to_json(robot, of.shares);
  json["unloaded"] = report::to_json(robot, unloaded);
  if (of.uncertainty) json["uncertainty"] = report::stiffness_json(*of.uncertainty, *of.softest);
  run.draw(report::picture(robot.manipulator, posture));
  if (!request.links.empty()) compare_stiffnesses(request, robot, unloaded, json, run);
  if (!request.load.given() && robot.manipulator.is_relaxed_when_unloaded()) return json;

  vjm::Equilibrium loaded = request.load.solve(robot, posture);
  const vjm::SegmentCheck segments = check_segments(robot, request.posture, request.load, loaded);
  const auto uncertainty =
      request.uncertainty.of(robot, request.posture, posture, request.load, loaded, run);
  run.print("\n" + report::first_screen(robot, loaded, uncertainty) +
            report::text(robot, segments));
  run.print_more("\nLoaded\n------\n" + report::text(robot, loaded));
  report::add_to(json, segments);
  json["loaded"] = report::to_json(robot, loaded);
  if (uncertainty) json["loaded"]["uncertainty"] = report::deflection_json(*uncertainty);
  run.draw(report::picture(robot.manipulator, posture, loaded));
  stop_short_unless_stable(request.load, robot, loaded, run);
  return json;
}

}  // namespace

void add_stiffness(Program& program) {
  const auto request = std::make_shared<StiffnessRequest>();
  OptionList app = program.add(
      {.name = "stiffness",
       .summary = "Cartesian stiffness of a manipulator in a posture, unloaded and under load",
       .example = "kinetostat stiffness data/robots/orthoglide.yaml --at 0,0,0"},
      [request](Run& run) { return stiffness(*request, run); });
  request->posture.add_options(app);
  request->load.add_options(app);
  request->uncertainty.add_options(app);
  request->uncertainty.add_drawn_options(app);
  add_links_option(app, request->links);
}

}  // namespace kinetostat::apps

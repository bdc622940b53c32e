// kinetostat deflect: the loaded equilibrium, for a given wrench or a given displacement.
#include <memory>
#include <stdexcept>

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
#include "kinetostat/vjm/statics/fixed_point.h"
#include "kinetostat/vjm/statics/spring_shares.h"

namespace kinetostat::apps {
namespace {

struct DeflectRequest {
  PostureRequest posture;
  LoadRequest load;
  UncertaintyRequest uncertainty;
  std::string method = "newton";
  std::vector<std::string> links;
};

// How far the platform goes, or under --move the force that holds it there.
void compare_deflections(const DeflectRequest& request, const vjm::Robot& robot, io::Json& json,
                         Run& run) {
  const bool is_held = !request.load.move.empty();
  const ScratchFolder folder;
  const LinkModels models(request.posture.robot_file, request.links, folder.path(), run);
  const auto rows = models.compare([&](const vjm::Robot& other) {
    const vjm::Posture posture = request.posture.posture(other);
    const vjm::Equilibrium found = request.load.solve(other, posture);
    if (found.status != vjm::EquilibriumStatus::converged)
      throw common::NoConvergence(found.reason);
    return is_held ? found.wrench.force.norm()
                   : (found.platform.position() - posture.platform.position()).norm();
  });
  const std::string unit = is_held ? robot.units.force : robot.units.length;
  const report::LinkModelFigure figure{is_held ? "holding force" : "displacement", unit,
                                       spatial::parse_unit(unit).factor};
  run.print("\n" + report::text(figure, rows));
  json["link_models"] = report::to_json(figure, rows);
}

// The papers' iteration; its state, how it came there, and why it stopped.
io::Json by_fixed_point(const DeflectRequest& request, const vjm::Robot& robot,
                        const vjm::Posture& posture, Run& run) {
  const vjm::PathTask task = request.load.task(robot);
  vjm::FixedPoint found;
  try {
    found = task.platform_held
                ? fixed_point_at_pose(robot.manipulator, posture,
                                      spatial::displaced(posture.platform, task.displacement))
                : fixed_point_under_load(robot.manipulator, posture, request.load.load(robot));
  } catch (const std::invalid_argument& error) {
    throw UsageError("--method", error.what(), "Use --method newton");
  }
  run.print(fmt::format("{}\n", robot.name) + report::text(robot, posture) +
            report::text(robot, posture, found));
  if (!found.converged) run.stop_short(found.reason);
  io::Json json = report::inputs_and_posture(robot, posture);
  json["fixed_point"] = report::to_json(robot, posture, found);
  return json;
}

// The force on the platform, and the point where it acts in the loaded state.
io::Json load_picture(const DeflectRequest& request, const vjm::Robot& robot,
                      const vjm::Equilibrium& equilibrium) {
  spatial::Vector3 point = spatial::Vector3::Zero();
  if (!request.load.wrench.empty()) point = request.load.load(robot).point_on_platform;
  return {{"at", io::to_json(equilibrium.platform * point)},
          {"force", io::to_json(equilibrium.wrench.force)}};
}

// Which joints and links yield along the force.
void add_yields(const vjm::Robot& robot, const vjm::Posture& posture, const spatial::Vector3& force,
                io::Json& json) {
  if (force.isZero()) return;
  const spatial::Vector3 along = force.normalized();
  const auto shares = vjm::spring_shares(robot.manipulator, posture, along);
  if (shares.empty()) return;
  json["yields"] = report::to_json(robot, shares);
  json["yields_along"] = "the force, " + report::direction_in_words(along);
}

io::Json deflect(const DeflectRequest& request, Run& run) {
  const vjm::Robot robot = request.posture.read();
  if (!request.load.given() && robot.manipulator.is_relaxed_when_unloaded())
    throw UsageError(
        "--wrench", "no load is given, and the robot has no weight",
        "Give --wrench Fx,Fy,Fz[,Mx,My,Mz], --node-load, or --move for a displacement");
  const vjm::Posture posture = request.posture.posture(robot);
  warn_beyond_ranges(robot, posture, run);
  if (request.method == "fixed-point") return by_fixed_point(request, robot, posture, run);
  vjm::Equilibrium equilibrium = request.load.solve(robot, posture);
  const vjm::SegmentCheck segments =
      check_segments(robot, request.posture, request.load, equilibrium);
  const auto uncertainty =
      request.uncertainty.of(robot, request.posture, posture, request.load, equilibrium, run);
  run.print(report::first_screen(robot, equilibrium, uncertainty) + report::text(robot, segments));
  run.print_more(fmt::format("\n{}\n", robot.name) + report::text(robot, posture) +
                 report::text(robot, equilibrium));
  io::Json picture = report::picture(robot.manipulator, posture, equilibrium);
  picture["load"] = load_picture(request, robot, equilibrium);
  run.draw(std::move(picture));
  stop_short_unless_stable(request.load, robot, equilibrium, run);
  io::Json json = report::inputs_and_posture(robot, posture);
  json["headline"] = report::headline(robot, equilibrium, uncertainty);
  add_yields(robot, posture, equilibrium.wrench.force, json);
  json["equilibrium"] = report::to_json(robot, equilibrium);
  if (uncertainty) json["uncertainty"] = report::deflection_json(*uncertainty);
  report::add_to(json, segments);
  if (!request.links.empty()) compare_deflections(request, robot, json, run);
  return json;
}

}  // namespace

void add_deflect(Program& program) {
  const auto request = std::make_shared<DeflectRequest>();
  OptionList app = program.add(
      {.name = "deflect",
       .summary = "Where a manipulator goes under a wrench, or what wrench holds a displacement",
       .example = "kinetostat deflect data/robots/orthoglide.yaml --at 0,0,0 --wrench 100,0,0"},
      [request](Run& run) { return deflect(*request, run); });
  request->posture.add_options(app);
  request->load.add_options(app);
  request->uncertainty.add_options(app);
  request->uncertainty.add_drawn_options(app);
  add_links_option(app, request->links);
  app.add_option("--method", request->method,
                 "newton, or fixed-point: the papers' iteration (MMT11 eq. 10-11), for comparison")
      .type_name("METHOD")
      .one_of({"newton", "fixed-point"});
}

}  // namespace kinetostat::apps

// kinetostat assemble: shift, internal loads and joint deflections of imperfect chains.
#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/robot_request.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/common/error.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/manipulators/skeleton.h"
#include "kinetostat/report/manipulators/uncertainty.h"
#include "kinetostat/report/screen/manipulator.h"
#include "kinetostat/vjm/statics/assembly.h"
#include "kinetostat/vjm/uncertainty/deflection_numbers.h"

namespace kinetostat::apps {
namespace {

struct AssembleRequest {
  PostureRequest posture;
  UncertaintyRequest uncertainty;
};

std::optional<vjm::Uncertainty> uncertainty_of(const AssembleRequest& request,
                                               const vjm::Robot& robot, const vjm::Posture& posture,
                                               Run& run) {
  const auto numbers = [&](const vjm::Robot& other) {
    const auto own = request.posture.posture_like(posture, robot, other);
    return own ? deflection_numbers(vjm::assemble(other.manipulator, *own).assembled)
               : std::nullopt;
  };
  return request.uncertainty.of(robot, numbers, run);
}

io::Json assemble(const AssembleRequest& request, Run& run) {
  const vjm::Robot robot = request.posture.read();
  if (!robot.manipulator.has_errors())
    throw common::InputError(robot.file, "no chain has a geometric error",
                             "Give a chain 'errors: [{at: JOINT, point: [1, 0, 0]}]'");
  const vjm::Posture posture = request.posture.posture(robot);
  const vjm::Assembly assembly = vjm::assemble(robot.manipulator, posture);
  run.print(report::first_screen(robot, assembly));
  std::optional<vjm::Uncertainty> uncertainty;
  if (assembly.assembled.status == vjm::EquilibriumStatus::converged)
    uncertainty = uncertainty_of(request, robot, posture, run);
  if (uncertainty) run.print(report::displacement_budget(robot, *uncertainty));
  run.print_more(fmt::format("\n{}\n", robot.name) + report::text(robot, posture) +
                 report::text(robot, assembly));
  run.draw(report::picture(robot.manipulator, posture, assembly.assembled, "nominal", "assembled"));
  if (assembly.assembled.status != vjm::EquilibriumStatus::converged)
    run.stop_short(assembly.assembled.reason);
  io::Json json = report::inputs_and_posture(robot, posture);
  json["headline"] = report::headline(robot, assembly);
  json["assembly"] = report::to_json(robot, assembly);
  if (uncertainty) json["uncertainty"] = report::deflection_json(*uncertainty);
  return json;
}

}  // namespace

void add_assemble(Program& program) {
  const auto request = std::make_shared<AssembleRequest>();
  OptionList app =
      program.add({.name = "assemble",
                   .summary = "Shift and internal loads of a manipulator with geometric errors",
                   .example = "kinetostat assemble data/robots/orthoglide_errors.yaml --at 0,0,0"},
                  [request](Run& run) { return assemble(*request, run); });
  request->posture.add_options(app);
  request->uncertainty.add_options(app);
}

}  // namespace kinetostat::apps

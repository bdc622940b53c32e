// kinetostat effect list, effect show: the catalogue of physical effects, and those of a robot
// file.
#include "kinetostat/report/effect.h"

#include <memory>
#include <optional>
#include <stdexcept>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/report/screen/effect.h"

namespace kinetostat::apps {
namespace {

struct EffectRequest {
  std::string name, robot_file;

  std::optional<vjm::Robot> robot() const {
    if (robot_file.empty()) return std::nullopt;
    return vjm::read_robot(robot_file);
  }
};

vjm::EffectKinds kinds_of(const std::optional<vjm::Robot>& robot) {
  return robot ? robot->kinds() : vjm::effect_kinds();
}

io::Json list_effects(const EffectRequest& request, Run& run) {
  const std::optional<vjm::Robot> robot = request.robot();
  io::Json kinds = io::Json::array();
  run.print(report::first_screen(kinds_of(robot)));
  run.print_more("\n");
  for (const auto& kind : kinds_of(robot)) {
    run.print_more(report::line(*kind));
    kinds.push_back(report::to_json(*kind));
    if (robot) kinds.back()["places"] = vjm::acting_places(kind, robot->without_effects());
  }
  return {{"effects", kinds}};
}

std::shared_ptr<const vjm::EffectKind> named(const std::string& name,
                                             const vjm::EffectKinds& kinds) {
  try {
    return vjm::effect_kind(name, kinds);
  } catch (const std::invalid_argument& error) {
    throw UsageError("NAME", error.what(),
                     "'kinetostat effect list' names the catalogue, 'effect list ROBOT.yaml' those "
                     "of a robot file as well");
  }
}

io::Json show_effect(const EffectRequest& request, Run& run) {
  const std::optional<vjm::Robot> robot = request.robot();
  const std::shared_ptr<const vjm::EffectKind> kind = named(request.name, kinds_of(robot));
  run.print(report::text(*kind));
  io::Json json{{"effect", report::to_json(*kind)}};
  if (robot) {
    run.print("\n" + report::places_text(kind, *robot));
    json["effect"]["places"] = vjm::acting_places(kind, robot->without_effects());
  }
  return json;
}

void add_robot(OptionList& app, EffectRequest& request) {
  app.add_option("ROBOT", request.robot_file,
                 "Robot file (YAML): its own effects as well, and where each can act");
}

}  // namespace

void add_effect_list(Program& program) {
  const auto request = std::make_shared<EffectRequest>();
  OptionList app = program.add({.name = "effect list",
                                .summary = "Physical effects that a robot file can have",
                                .example = "kinetostat effect list"},
                               [request](Run& run) { return list_effects(*request, run); });
  add_robot(app, *request);
}

void add_effect_show(Program& program) {
  const auto request = std::make_shared<EffectRequest>();
  OptionList app =
      program.add({.name = "effect show",
                   .summary = "Law, parameters and signature of one effect",
                   .example = "kinetostat effect show hardening data/robots/orthoglide.yaml"},
                  [request](Run& run) { return show_effect(*request, run); });
  app.add_option("NAME", request->name, "Name of the effect").required();
  add_robot(app, *request);
}

}  // namespace kinetostat::apps

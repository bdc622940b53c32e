// kinetostat import: a robot described in URDF, as a robot file to be completed.
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/manipulators/imported_robot.h"
#include "kinetostat/vjm/io/urdf.h"

namespace kinetostat::apps {
namespace {

struct ImportRequest {
  std::string urdf, base, tip, stiffness;
};

constexpr char stiffness_option[] = "--joint-stiffness";

double stiffness_of(const vjm::UrdfJoint& drive, const std::string& text) {
  const double value = quantity(stiffness_option, text,
                                vjm::turns(drive) ? spatial::dimension::torsional_stiffness
                                                  : spatial::dimension::linear_stiffness,
                                {});
  if (!(value > 0) || !std::isfinite(value))
    throw UsageError(stiffness_option, fmt::format("'{}' is no stiffness of {}", text, drive.name),
                     "Give a positive one, for example '5e4 N m/rad'");
  return value;
}

// One for all drives, or one for each.
std::vector<double> stiffnesses_of(const std::vector<vjm::UrdfJoint>& drives,
                                   const std::string& text) {
  const std::vector<std::string> parts = split(text);
  if (parts.size() != 1 && parts.size() != drives.size())
    throw UsageError(stiffness_option,
                     fmt::format("has {} values for {} drives", parts.size(), drives.size()),
                     "Give one for all, or one for each from base to tip");
  std::vector<double> result;
  for (std::size_t d = 0; d < drives.size(); ++d)
    result.push_back(stiffness_of(drives[d], parts[parts.size() == 1 ? 0 : d]));
  return result;
}

io::Json import(const ImportRequest& request, Run& run) {
  const vjm::UrdfModel model = vjm::read_urdf(request.urdf);
  const vjm::UrdfChain chain = vjm::find_chain(model, request.base, request.tip);
  vjm::ImportedRobot robot = vjm::import_robot(model, chain);
  if (!request.stiffness.empty())
    robot = vjm::import_robot(model, chain, stiffnesses_of(robot.drives, request.stiffness));
  if (run.out()) {
    io::write_atomically(*run.out(), robot.text);
    run.print(fmt::format("{}: '{}' to '{}', {} joints, written to {}\n", model.name, chain.base,
                          chain.tip, chain.joints.size(), run.out()->string()));
  } else {
    run.print(robot.text + "\n");
  }
  run.print(report::text(robot));
  return report::to_json(model, chain, robot);
}

}  // namespace

void add_import(Program& program) {
  const auto request = std::make_shared<ImportRequest>();
  OptionList app =
      program.add({.name = "import",
                   .summary = "A robot file from a URDF, with a list of what is missing",
                   .example = "kinetostat import data/urdf/six_axis.urdf --tip flange",
                   .out = "Write the robot file (YAML)"},
                  [request](Run& run) { return import(*request, run); });
  app.add_option("URDF", request->urdf, "URDF file (expanded, no xacro)").required();
  app.add_option("--base", request->base, "Link that does not move (default: the root)")
      .type_name("LINK");
  app.add_option("--tip", request->tip,
                 "Link that carries the tool (default: the only one without children)")
      .type_name("LINK");
  app.add_option(stiffness_option, request->stiffness,
                 "Stiffness of the drives, one for all or one for each from base to tip, separated "
                 "by commas: '5e4 N m/rad' (default: to be added by hand)")
      .type_name("STIFFNESS");
}

}  // namespace kinetostat::apps

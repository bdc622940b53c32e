// kinetostat export: a robot for simulators.
#include <memory>
#include <stdexcept>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/robot_request.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/vjm/io/mjcf_export.h"

namespace kinetostat::apps {
namespace {

vjm::MjcfExport exported(const vjm::Robot& robot, const vjm::Posture& posture) {
  try {
    return vjm::mjcf(robot, posture);
  } catch (const std::invalid_argument& error) {
    throw common::InputError(robot.file, error.what(),
                             "Take a serial robot, as data/robots/six_axis.yaml");
  }
}

io::Json export_robot(Run& run, const PostureRequest& request) {
  const vjm::Robot robot = request.read();
  const vjm::Posture posture = request.posture(robot);
  const vjm::MjcfExport made = exported(robot, posture);
  if (run.out()) {
    io::write_atomically(*run.out(), made.text);
    run.print(report::wrapped(robot.name + " for MuJoCo, written to " + run.out()->string() + "."));
    for (const std::string& what : made.lost)
      run.print(report::wrapped("not in it: " + what, 2, 4));
  } else {
    run.print(made.text);
  }
  io::Json json = report::inputs_and_posture(robot, posture);
  json["mjcf"] = made.text;
  json["lost"] = made.lost;
  return json;
}

}  // namespace

void add_export(Program& program) {
  const auto request = std::make_shared<PostureRequest>();
  OptionList app =
      program.add({.name = "export",
                   .summary = "A serial robot for MuJoCo, with the springs of its joints",
                   .example = "kinetostat export data/robots/six_axis.yaml -o six_axis.xml",
                   .out = "Write the MJCF file"},
                  [request](Run& run) { return export_robot(run, *request); });
  request->add_options(app);
}

}  // namespace kinetostat::apps

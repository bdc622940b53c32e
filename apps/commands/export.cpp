// kinetostat export: a robot for simulators.
#include <algorithm>
#include <functional>
#include <memory>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/robot_request.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/vjm/exchange/matlab_export.h"
#include "kinetostat/vjm/exchange/tree_export.h"

namespace kinetostat::apps {
namespace {

struct ExportRequest {
  PostureRequest robot;
  std::string format;
  double damping = 0;
};

struct Exported {
  std::string text;
  std::vector<std::string> lost;
};

// A format of serial robots, as trees of bodies.
struct TreeFormat {
  const char* name;       // of --format
  const char* extension;  // of the file
  const char* words;
  std::string (*write)(const vjm::BodyTree& tree);
  std::vector<std::string> (*lost)(const vjm::BodyTree& tree);
};
constexpr TreeFormat tree_formats[] = {
    {"mjcf", ".xml", "for MuJoCo (MJCF)", vjm::mjcf, vjm::lost_in_mjcf},
    {"urdf", ".urdf", "as URDF", vjm::urdf, vjm::lost_in_urdf},
    {"sdf", ".sdf", "for Gazebo (SDF)", vjm::sdf, vjm::lost_in_sdf},
    {"modelica", ".mo", "in Modelica", vjm::modelica, vjm::lost_in_modelica},
};
constexpr char matlab_name[] = "matlab";

// By --format, else by the extension of the file; MJCF where neither says.
std::string format_of(const ExportRequest& request, const Run& run) {
  if (!request.format.empty()) return request.format;
  if (!run.out()) return "mjcf";
  const std::string extension = run.out()->extension().string();
  if (extension == ".m") return matlab_name;
  for (const TreeFormat& format : tree_formats)
    if (extension == format.extension) return format.name;
  throw UsageError("--out", fmt::format("'{}' does not say the format", extension),
                   "End it with .xml (MJCF), .urdf, .sdf, .mo or .m, or add --format");
}

Exported tree_as(const TreeFormat& format, const vjm::Robot& robot, const vjm::Posture& posture,
                 double damping) try {
  const vjm::BodyTree tree = vjm::body_tree(robot, posture, {.damping_ratio = damping});
  return {format.write(tree), format.lost(tree)};
} catch (const std::invalid_argument& error) {
  throw common::InputError(robot.file, error.what(),
                           "Take a serial robot, as data/robots/six_axis.yaml, or MATLAB's "
                           "format (.m), which has any robot");
}

Exported exported(const std::string& format, const vjm::Robot& robot, const vjm::Posture& posture,
                  double damping) {
  for (const TreeFormat& tree : tree_formats)
    if (format == tree.name) return tree_as(tree, robot, posture, damping);
  return {vjm::matlab(robot, posture, damping), vjm::lost_in_matlab(robot, damping)};
}

std::string words_of(const std::string& format) {
  for (const TreeFormat& tree : tree_formats)
    if (format == tree.name) return tree.words;
  return "for MATLAB and GNU Octave";
}

io::Json export_robot(Run& run, const ExportRequest& request) {
  const std::string format = format_of(request, run);
  const vjm::Robot robot = request.robot.read();
  const vjm::Posture posture = request.robot.posture(robot);
  warn_beyond_ranges(robot, posture, run);
  const Exported made = exported(format, robot, posture, request.damping);
  if (run.out()) {
    io::write_atomically(*run.out(), made.text);
    run.print(report::wrapped(
        fmt::format("{} {}, written to {}.", robot.name, words_of(format), run.out()->string())));
    for (const std::string& what : made.lost)
      run.print(report::wrapped("not in it: " + what, 2, 4));
  } else {
    run.print(made.text);
  }
  io::Json json = report::inputs_and_posture(robot, posture);
  json.update({{"format", format}, {"text", made.text}, {"lost", made.lost}});
  return json;
}

}  // namespace

void add_export(Program& program) {
  const auto request = std::make_shared<ExportRequest>();
  OptionList app =
      program.add({.name = "export",
                   .summary = "A robot for simulators, with the springs of its joints",
                   .example = "kinetostat export data/robots/six_axis.yaml -o six_axis.xml",
                   .out = "Write the file: .xml (MJCF), .urdf, .sdf, .mo (Modelica), .m (MATLAB)"},
                  [request](Run& run) { return export_robot(run, *request); });
  request->robot.add_options(app);
  app.add_option("--format", request->format,
                 "mjcf, urdf, sdf, modelica or matlab (default: by the extension of the file)")
      .type_name("FORMAT")
      .one_of({"mjcf", "urdf", "sdf", "modelica", matlab_name});
  app.add_option("--damping", request->damping,
                 "Ratio to critical damping of the dampers beside the springs, each joint alone; "
                 "for matlab of every mode (default: none)")
      .type_name("RATIO")
      .between(0, 10)
      .hide_default();
}

}  // namespace kinetostat::apps

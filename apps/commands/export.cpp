// kinetostat export: a robot for simulators.
#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/results/simulator_file.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/screen/wording.h"

namespace kinetostat::apps {
namespace {

io::Json export_robot(Run& run, ExportRequest request) {
  request.file = run.out();
  const SimulatorFile file = simulator_file(request, run);
  if (run.out()) {
    io::write_atomically(*run.out(), file.text);
    run.print(
        report::wrapped(fmt::format("{}, written to {}.", file.headline, run.out()->string())));
    for (const std::string& what : file.lost)
      run.print(report::wrapped("not in it: " + what, 2, 4));
  } else {
    run.print(file.text);
  }
  return to_json(file);
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
      .one_of(simulator_formats());
  app.add_option("--damping", request->damping,
                 "Ratio to critical damping of the dampers beside the springs, each joint alone; "
                 "for matlab of every mode (default: none)")
      .type_name("RATIO")
      .between(0, 10)
      .hide_default();
}

}  // namespace kinetostat::apps

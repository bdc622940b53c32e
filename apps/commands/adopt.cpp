// kinetostat adopt, kinetostat revert: what a diagnosis found goes into the robot file, or out.
#include <memory>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/write_robot.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/results/adoption.h"
#include "kinetostat/calibration/diagnosis/adoption.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::apps {
namespace {

io::Json adopt(const AdoptRequest& request, const std::filesystem::path& out, Run& run) {
  const std::string before = io::read_text(request.robot);
  const Adopted adopted = write_adopted(request, out);
  run.draw({{"before", before}, {"after", adopted.text}});
  run.print(report::first_screen(
      vjm::read_robot(request.robot), adopted.summary,
      report::next_step(fmt::format("kinetostat compare {} CAMPAIGN", report::quoted(out)),
                        "the campaign that was diagnosed, again")));
  return adopted.result;
}

io::Json revert(const std::string& robot, Run& run) {
  std::string text;
  try {
    text = calibration::reverted(io::read_text(robot));
  } catch (const std::invalid_argument& error) {
    throw common::InputError({.file = robot, .what = error.what()});
  }
  const std::filesystem::path out = run.out() ? *run.out() : std::filesystem::path(robot);
  write_robot(out, text);
  run.print(fmt::format("{}: what was adopted last is taken out; the file is as it was before.\n",
                        out.string()));
  return {{"robot", out.string()}};
}

}  // namespace

void add_adopt(Program& program) {
  const auto request = std::make_shared<AdoptRequest>();
  OptionList app = program.add(
      {.name = "adopt",
       .summary = "Write what a diagnosis found and fitted into the robot file",
       .example = "kinetostat adopt data/robots/bench.yaml diagnosis.json -o better.yaml",
       .out = "Write the robot file there instead of changing it"},
      [request](Run& run) {
        return adopt(*request, run.out() ? *run.out() : std::filesystem::path(request->robot), run);
      });
  app.add_option("ROBOT", request->robot, "Robot file (YAML)").required();
  app.add_option("DIAGNOSIS", request->diagnosis, "What 'diagnose -o' wrote (JSON)").required();
  app.add_option("--effect", request->effect,
                 "One of the effects that were found, with the stiffnesses as they are (default: "
                 "all, with the stiffnesses that were fitted beside them)")
      .type_name("NAME");
  app.add_flag("--all", "All effects that were found (the default)").excludes("--effect");
  Option effects_only = app.add_flag("--effects-only", request->effects_only,
                                     "Leave stiffnesses as the robot file has them");
  app.add_flag("--stiffnesses-only", request->stiffnesses_only,
               "Write the stiffnesses that were fitted without any effect, and no effect")
      .excludes("--effect")
      .excludes(effects_only);
  app.add_flag("--force", request->force,
               "Adopt it although the held-out error does not fall, the verdict is that none of "
               "the catalogue explains the readings, or the robot file has changed");
}

void add_revert(Program& program) {
  const auto robot = std::make_shared<std::string>();
  OptionList app = program.add({.name = "revert",
                                .summary = "Take what was adopted last out of a robot file",
                                .example = "kinetostat revert better.yaml",
                                .out = "Write the robot file there instead of changing it"},
                               [robot](Run& run) { return revert(*robot, run); });
  app.add_option("ROBOT", *robot, "Robot file (YAML)").required();
}

}  // namespace kinetostat::apps

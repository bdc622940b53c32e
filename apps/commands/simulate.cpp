// kinetostat simulate: synthetic readings of a plan.
#include <memory>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/results/simulated_readings.h"
#include "kinetostat/report/simulation.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::apps {
namespace {

io::Json simulate(const std::string& file, const SimulateRequest& request, Run& run) {
  if (!run.out())
    throw UsageError("--out", "is missing", "Name a folder for campaign.yaml and readings.csv");
  const vjm::Robot robot = vjm::read_robot(file);
  const SimulatedReadings simulated = write_simulated_readings(robot, request, *run.out(), run);
  const report::Simulation result{robot, simulated.options, simulated.made, *run.out()};
  run.print(report::text(result));
  return report::to_json(result);
}

}  // namespace

void add_simulate(Program& program) {
  const auto request = std::make_shared<SimulateRequest>();
  const auto robot = std::make_shared<std::string>();
  OptionList app =
      program.add({.name = "simulate",
                   .summary = "Synthetic readings of a plan, with a stated noise",
                   .example = "kinetostat simulate data/robots/orthoglide.yaml --plan "
                              "data/measurements/plans/orthoglide.csv --noise-translation 5um "
                              "--noise-rotation 20urad --out synthetic",
                   .out = "Folder for campaign.yaml and readings.csv",
                   .out_is_folder = true},
                  [robot, request](Run& run) { return simulate(*robot, *request, run); });
  app.add_option("robot", *robot, "Robot file").type_name("ROBOT").required();
  app.add_option("--plan", request->plan,
                 "Readings to take, without displacements, in the robot file's units")
      .type_name("PLAN.csv");
  app.add_option("--like", request->like,
                 "Campaign file whose sensors, weights, units and noise are taken; without --plan "
                 "its rows as well")
      .type_name("CAMPAIGN");
  request->simulation.add_options(app);
}

}  // namespace kinetostat::apps

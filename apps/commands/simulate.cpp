// kinetostat simulate: synthetic readings of a plan.
#include <memory>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/simulation_request.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/simulation.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::apps {
namespace {

struct SimulateRequest {
  std::string robot, plan, like;
  SimulationRequest simulation;
};

// Simulated readings replace simulated ones, and no others: those cannot be had again.
void require_no_measurements(const std::filesystem::path& folder) {
  const std::filesystem::path campaign = folder / "campaign.yaml";
  if (std::filesystem::exists(campaign) &&
      io::read_text(campaign).find("\norigin: synthetic") != std::string::npos)
    return;
  for (const std::filesystem::path& file : {campaign, folder / "readings.csv"})
    if (std::filesystem::exists(file))
      throw common::InputError(file, "is there already, and was not made by 'simulate'",
                               "Name another folder with --out");
}

calibration::SimulatedCampaign simulated(const SimulateRequest& request, const vjm::Robot& robot,
                                         const std::filesystem::path& robot_name,
                                         const calibration::SimulationOptions& options, Run& run) {
  if (request.like.empty()) {
    if (request.plan.empty())
      throw UsageError("--plan", "is missing",
                       "Name a table of loads and postures, or a campaign with --like");
    return calibration::simulate(robot, robot_name.string(), request.plan, options, run.progress());
  }
  if (const std::string option = request.simulation.first_of_measuring(); !option.empty())
    throw UsageError(option, "is what the campaign of --like says",
                     "Leave it out, or change the campaign file");
  return calibration::simulate_like(
      robot, robot_name.string(), request.like,
      request.plan.empty() ? std::nullopt : std::optional<std::filesystem::path>(request.plan),
      options, run.progress());
}

io::Json simulate(const SimulateRequest& request, Run& run) {
  if (!run.out())
    throw UsageError("--out", "is missing", "Name a folder for campaign.yaml and readings.csv");
  const std::filesystem::path folder = *run.out();
  require_no_measurements(folder);
  const vjm::Robot robot = vjm::read_robot(request.robot);
  calibration::SimulationOptions options = request.simulation.options(robot);
  options.threads = run.threads();
  const std::filesystem::path named = std::filesystem::proximate(
      std::filesystem::absolute(robot.file), std::filesystem::absolute(folder));
  const calibration::SimulatedCampaign made = simulated(request, robot, named, options, run);
  for (const std::string& sentence : made.warnings) run.warn(sentence);
  const report::Simulation result{robot, options, made, folder};
  io::write_atomically(result.readings(), made.readings);
  io::write_atomically(result.campaign(), made.yaml);
  run.print(report::text(result));
  return report::to_json(result);
}

}  // namespace

void add_simulate(Program& program) {
  const auto request = std::make_shared<SimulateRequest>();
  OptionList app =
      program.add({.name = "simulate",
                   .summary = "Synthetic readings of a plan, with a stated noise",
                   .example = "kinetostat simulate data/robots/orthoglide.yaml --plan "
                              "data/measurements/plans/orthoglide.csv --noise-translation 5um "
                              "--noise-rotation 20urad --out synthetic",
                   .out = "Folder for campaign.yaml and readings.csv",
                   .out_is_folder = true},
                  [request](Run& run) { return simulate(*request, run); });
  app.add_option("robot", request->robot, "Robot file").type_name("ROBOT").required();
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

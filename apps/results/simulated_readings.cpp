#include "kinetostat/apps/results/simulated_readings.h"

#include <optional>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::apps {
namespace {

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

}  // namespace

SimulatedReadings write_simulated_readings(const vjm::Robot& robot, const SimulateRequest& request,
                                           const std::filesystem::path& folder, Run& run) {
  require_no_measurements(folder);
  calibration::SimulationOptions options = request.simulation.options(robot);
  options.threads = run.threads();
  const std::filesystem::path named = std::filesystem::proximate(
      std::filesystem::absolute(robot.file), std::filesystem::absolute(folder));
  calibration::SimulatedCampaign made = simulated(request, robot, named, options, run);
  for (const std::string& sentence : made.warnings) run.warn(sentence);
  io::write_atomically(folder / "readings.csv", made.readings);
  io::write_atomically(folder / "campaign.yaml", made.yaml);
  return {std::move(options), std::move(made)};
}

}  // namespace kinetostat::apps

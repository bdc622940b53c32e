// Synthetic readings in a folder, as `simulate` writes them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "kinetostat/apps/cli/simulation_request.h"
#include "kinetostat/calibration/regression/simulate.h"

namespace kinetostat::apps {

class Run;

/// The options of `simulate`.
struct SimulateRequest {
  std::string plan, like;  // files: a table of readings to take, a campaign; the one or both
  SimulationRequest simulation;
};

struct SimulatedReadings {
  calibration::SimulationOptions options;
  calibration::SimulatedCampaign made;
};

/// Simulates, and writes campaign.yaml and readings.csv into the folder, where the campaign names
/// the file of the robot. Throws UsageError; common::InputError for a folder with readings that
/// were not simulated, for mistakes in the plan or the campaign; common::NoConvergence.
SimulatedReadings write_simulated_readings(const vjm::Robot& robot, const SimulateRequest& request,
                                           const std::filesystem::path& folder, Run& run);

}  // namespace kinetostat::apps

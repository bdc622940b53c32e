// Synthetic readings that were written, for people and for programs.
#pragma once

#include <filesystem>
#include <string>

#include "kinetostat/calibration/regression/simulate.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

/// A simulated campaign, what it was made with, and the folder that holds its two files.
struct Simulation {
  const vjm::Robot& robot;
  const calibration::SimulationOptions& options;
  const calibration::SimulatedCampaign& made;
  std::filesystem::path folder;

  std::filesystem::path campaign() const { return folder / "campaign.yaml"; }
  std::filesystem::path readings() const { return folder / "readings.csv"; }
};

/// The hidden effects and how they show in these readings, where the files are, and what they do
/// not prove.
std::string text(const Simulation& simulation);
io::Json to_json(const Simulation& simulation);

}  // namespace kinetostat::report

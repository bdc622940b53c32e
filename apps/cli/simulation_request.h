// The options of simulated readings: what is measured, with what noise, and which effects act.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/apps/cli/option_list.h"
#include "kinetostat/calibration/regression/simulate.h"
#include "kinetostat/spatial/units.h"

namespace kinetostat::apps {

struct SimulationRequest {
  std::string translation_noise, rotation_noise, components;
  std::string force_noise, moment_noise, wrench_share;
  std::vector<std::string> effects, places, sizes;
  std::optional<spatial::UnitSystem> units_of_sizes = {};  // without a unit; none: the robot file's
  bool absolute = false;
  std::uint64_t seed = 1;

  /// The first option given that says what is measured, and how exactly; empty for none.
  std::string first_of_measuring() const;
  void add_options(OptionList& app);
  /// Throws UsageError. Threads are left to the caller.
  calibration::SimulationOptions options(const vjm::Robot& robot) const;
};

}  // namespace kinetostat::apps

// The readings that the product asks for, as rows of an experiment on a twin.
#pragma once

#include <filesystem>
#include <string>

#include "experiment.h"

namespace twin {

/// Reads the table of `kinetostat plan -o` for a robot of the twin: its columns of time [s],
/// posture [mm, deg] and force [N] at the platform's reference point. `session`: what its session
/// is called; temperatures follow the day of `random`. Throws std::runtime_error for a table that
/// the twin cannot measure, as one with moments.
Plan plan_of_table(const std::filesystem::path& file, const RobotSpec& robot,
                   const std::string& session, Random& random);

}  // namespace twin

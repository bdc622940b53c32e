// A robot that was imported from another format, for people and for programs.
#pragma once

#include <filesystem>
#include <string>

#include "kinetostat/io/json.h"
#include "kinetostat/vjm/exchange/robot_import.h"

namespace kinetostat::report {

/// What the description has and the robot file has not, and what that lacks.
std::string text(const vjm::RobotDescription& model, const vjm::ImportedRobot& robot);
/// The robot file, what it lacks, and from what it was made.
io::Json to_json(const vjm::RobotDescription& model, const vjm::DescribedChain& chain,
                 const vjm::ImportedRobot& robot);

}  // namespace kinetostat::report

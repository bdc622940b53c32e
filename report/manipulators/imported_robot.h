// A robot that was imported from URDF, for people and for programs.
#pragma once

#include <filesystem>
#include <string>

#include "kinetostat/io/json.h"
#include "kinetostat/vjm/io/urdf.h"

namespace kinetostat::report {

/// What the robot file lacks, since URDF knows no stiffness.
std::string text(const vjm::ImportedRobot& robot);
/// The robot file, what it lacks, and from what it was made.
io::Json to_json(const vjm::UrdfModel& model, const vjm::UrdfChain& chain,
                 const vjm::ImportedRobot& robot);

}  // namespace kinetostat::report

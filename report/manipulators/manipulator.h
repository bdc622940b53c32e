// Stiffness and equilibrium of a manipulator, for people and for programs.
#pragma once

#include <string>

#include "kinetostat/io/json.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/statics/assembly.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/fixed_point.h"
#include "kinetostat/vjm/statics/stiffness.h"

namespace kinetostat::report {

/// Platform pose and joint values, in the units of the robot file.
std::string text(const vjm::Robot& robot, const vjm::Posture& posture);
io::Json to_json(const vjm::Robot& robot, const vjm::Posture& posture);
/// The first keys of results in one posture: `inputs` and `posture`.
io::Json inputs_and_posture(const vjm::Robot& robot, const vjm::Posture& posture);

/// Stiffness, compliance, rank, free and rigid motions in words, rank of each chain; of the nominal
/// robot when its chains have geometric errors.
std::string text(const vjm::Robot& robot, const vjm::UnloadedStiffness& stiffness);
io::Json to_json(const vjm::Robot& robot, const vjm::UnloadedStiffness& stiffness);

/// Displacement, wrench, internal wrenches of the chains, tangent stiffness, stability, energy; or
/// the last equilibrium found and why there is none beyond.
std::string text(const vjm::Robot& robot, const vjm::Equilibrium& equilibrium);
io::Json to_json(const vjm::Robot& robot, const vjm::Equilibrium& equilibrium);

/// Where the papers' iteration came to rest, and the history of its changes.
std::string text(const vjm::Robot& robot, const vjm::Posture& posture,
                 const vjm::FixedPoint& fixed_point);
io::Json to_json(const vjm::Robot& robot, const vjm::Posture& posture,
                 const vjm::FixedPoint& fixed_point);

/// Shift of the platform, internal wrenches and what every joint and spring gives way by.
std::string text(const vjm::Robot& robot, const vjm::Assembly& assembly);
io::Json to_json(const vjm::Robot& robot, const vjm::Assembly& assembly);

/// Name, file and SHA-256 of the robot file and of the link files that it reads.
io::Json provenance(const vjm::Robot& robot);

}  // namespace kinetostat::report

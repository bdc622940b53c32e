// How a table of readings calls the coordinate of a joint.
#pragma once

#include <string>

#include "kinetostat/vjm/manipulator/manipulator.h"

namespace kinetostat::calibration {

/// "rho" for the joint "x.rho" where no other chain has one of that name and no other column is
/// called so; else as it is.
std::string joint_column(const vjm::Manipulator& manipulator, const std::string& joint);

}  // namespace kinetostat::calibration

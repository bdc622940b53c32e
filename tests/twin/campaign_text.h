// A campaign of a twin as the files that the product reads.
#pragma once

#include <filesystem>
#include <string>

#include "experiment.h"

namespace twin {

/// Writes campaign.yaml and readings.csv into a folder that is there. `read` and `noise` as in
/// experiment.h; `random` makes the covariates that mean nothing.
void write_campaign(const std::string& name, const RobotSpec& robot, const Plan& plan,
                    const Eigen::Matrix<double, 6, Eigen::Dynamic>& read,
                    const Eigen::Matrix<double, 6, Eigen::Dynamic>& noise, Random& random,
                    const std::filesystem::path& folder);
/// Throws std::runtime_error when it cannot.
void write_text(const std::filesystem::path& path, const std::string& text);

}  // namespace twin

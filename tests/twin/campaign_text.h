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
/// The readings of a further session behind those of the campaign in `from`, which has the same
/// columns, into `folder`; poses after differences are a campaign of their own. `known_loads`: the
/// session was loaded by known weights.
void add_session(const std::filesystem::path& from, bool known_loads, const RobotSpec& robot,
                 const Plan& plan, const Eigen::Matrix<double, 6, Eigen::Dynamic>& read,
                 const Eigen::Matrix<double, 6, Eigen::Dynamic>& noise, Random& random,
                 const std::filesystem::path& folder);
/// Throws std::runtime_error when it cannot.
void write_text(const std::filesystem::path& path, const std::string& text);

}  // namespace twin

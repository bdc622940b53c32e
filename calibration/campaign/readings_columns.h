// Which columns of a table of readings mean what. Internal to this module.
#pragma once

#include <set>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/campaign/readings_context.h"
#include "kinetostat/io/csv.h"

namespace kinetostat::calibration {

using Column = std::optional<std::size_t>;  // index in the table
using Columns3 = std::array<Column, 3>;

/// A column of the coordinate of one joint.
struct JointColumn {
  std::size_t column = 0;
  std::string joint;  // "chain.joint"
  spatial::Dimension dimension;
};

/// Columns that have a meaning; unset where there is no such column.
struct ReadingsColumns {
  std::map<std::string, Column, std::less<>> texts;  // id, session, ... by name
  std::array<Column, 6> displacement, sigma, wrench;
  Column any_sigma;
  std::vector<std::pair<std::pair<Eigen::Index, Eigen::Index>, std::size_t>> correlations;
  Columns3 point, position, orientation;  // all three or none
  std::vector<JointColumn> joints;
  std::set<std::size_t> known;  // all of the above; the others are covariates
};

/// Finds them and checks that they make sense together, with the context and with the units of the
/// campaign; adds to its notes what is assumed. Throws common::InputError naming the column.
ReadingsColumns find_columns(const io::CsvTable& table, const ReadingsContext& context,
                             const vjm::Manipulator& manipulator, Campaign& campaign);

}  // namespace kinetostat::calibration

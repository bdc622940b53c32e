// Which columns of a table of readings mean what. Internal to this module.
#pragma once

#include <algorithm>
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
  std::vector<Column> displacement, sigma;           // one a component of the campaign
  std::array<Column, 6> wrench;
  std::vector<Column> loads;  // beside the wrench, in the order of load_columns()
  Column any_sigma;
  std::vector<std::pair<std::pair<Eigen::Index, Eigen::Index>, std::size_t>> correlations;
  Columns3 point, position, orientation;  // all three or none
  std::vector<JointColumn> joints;
  std::set<std::size_t> known;  // all of the above; the others are covariates
  /// Of every column of the table: how its name was understood, and what one of its numbers is
  /// worth in SI, less than zero where it counts the other way round.
  std::vector<NamedColumn> names;
  std::vector<double> factors;
  std::vector<spatial::Dimension> dimensions;
  std::set<std::size_t> unknown_units;  // of columns that look like readings and state none

  bool has_displacement() const {
    return std::any_of(displacement.begin(), displacement.end(),
                       [](const Column& c) { return c.has_value(); });
  }
};

/// Finds them and checks that they make sense together, with the context and with the units of the
/// campaign; adds to its notes and warnings what is assumed, and to `faults` what is wrong. Takes
/// the platform out of what `campaign` reads where other sensors are read and it has no column.
ReadingsColumns find_columns(const io::CsvTable& table, const ReadingsContext& context,
                             const vjm::Manipulator& manipulator, Campaign& campaign,
                             common::Faults& faults);

/// The unit of a column whose values have a dimension: its own, else that of the campaign.
std::string unit_of_column(const NamedColumn& column, const spatial::Dimension& dimension,
                           const spatial::UnitSystem& units);

}  // namespace kinetostat::calibration

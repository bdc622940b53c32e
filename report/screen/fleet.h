// Many robots, or one robot over years: what was found and fitted, over date and serial number.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/diagnosis/diagnosis_record.h"
#include "kinetostat/calibration/statistics/control_chart.h"
#include "kinetostat/io/json.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::report {

/// A value of one robot at one time [SI], with its standard deviation, NaN where that is not known.
struct FleetValue {
  std::string name;  // "gap of clearance at q3", "stiffness of q1, factor"
  std::string unit;
  double value = 0, deviation = 0;
};

struct FleetMember {
  std::string serial, date, file;  // the date as ISO 8601 has it, or empty
  std::vector<FleetValue> values;
};

/// What a diagnosis found and fitted.
std::vector<FleetValue> fleet_values(const calibration::DiagnosisRecord& diagnosis);
/// What a robot file holds of that: its effects, and `fitted`.
std::vector<FleetValue> fleet_values(const vjm::Robot& robot);

/// One quantity over those that have it, in their order.
struct FleetSeries {
  std::string name, unit;
  std::vector<std::size_t> members;
  std::vector<double> values, deviations;
  calibration::ControlChart chart;
};

/// Fewer values of a quantity have no limits.
inline constexpr std::size_t least_of_series = 3;

struct Fleet {
  std::string name;
  std::vector<FleetMember> members;  // by date, then serial number
  std::vector<FleetSeries> series;   // in the order in which they are met
  std::size_t baseline = 0;
};

/// In order, with its charts (individuals_chart).
Fleet make_fleet(std::string name, std::vector<FleetMember> members, std::size_t baseline);

/// Whose values lie outside their limits, in a sentence.
std::string headline(const Fleet& fleet);
/// The same one by one, and a table of all quantities.
std::string text(const Fleet& fleet);
/// SI.
io::Json to_json(const Fleet& fleet);

}  // namespace kinetostat::report

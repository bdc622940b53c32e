// How a table of readings is understood, column by column, before anything is fitted.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/common/faults.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::calibration {

/// What is known of a table beside the table itself.
struct ReadingsRequest {
  std::filesystem::path table;                      // CSV or spreadsheet
  std::map<std::string, std::string> columns = {};  // as `columns:` of a campaign file
  std::map<std::string, std::string> units = {};    // of columns without one: "length" -> "mm"
  std::optional<DisplacementKind> displacement = {};
  std::string sheet = {};  // of a spreadsheet
};

struct ColumnOverview {
  std::string header;
  std::string meaning;                  // "fx", "arm.q1"; empty for a covariate
  std::string words;                    // the same for people: "force along x"
  std::string unit = {};                // of its numbers; empty for texts, counts and clock times
  bool negative = false;                // counted the other way round
  std::size_t values = 0, missing = 0;  // cells
  std::optional<std::array<double, 2>> range = {};  // least and largest number, as in the table
  std::string first = {}, last = {};                // of cells that are no numbers
  std::size_t different = 0;                        // of these
  std::string meant = {};  // a covariate that looks like a reading: what to write under `columns:`
};

/// A sensor elsewhere than at the platform that columns look like.
struct ProposedSensor {
  std::string name, kind;
  std::string joint = {};                 // of kinds that read one
  std::vector<std::string> columns = {};  // their headers, one an axis
  std::string axes = {};                  // "xz", where the columns name them
};

struct ReadingsOverview {
  std::filesystem::path table;
  std::size_t rows = 0, header_line = 1;
  std::vector<ColumnOverview> columns = {};
  std::vector<std::string> notes = {};
  std::vector<common::InputError::Details> mistakes = {};  // what keeps it from being used
  std::map<std::string, std::string> stated = {};          // `columns:` as asked for or guessed
  std::map<std::string, std::string> units = {};           // as asked for
  DisplacementKind displacement = DisplacementKind::difference;
  std::vector<ProposedSensor> sensors = {};
  bool sensors_only = false;             // nothing is read at the platform: they are taken as read
  std::vector<std::string> places = {};  // parts of the robot that can carry one
  bool needs_wrench_point = false;       // moments without a point
  bool has_wrench = false;
  std::vector<std::string> weights = {};  // columns of masses that may hang on the robot
  std::string sheet = {};                 // where the workbook has several with tables
  Occasion occasion = {};                 // as the lines above the header say plainly
};

/// Looks at a table by itself. `robot` says which columns are joints; without one none is. Throws
/// common::InputError when there is no table at all.
ReadingsOverview look_at_readings(const ReadingsRequest& request, const vjm::Robot* robot);

/// Looks at the readings of a campaign file.
ReadingsOverview look_at_campaign(const std::filesystem::path& campaign, const vjm::Robot& robot);

/// The campaign file that says so, in a line each; proposed sensors as comments where the platform
/// is read as well, else with WHERE in place of what people have to fill in; masses that hang on
/// the platform, as comments where other loads are stated. `robot` and `readings` are the names of
/// the files as it shall name them.
std::string campaign_text(const ReadingsOverview& overview, const std::string& name,
                          const std::string& robot, const std::string& readings,
                          const spatial::UnitSystem& units);

}  // namespace kinetostat::calibration

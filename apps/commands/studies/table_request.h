// A table of readings, and what is said of it beside it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_list.h"
#include "kinetostat/calibration/campaign/readings_overview.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::apps {

inline constexpr char drafted_campaign_name[] = "campaign.yaml";

struct TableRequest {
  std::string file, units, displacement, sheet, noise;
  std::vector<std::string> columns;

  /// --column, --units, --displacement, --sheet, --noise.
  void add_options(OptionList& app);
  /// Whether one of them was given.
  bool says_something() const;
  /// Throws UsageError for what is not understood, common::InputError where there is no table.
  calibration::ReadingsOverview look(const vjm::Robot* robot) const;
};

/// The campaign file `out` for a table as it was understood; its names of files are as seen from
/// the folder of `out`. Without `robot` it names none. Throws UsageError where --noise is no
/// length.
std::string drafted_campaign(const TableRequest& request,
                             const calibration::ReadingsOverview& overview, const vjm::Robot* robot,
                             const std::filesystem::path& out);

/// The same as a file of `folder`. Edited since it was made, it is left as it is, and
/// that is said. Throws common::InputError for all that cannot be used of the table, for sensors of
/// which it does not say what carries them, and where an edited file would be made otherwise now.
std::filesystem::path keep_drafted_campaign(const TableRequest& request,
                                            const calibration::ReadingsOverview& overview,
                                            const vjm::Robot& robot,
                                            const std::filesystem::path& folder, const Run& run);

}  // namespace kinetostat::apps

// Studies: of readings and the model that is to explain them, and of a robot without readings.
#pragma once

#include <filesystem>

#include "kinetostat/apps/cli/campaign_request.h"
#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/diagnosis_steps.h"
#include "kinetostat/calibration/campaign/readings_overview.h"

namespace kinetostat::apps {

/// Check, compare, diagnose, adopt, compare again, plan: into `folder`, with a page. Steps that are
/// there and were made of the same files are not made again. `table` is how the table was
/// understood that the campaign file was made from, if it was.
io::Json study_readings(const CampaignRequest& campaign, const std::filesystem::path& folder,
                        const KeptFits& kept, Run& run,
                        const calibration::ReadingsOverview* table = nullptr);

/// Stiffness at home and what yields there, the same about home, the critical force, internal loads
/// of chains that do not close: into `folder`, with a page. Throws common::NoConvergence where the
/// robot cannot stand at home.
io::Json study_design(const std::filesystem::path& file, const std::filesystem::path& folder,
                      Run& run);

}  // namespace kinetostat::apps

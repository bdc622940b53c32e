// Studies: of readings and the model that is to explain them, and of a robot without readings.
#pragma once

#include <filesystem>

#include "kinetostat/apps/cli/campaign_request.h"
#include "kinetostat/apps/cli/command.h"

namespace kinetostat::apps {

/// Check, compare, diagnose, adopt, compare again, plan: into `folder`, with a page. Steps that are
/// there and were made of the same files are not made again.
io::Json study_readings(const CampaignRequest& campaign, const std::filesystem::path& folder,
                        bool no_cache, Run& run);

/// Stiffness at home and what yields there, the same about home, the critical force, internal loads
/// of chains that do not close: into `folder`, with a page. Throws common::NoConvergence where the
/// robot cannot stand at home.
io::Json study_design(const std::filesystem::path& file, const std::filesystem::path& folder,
                      Run& run);

}  // namespace kinetostat::apps

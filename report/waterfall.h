// The falling error as a table, and for programs.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/comparison/before_after.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

/// The name of a stage for people: JSON's "as designed" is "nominal", its "refitted" is "fitted".
std::string stage_in_words(std::string name);
/// One row a stage, in the units of the campaign. `held_out`: "configurations". Empty without any.
std::string waterfall_text(const calibration::Campaign& campaign,
                           const std::vector<calibration::WaterfallStage>& stages,
                           const std::string& held_out);
/// SI.
io::Json to_json(const calibration::WaterfallStage& stage);
io::Json to_json(const std::vector<calibration::WaterfallStage>& stages);

std::string text(const calibration::Campaign& campaign, const calibration::BeforeAfter& both);
/// Both comparisons whole, and the stages.
io::Json to_json(const calibration::Campaign& campaign, const calibration::BeforeAfter& both);

}  // namespace kinetostat::report

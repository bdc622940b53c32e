// What readings can and cannot show, for people and for programs.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/campaign_check.h"
#include "kinetostat/calibration/campaign/joint_loads.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

/// Name of the campaign, and what its file says of date, operator, instrument and serial number.
io::Json occasion_json(const calibration::Campaign& campaign);

/// Size and notes of the campaign, then two lists: observable, not observable.
std::string text(const calibration::Campaign& campaign,
                 const std::vector<calibration::Observability>& checks);
io::Json to_json(const calibration::Campaign& campaign,
                 const std::vector<calibration::Observability>& checks,
                 const std::vector<calibration::JointLoad>& joints);

}  // namespace kinetostat::report

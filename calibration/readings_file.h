// The table of readings of a campaign. Internal to this room: campaign.h is what others use.
#pragma once

#include "kinetostat/calibration/campaign.h"
#include "kinetostat/files/csv.h"

namespace kinetostat::calibration {

/// What the campaign file says about its readings.
struct ReadingsContext {
  spatial::Vector6 noise;  // standard deviation [m; rad] of the instrument; NaN where not stated
  std::optional<spatial::Vector3> wrench_point;    // on the platform, platform axes [m]
  bool angle_stated = false, time_stated = false;  // units that the campaign file names
};

/// Fills readings, configurations, sessions, covariates, noise_stated and notes of `campaign`,
/// whose other members are set. Throws files::InputError.
void read_readings(const files::CsvTable& table, const ReadingsContext& context,
                   const vjm::Manipulator& manipulator, Campaign& campaign);

}  // namespace kinetostat::calibration

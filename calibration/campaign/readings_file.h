// The table of readings of a campaign. Internal to this module: campaign_file.h is what others use.
#pragma once

#include "kinetostat/calibration/campaign/readings_context.h"
#include "kinetostat/io/csv.h"

namespace kinetostat::calibration {

/// Fills readings, configurations, sessions, covariates, noise_stated and notes of `campaign`,
/// whose other members are set. Throws common::InputError: of all mistakes at once, with those that
/// were found when the table was read.
void read_readings(const io::CsvTable& table, const ReadingsContext& context,
                   const vjm::Manipulator& manipulator, Campaign& campaign,
                   common::Faults faults = {});

}  // namespace kinetostat::calibration

// How exact the unloaded readings are that differences are counted from, as far as the readings
// themselves show it.
#pragma once

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/campaign/noise.h"
#include "kinetostat/common/progress.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::calibration {

/// `noise` with datums as exact as the readings show them to be, where their noise is not stated.
/// Their variance is v times that of a reading, v = usual_datum_variance / 2^k: the largest for
/// which the restricted likelihood (Harville, J. Am. Stat. Assoc. 72, 1977) is no less than a tenth
/// of the greatest, so that in doubt it stays what is usual, and never more. That likelihood is of
/// a model that does not depend on what was found or fitted before: the robot without effects, its
/// uncertain stiffnesses free, and a drift of each session and component with time and with
/// temperature; where it leaves more than 1.5 times the noise, what is missing would be taken for
/// noise of single readings, and datums stay as they are. A noise that is estimated from replicates
/// is estimated once more beside these datums. Of tables longer than `most_for_datums`, and where
/// that model cannot be fitted, the noise stays as it is.
Noise with_datums_seen(Noise noise, const vjm::Robot& robot, const Campaign& campaign, int threads,
                       common::Progress& progress);

/// Readings: beyond these the usual noise costs little, as the datums are many.
inline constexpr std::size_t most_for_datums = 5000;

}  // namespace kinetostat::calibration

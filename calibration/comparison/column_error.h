// Readings whose columns are not what their names say: signs, exchanged axes, zero offsets
// of joints.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/common/progress.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::calibration {

/// Sentence about one column error that would make most of the misfit of a campaign: axes of the
/// displacement or of the force with another sign or in another order, one in another unit, a joint
/// that counts the other way or from another zero, joints exchanged or in other units, axes of the
/// platform, rotations in arc seconds or microradians (unit_error.h). Empty where none leaves less
/// than a fifth of what the readings vary by, up to a common factor, and less than a third of what
/// is left as the files are. Of the platform's translations, about their means in each session;
/// from the frame that fits best where nobody knows where the instrument stands. Nothing is said of
/// displacements that were set. `predicted`: by the nominal model, one a reading [m; rad].
std::string column_error(const vjm::Robot& robot, const Campaign& campaign,
                         const std::vector<Eigen::VectorXd>& predicted, int threads,
                         common::Progress& progress);

}  // namespace kinetostat::calibration

// Readings whose columns are not what their names say: signs, exchanged axes, zero offsets
// of joints.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/common/progress.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::calibration {

/// Sentence about one column error of a campaign that would make most of its misfit: axes of
/// the displacement or of the force with another sign or in another order, a joint that counts the
/// other way or from another zero, joints in other units. Empty where none leaves less than a third
/// of what the readings vary by beside the predictions, up to a common factor, or where that is
/// more than a fifth. Translations of the platform where they are read, about their means in each
/// session; from the frame that fits best where nobody knows where the instrument stands.
/// `predicted`: by the nominal model, one a reading [m; rad].
std::string column_error(const vjm::Robot& robot, const Campaign& campaign,
                         const std::vector<Eigen::VectorXd>& predicted, int threads,
                         common::Progress& progress);

/// What unit_error() says; where that is nothing, column_error().
std::string unit_or_column_error(const vjm::Robot& robot, const Campaign& campaign,
                                 const std::vector<Eigen::VectorXd>& predicted, int threads,
                                 common::Progress& progress);

}  // namespace kinetostat::calibration

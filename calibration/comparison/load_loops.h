// Closed load cycles: the work they lose, and whether the robot comes back.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/campaign/noise.h"

namespace kinetostat::calibration {

/// A test over all load cycles together, against the noise; Holm-corrected with the others.
struct LoopTest {
  double statistic = 0;  // chi-square, or F times its first degrees of freedom
  Eigen::Index degrees_of_freedom = 0;
  Eigen::Index degrees_of_freedom_noise = 0;  // 0: the noise is stated
  double p_value = 1, holm_p_value = 1;
};

/// One closed load cycle.
struct Loop {
  std::string session, cycle;
  double measured = 0, predicted = 0;  // work lost in the cycle [J]
  std::optional<double> noise = {};    // standard deviation of `measured` [J], when known
  std::optional<Eigen::VectorXd> return_to_zero = {};  // last minus first residual without load
};

struct LoadLoops {
  std::vector<Loop> each;
  std::optional<LoopTest> area;            // that measured areas are the predicted ones
  std::optional<LoopTest> return_to_zero;  // that residuals without load are the same afterwards
};

/// Loops of all load cycles at one posture that end at the load at which they started. `residual`
/// [m; rad] and `work` (BaseFit), one entry a reading.
LoadLoops find_loops(const Campaign& campaign, const std::vector<Eigen::VectorXd>& residual,
                     const std::vector<spatial::Vector6>& work, const Noise& noise);

}  // namespace kinetostat::calibration

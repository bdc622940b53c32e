// Factors on which residuals may depend: posture, load, branch, session, time and whatever else the
// table has.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"

namespace kinetostat::calibration {

/// A factor on which a residual may depend: a group for every reading (-1: not known), or a number.
struct Factor {
  std::string name;                 // "posture", "reach", ..., or that of a covariate
  std::vector<int> group;           // of each reading
  std::vector<std::string> labels;  // of each group
  std::vector<double> number = {};  // of each reading; empty where it is a matter of groups
  bool along_load = false;          // residuals are to be counted along the load
};

/// All of a campaign, in a fixed order. Their groups and numbers do not depend on the order of rows
/// or on units, but for the labels.
std::vector<Factor> factors_of(const Campaign& campaign);

}  // namespace kinetostat::calibration

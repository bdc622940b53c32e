// Observability: the effects that the readings of a campaign can and cannot show, stated before
// anything is fitted.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::calibration {

/// One question that people ask of readings, and whether these can answer it.
struct Observability {
  std::string topic;  // "noise", "nonlinearity", ...: fixed words, for programs
  bool observable = false;
  std::string sentence;     // with the figures, and for what is missing: what to measure
  std::string effect = {};  // class of effects that it is about, in a few words
  std::string cure = {};    // what to measure where it is not observable, in a few words
};

/// In a fixed order. Looks at loads, postures, order and columns only, never at residuals; the same
/// for any order of rows and any units.
std::vector<Observability> check_campaign(const Campaign& campaign, const vjm::Robot& robot);

}  // namespace kinetostat::calibration

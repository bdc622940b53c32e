// The robot and the campaign that a command is about.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_list.h"
#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/statistics/least_squares.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::apps {

/// [ROBOT] CAMPAIGN: the robot of the command line wins over the one that the campaign names, and
/// that is said.
struct CampaignRequest {
  std::vector<std::string> files;

  void add_options(OptionList& app);
  /// Throws common::InputError when neither names a robot.
  vjm::Robot read_robot() const;
  /// Warns of columns that may be meant otherwise.
  calibration::Campaign read_campaign(const vjm::Robot& robot, const Run& run) const;
  /// The files as they were typed, for a shell.
  std::string typed() const;
};

/// --robust: huber or cauchy.
void add_robust_option(OptionList& app, std::string& robust);
/// Squares unless one of these is given.
calibration::Loss loss_of(const std::string& robust);

/// That another robot than the campaign's is used, in a sentence; empty where it is the same.
std::string robot_replaced(const vjm::Robot& robot, const calibration::Campaign& campaign);
/// The same under `robot_replaced`, where it is so.
void add_robot_replaced(const vjm::Robot& robot, const calibration::Campaign& campaign,
                        io::Json& json);
/// Prints it, and with --verbose the robot's name.
void say_which_robot(const vjm::Robot& robot, const calibration::Campaign& campaign, Run& run);

}  // namespace kinetostat::apps

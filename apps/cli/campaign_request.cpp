#include "kinetostat/apps/cli/campaign_request.h"

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/common/error.h"
#include "kinetostat/report/screen/wording.h"

namespace kinetostat::apps {

void CampaignRequest::add_options(OptionList& app) {
  app.add_option("files", files,
                 "Robot file (may be left out when the campaign names it) and campaign file")
      .type_name("[ROBOT] CAMPAIGN")
      .required()
      .count(1, 2);
}

vjm::Robot CampaignRequest::read_robot() const {
  if (files.size() == 2) return vjm::read_robot(files.front());
  const std::filesystem::path campaign = files.back();
  if (const auto robot = calibration::robot_named_in(campaign)) return vjm::read_robot(*robot);
  throw kinetostat::common::InputError(
      {.file = campaign,
       .key = "robot",
       .what = "the campaign names no robot file",
       .cure = "Add 'robot: FILE', or name it on the command line before the "
               "campaign"});
}

calibration::Campaign CampaignRequest::read_campaign(const vjm::Robot& robot,
                                                     const Run& run) const {
  calibration::Campaign campaign = calibration::read_campaign(files.back(), robot.manipulator);
  for (const std::string& sentence : campaign.warnings) run.warn(sentence);
  return campaign;
}

std::string CampaignRequest::typed() const {
  std::string text;
  for (const std::string& file : files) text += (text.empty() ? "" : " ") + report::quoted(file);
  return text;
}

void add_robust_option(OptionList& app, std::string& robust) {
  app.add_option("--robust", robust,
                 "Fit with a loss that outliers move less: huber (95 % efficient, one minimum) or "
                 "cauchy (far outliers hardly count)")
      .type_name("LOSS")
      .one_of({"huber", "cauchy"});
}

calibration::Loss loss_of(const std::string& robust) {
  if (robust == "huber") return calibration::Loss::huber;
  return robust == "cauchy" ? calibration::Loss::cauchy : calibration::Loss::squares;
}

std::string robot_replaced(const vjm::Robot& robot, const calibration::Campaign& campaign) {
  if (!campaign.robot) return {};
  const std::filesystem::path named = campaign.file.parent_path() / *campaign.robot;
  std::error_code error;
  if (std::filesystem::equivalent(named, robot.file, error) && !error) return {};
  return fmt::format("The campaign names the robot '{}'; '{}' of the command line is used instead.",
                     campaign.robot->string(), robot.file.string());
}

void add_robot_replaced(const vjm::Robot& robot, const calibration::Campaign& campaign,
                        io::Json& json) {
  const std::string sentence = robot_replaced(robot, campaign);
  if (!sentence.empty()) json["robot_replaced"] = sentence;
}

void say_which_robot(const vjm::Robot& robot, const calibration::Campaign& campaign, Run& run) {
  run.print_more(fmt::format("Robot '{}'\n", robot.name));
  const std::string sentence = robot_replaced(robot, campaign);
  if (!sentence.empty()) run.print(sentence + "\n");
}

}  // namespace kinetostat::apps

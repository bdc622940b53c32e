// kinetostat measure check: what readings can and cannot show, before anything is fitted.
#include <memory>

#include "kinetostat/apps/cli/campaign_request.h"
#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/campaign/joint_loads.h"
#include "kinetostat/report/campaign_check.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/screen/comparison.h"
#include "kinetostat/report/screen/wording.h"

namespace kinetostat::apps {
namespace {

io::Json check_measurements(const CampaignRequest& request, Run& run) {
  const vjm::Robot robot = request.read_robot();
  const calibration::Campaign campaign = request.read_campaign(robot, run);
  const auto checks = calibration::check_campaign(campaign, robot);
  const auto joints = calibration::joint_loads(campaign, robot.without_effects());
  io::Json json{{"headline", report::readings_in_words(campaign, checks)},
                {"inputs", report::provenance(robot)}};
  add_robot_replaced(robot, campaign, json);
  say_which_robot(robot, campaign, run);
  run.print(report::first_screen(
      campaign, checks, joints,
      report::next_step("kinetostat compare " + request.typed(), "where does the model fail?")));
  run.print_more("\n" + report::text(campaign, checks) + report::joints_text(joints));
  json.update(report::to_json(campaign, checks, joints));
  return json;
}

}  // namespace

void add_measure_check(Program& program) {
  const auto request = std::make_shared<CampaignRequest>();
  OptionList app =
      program.add({.name = "measure check",
                   .summary = "Say what is observable in readings and what is not, before any fit",
                   .example = "kinetostat measure check "
                              "data/measurements/nist_load_cell/campaign.yaml"},
                  [request](Run& run) { return check_measurements(*request, run); });
  request->add_options(app);
}

}  // namespace kinetostat::apps

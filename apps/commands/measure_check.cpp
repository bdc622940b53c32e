// kinetostat measure check: what readings can and cannot show, before anything is fitted.
#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/cli/campaign_request.h"
#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/calibration/campaign/campaign_check.h"
#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/report/manipulator.h"

namespace kinetostat::apps {
namespace {

std::string listed(const std::vector<calibration::Observability>& all, bool observable) {
  std::string text;
  for (const calibration::Observability& item : all)
    if (item.observable == observable) text += "  - " + item.sentence + "\n";
  return text;
}

io::Json check(const CampaignRequest& request, Run& run) {
  const vjm::Robot robot = request.read_robot();
  const calibration::Campaign campaign = request.read_campaign(robot, run);
  const auto all = calibration::check_campaign(campaign, robot);
  io::Json json{{"inputs", report::provenance(robot)}};
  say_which_robot(robot, campaign, json, run);
  run.print(fmt::format("Campaign '{}': {} readings\n", campaign.name, campaign.readings.size()));
  for (const std::string& note : campaign.notes) run.print("  " + note + "\n");
  run.print("\nObservable\n" + listed(all, true));
  run.print("\nNot observable\n" + listed(all, false));
  json["campaign"] = campaign.name;
  json["readings"] = campaign.readings.size();
  json["notes"] = campaign.notes;
  json["checks"] = io::Json::array();
  for (const calibration::Observability& item : all)
    json["checks"].push_back(
        {{"topic", item.topic}, {"observable", item.observable}, {"sentence", item.sentence}});
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
                  [request](Run& run) { return check(*request, run); });
  request->add_options(app);
}

}  // namespace kinetostat::apps

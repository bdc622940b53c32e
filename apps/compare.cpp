// kinetostat compare: a model against measurements.
#include "kinetostat/calibration/compare.h"

#include <memory>

#include "kinetostat/apps/campaign_request.h"
#include "kinetostat/apps/command.h"
#include "kinetostat/apps/commands.h"
#include "kinetostat/files/text_file.h"
#include "kinetostat/report/comparison.h"
#include "kinetostat/report/manipulator.h"
#include "kinetostat/report/readings_picture.h"

namespace kinetostat::apps {
namespace {

struct CompareRequest {
  CampaignRequest campaign;
  std::string csv, robust;
};

calibration::Loss loss_of(const std::string& name) {
  if (name == "huber") return calibration::Loss::huber;
  return name == "cauchy" ? calibration::Loss::cauchy : calibration::Loss::squares;
}

files::Json compare(const CompareRequest& request, Run& run) {
  const vjm::Robot robot = request.campaign.read_robot();
  const calibration::Campaign campaign = request.campaign.read_campaign(robot);
  const calibration::Comparison comparison =
      calibration::compare(robot, campaign, run.threads(), run.progress(), loss_of(request.robust));
  files::Json json{{"inputs", report::provenance(robot)}};
  say_which_robot(robot, campaign, json, run);
  run.print(report::text(campaign, comparison));
  json.update(report::to_json(campaign, comparison));
  if (!request.csv.empty())
    files::write_atomically(request.csv, report::residual_table(campaign, comparison));
  if (run.wants_page())
    run.draw({{"readings",
               report::readings_picture(robot, campaign, report::readings_models(comparison))}});
  if (!comparison.refit_failure.empty()) run.leave_unidentified(comparison.refit_failure);
  return json;
}

}  // namespace

void add_compare(Program& program) {
  const auto request = std::make_shared<CompareRequest>();
  CLI::App& app =
      program.add({.name = "compare",
                   .summary = "Compare a manipulator with measurements: where does the model fail",
                   .example = "kinetostat compare data/robots/bench.yaml "
                              "data/measurements/nist_load_cell/campaign.yaml"},
                  [request](Run& run) { return compare(*request, run); });
  request->campaign.add_options(app);
  app.add_option("--csv", request->csv, "Write measured, predicted and residual of every reading")
      ->type_name("FILE");
  app.add_option("--robust", request->robust,
                 "Fit with a loss that outliers move less: huber (95 % efficient, one minimum) or "
                 "cauchy (far outliers hardly count)")
      ->type_name("LOSS")
      ->check(CLI::IsMember({"huber", "cauchy"}));
}

}  // namespace kinetostat::apps

// kinetostat compare: a model against measurements.
#include "kinetostat/calibration/comparison/compare.h"

#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/cli/campaign_request.h"
#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/results/results.h"
#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/comparison.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/readings_picture.h"
#include "kinetostat/report/screen/comparison.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/report/waterfall.h"

namespace kinetostat::apps {
namespace {

struct CompareRequest {
  CampaignRequest campaign;
  std::string csv, robust, before, after;
};

// Two robot files, read anew, against the same readings.
io::Json compare_both(const CompareRequest& request, Run& run) {
  if (request.campaign.files.size() > 1)
    throw UsageError("--before", "a third robot file is named beside it",
                     "Name the campaign file alone.");
  const vjm::Robot before = vjm::read_robot(request.before);
  const vjm::Robot after = vjm::read_robot(request.after);
  // The readings are those of either, as long as both have the joints that they name.
  const calibration::Campaign campaign = request.campaign.read_campaign(before, run);
  if (calibration::read_campaign(request.campaign.files.back(), after.manipulator).joint_columns !=
      campaign.joint_columns)
    throw common::InputError(
        {.file = after.file,
         .what = fmt::format("has other joints in these readings than {}", before.file.string()),
         .cure = "Name two versions of the robot that was measured"});
  const calibration::BeforeAfter both = calibration::compare_before_after(
      before, after, campaign, run.threads(), run.progress(), loss_of(request.robust));
  run.print(report::first_screen(both));
  run.print_more(report::text(campaign, both));
  io::Json json{
      {"headline", report::headline(both)},
      {"inputs", {{"before", report::provenance(before)}, {"after", report::provenance(after)}}}};
  json.update(report::to_json(campaign, both));
  json["configurations"] = report::configurations(before, campaign);
  if (run.wants_page())
    run.draw({{"readings", report::readings_picture(after, campaign, both.before.noise,
                                                    {{"before", both.before.best().residual},
                                                     {"after", both.after.best().residual}})}});
  const std::string& failure =
      both.before.refit_failure.empty() ? both.after.refit_failure : both.before.refit_failure;
  if (!failure.empty()) run.leave_unidentified(failure);
  return json;
}

std::string after_comparison(const CompareRequest& request,
                             const calibration::Comparison& comparison) {
  const std::string files = request.campaign.typed();
  if (!comparison.unit_error.empty())
    return "Next: correct that in the files, then compare again\n";
  switch (comparison.adequacy()) {
    case calibration::Adequacy::inconclusive:
      return fmt::format("Next: add a {} on '{}' to the sensors, and take the readings again\n",
                         comparison.missing_sensor->kind_in_words(),
                         comparison.missing_sensor->place);
    case calibration::Adequacy::inadequate:
      return report::next_step("kinetostat diagnose " + files, "which effect is missing?");
    case calibration::Adequacy::adequate:
      return report::next_step("kinetostat plan " + files, "what would make the model sharper?");
    default:
      return "Next: state 'noise' in the campaign file, or repeat some readings\n";
  }
}

io::Json compare(const CompareRequest& request, Run& run) {
  if (!request.before.empty()) return compare_both(request, run);
  const vjm::Robot robot = request.campaign.read_robot();
  const calibration::Campaign campaign = request.campaign.read_campaign(robot, run);
  const calibration::Comparison comparison = calibration::compare(
      robot, campaign, run.threads(), run.progress(), {.loss = loss_of(request.robust)});
  say_which_robot(robot, campaign, run);
  run.print(
      report::first_screen(robot, campaign, comparison, after_comparison(request, comparison)));
  run.print_more("\n" + report::text(campaign, comparison));
  io::Json json;
  if (run.wants_result())  // all readings: several times what the rest needs
    json = comparison_result(robot, campaign, comparison);
  if (!request.csv.empty())
    io::write_atomically(request.csv, report::residual_table(campaign, comparison));
  if (run.wants_page())
    run.draw({{"readings", report::readings_picture(robot, campaign, comparison.noise,
                                                    report::readings_models(comparison))}});
  if (!comparison.refit_failure.empty()) run.leave_unidentified(comparison.refit_failure);
  return json;
}

}  // namespace

void add_compare(Program& program) {
  const auto request = std::make_shared<CompareRequest>();
  OptionList app =
      program.add({.name = "compare",
                   .summary = "Compare a manipulator with measurements: where does the model fail",
                   .example = "kinetostat compare data/robots/bench.yaml "
                              "data/measurements/nist_load_cell/campaign.yaml"},
                  [request](Run& run) { return compare(*request, run); });
  request->campaign.add_options(app);
  app.add_output("--csv", request->csv, "Write measured, predicted and residual of every reading");
  Option before = app.add_option("--before", request->before,
                                 "Compare this robot file, and that of --after, with the readings");
  Option after = app.add_option("--after", request->after, "See --before");
  before.type_name("ROBOT").needs(after);
  after.type_name("ROBOT").needs(before);
  add_robust_option(app, request->robust);
}

}  // namespace kinetostat::apps

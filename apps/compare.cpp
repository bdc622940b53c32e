// kinetostat compare: a model against measurements.
#include "kinetostat/calibration/compare.h"

#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/command.h"
#include "kinetostat/apps/commands.h"
#include "kinetostat/files/error.h"
#include "kinetostat/files/text_file.h"
#include "kinetostat/report/comparison.h"
#include "kinetostat/report/manipulator.h"

namespace kinetostat::apps {
namespace {

struct CompareRequest {
  std::vector<std::string> files;  // [ROBOT] CAMPAIGN
  std::string csv;
};

// The robot of the command line wins over the one that the campaign names, and that is said.
std::filesystem::path choose_robot(const CompareRequest& request) {
  const std::filesystem::path campaign = request.files.back();
  if (request.files.size() == 1) {
    if (const auto robot = calibration::robot_named_in(campaign)) return *robot;
    throw files::InputError({.file = campaign,
                             .key = "robot",
                             .what = "the campaign names no robot file",
                             .cure =
                                 "Add 'robot: FILE', or name it on the command line: kinetostat "
                                 "compare ROBOT CAMPAIGN"});
  }
  return request.files.front();
}

// Said only when it is not the same file.
void say_which_robot(const vjm::Robot& robot, const calibration::Campaign& campaign,
                     files::Json& json, Run& run) {
  if (!campaign.robot) return;
  const std::filesystem::path named = campaign.file.parent_path() / *campaign.robot;
  std::error_code error;
  if (std::filesystem::equivalent(named, robot.file, error) && !error) return;
  const std::string sentence =
      fmt::format("The campaign names the robot '{}'; '{}' of the command line is used instead.",
                  campaign.robot->string(), robot.file.string());
  run.print(sentence + "\n");
  json["robot_replaced"] = sentence;
}

files::Json compare(const CompareRequest& request, Run& run) {
  const vjm::Robot robot = vjm::read_robot(choose_robot(request));
  const calibration::Campaign campaign =
      calibration::read_campaign(request.files.back(), robot.manipulator);
  const calibration::Comparison comparison =
      calibration::compare(robot, campaign, run.threads(), run.progress());
  files::Json json{{"inputs", report::provenance(robot)}};
  run.print(fmt::format("Robot '{}'\n", robot.name));
  say_which_robot(robot, campaign, json, run);
  run.print(report::text(campaign, comparison));
  json.update(report::to_json(campaign, comparison));
  if (!request.csv.empty())
    files::write_atomically(request.csv, report::residual_table(campaign, comparison));
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
  app.add_option("files", request->files,
                 "Robot file (may be left out when the campaign names it) and campaign file")
      ->type_name("[ROBOT] CAMPAIGN")
      ->required()
      ->expected(1, 2);
  app.add_option("--csv", request->csv, "Write measured, predicted and residual of every reading")
      ->type_name("FILE");
}

}  // namespace kinetostat::apps

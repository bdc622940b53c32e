// kinetostat calibrate: the geometry of a robot from readings of its pose.
#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/cli/campaign_request.h"
#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/apps/cli/write_robot.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/results/calibrated_robot.h"
#include "kinetostat/apps/results/results.h"
#include "kinetostat/calibration/comparison/before_after.h"
#include "kinetostat/calibration/kinematics/kinematic_calibration.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/kinematics.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/readings_picture.h"
#include "kinetostat/report/screen/kinematics.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/report/waterfall.h"

namespace kinetostat::apps {
namespace {

using calibration::KinematicCalibration;

struct CalibrateRequest {
  CampaignRequest campaign;
  calibration::KinematicOptions options;
  std::string robust, tolerance;
};

// "0.5 mm,0.5 mrad"
calibration::Tolerance tolerance_of(const std::string& text, const spatial::UnitSystem& units) {
  if (text.empty()) return {};
  const std::vector<std::string> parts = split(text);
  if (parts.size() != 2)
    throw UsageError("--tolerance", fmt::format("'{}' is not two quantities", text),
                     "Give a length and an angle, as in '0.5 mm,0.5 mrad'");
  const calibration::Tolerance tolerance{
      quantity("--tolerance", parts[0], spatial::dimension::length, units),
      quantity("--tolerance", parts[1], spatial::dimension::angle, units)};
  if (!(tolerance.length > 0 && tolerance.angle > 0))
    throw UsageError("--tolerance", fmt::format("'{}' is not positive", text));
  return tolerance;
}

std::string next_after(const CalibrateRequest& request, const KinematicCalibration& c,
                       const Run& run) {
  const std::string campaign = report::quoted(request.campaign.files.back());
  if (c.geometry.empty())
    return report::next_step("kinetostat diagnose " + request.campaign.typed(),
                             "which effect is missing?");
  if (!run.out())
    return report::next_step(
        fmt::format("kinetostat calibrate {} -o calibrated.yaml", request.campaign.typed()),
        "writes the robot file");
  return report::next_step(
      fmt::format("kinetostat diagnose {} {}", report::quoted(*run.out()), campaign),
      "which effect is left?");
}

// The readings before and after, as `compare --before --after` has them.
void draw(const vjm::Robot& before, const std::string& text, const calibration::Campaign& campaign,
          calibration::Loss loss, Run& run) {
  const vjm::Robot after = vjm::parse_robot(text, before.file);
  const calibration::BeforeAfter both = calibration::compare_before_after(
      before, after, campaign, run.threads(), run.progress(), loss);
  io::Json json{{"command", "compare"}, {"inputs", report::provenance(before)}};
  json.update(report::to_json(campaign, both));
  json["configurations"] = report::configurations(before, campaign);
  const io::Json readings = report::readings_picture(
      after, campaign, both.before.noise,
      {{"before", both.before.best().residual}, {"after", both.after.best().residual}});
  run.add_to_page({.result = std::move(json),
                   .picture = {{"readings", readings}},
                   .text = report::text(campaign, both)});
}

io::Json calibrate(const CalibrateRequest& request, Run& run) {
  calibration::KinematicOptions options = request.options;
  const vjm::Robot robot = request.campaign.read_robot();
  options.tolerance = tolerance_of(request.tolerance, robot.units);
  options.loss = loss_of(request.robust);
  const calibration::Campaign campaign = request.campaign.read_campaign(robot, run);
  const KinematicCalibration result =
      calibration::calibrate_kinematics(robot, campaign, options, run.threads(), run.progress());
  io::Json json = calibration_result(robot, campaign, result);
  say_which_robot(robot, campaign, run);
  run.print(report::first_screen(robot, campaign, result, next_after(request, result, run)));
  run.print_more("\n" + report::text(campaign, result));
  if (result.geometry.empty()) return json;
  const std::string text = calibrated_robot(robot, io::read_text(robot.file), campaign, result);
  if (run.out()) {
    write_robot(*run.out(), text);
    json["robot"] = run.out()->string();
  }
  if (run.wants_page()) draw(robot, text, campaign, options.loss, run);
  return json;
}

}  // namespace

void add_calibrate(Program& program) {
  const auto request = std::make_shared<CalibrateRequest>();
  OptionList app =
      program.add({.name = "calibrate",
                   .summary = "Calibrate the kinematics: joint offsets, link geometry, base, tool",
                   .example = "kinetostat calibrate data/measurements/ur10_tracker/campaign.yaml "
                              "-o calibrated.yaml",
                   .out = "Write the robot file with what was found there"},
                  [request](Run& run) { return calibrate(*request, run); });
  request->campaign.add_options(app);
  app.add_option("--hold-out", request->options.folds,
                 "In so many parts poses are held out in turn, to judge by (0: none)")
      .type_name("N")
      .show_default()
      .between(0, 1000);
  app.add_option("--tolerance", request->tolerance,
                 "What is not worth knowing: parameters that the readings know no better keep "
                 "their values (default: a thousandth of the reach, 1 mrad)")
      .type_name("LENGTH,ANGLE");
  app.add_flag("--prior", request->options.prior,
               "Every error is 0 to within its tolerance beside the readings (ridge regression): "
               "for few poses");
  add_robust_option(app, request->robust);
}

}  // namespace kinetostat::apps

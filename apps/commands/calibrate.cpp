// kinetostat calibrate: the geometry of a robot from readings of its pose.
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/apps/cli/campaign_request.h"
#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/apps/cli/version.h"
#include "kinetostat/apps/cli/write_robot.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/calibration/comparison/before_after.h"
#include "kinetostat/calibration/diagnosis/adoption.h"
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

using calibration::AdoptedEffect;
using calibration::AdoptedParameter;
using calibration::Adoption;
using calibration::CalibratedGeometry;
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

const std::string& component_name(const KinematicCalibration& c, const CalibratedGeometry& g) {
  return c.effects[g.what.effect].kind->parameters[static_cast<std::size_t>(g.what.component)].name;
}

std::vector<std::string> reasons_for(const calibration::Campaign& campaign,
                                     const KinematicCalibration& c) {
  return {fmt::format("kinematic calibration by kinetostat {}: {}", version(),
                      report::headline(campaign, c)),
          fmt::format("readings: {}, sha256 {}", campaign.readings_file.filename().string(),
                      io::sha256(io::read_text(campaign.readings_file)))};
}

// In the units of the robot file.
calibration::AdoptedValue value_of(const vjm::Robot& robot, const std::string& name,
                                   const CalibratedGeometry& g) {
  return calibration::in_units_of(robot.units,
                                  {name, g.what.turns() ? "rad" : "m", g.value, g.deviation});
}

// A new effect for each place, from base to end; those that the file has get other values.
void add_geometry(const vjm::Robot& robot, const calibration::Campaign& campaign,
                  const KinematicCalibration& c, Adoption& adoption) {
  for (std::size_t e = 0; e < c.effects.size(); ++e) {
    AdoptedEffect adopted{
        .effect = c.effects[e].kind->name, .at = c.effects[e].at, .values = {}, .reasons = {}};
    for (const CalibratedGeometry& g : c.geometry) {
      if (g.what.effect != e) continue;
      const std::string& name = component_name(c, g);
      if (e >= c.own_effects)
        adopted.values.push_back(value_of(robot, name, g));
      else
        adoption.fitted.push_back({.stiffness = {},
                                   .effect = adopted.effect,
                                   .at = adopted.at,
                                   .parameter = name,
                                   .value = value_of(robot, "value", g),
                                   .remark = {}});
    }
    if (adopted.values.empty()) continue;
    if (adoption.effects.empty()) adopted.reasons = reasons_for(campaign, c);
    adoption.effects.push_back(std::move(adopted));
  }
}

// What was fitted beside the geometry; at a bound nothing is known of its deviation.
AdoptedParameter parameter_of(const vjm::Robot& robot, const calibration::ParameterEstimate& e) {
  const double deviation = e.hit == calibration::BoundHit::none
                               ? e.standard_error
                               : std::numeric_limits<double>::quiet_NaN();
  AdoptedParameter adopted;
  if (e.parameter.is_logarithm()) {
    adopted.stiffness = e.parameter.name;
    adopted.value = {"factor", "", std::exp(e.value), std::exp(e.value) * deviation};
    return adopted;
  }
  const vjm::Effect& effect = robot.effects[e.parameter.effect];
  adopted.effect = effect.kind->name;
  adopted.at = effect.at;
  adopted.parameter = effect.kind->parameters[static_cast<std::size_t>(e.parameter.value)].name;
  adopted.value =
      calibration::in_units_of(robot.units, {"value", e.parameter.unit, e.value, deviation});
  return adopted;
}

Adoption adoption_of(const vjm::Robot& robot, const calibration::Campaign& campaign,
                     const KinematicCalibration& c) {
  Adoption adoption;
  add_geometry(robot, campaign, c, adoption);
  for (const calibration::ParameterEstimate& e : c.others)
    adoption.fitted.push_back(parameter_of(robot, e));
  return adoption;
}

// The text of the robot file with what was found.
std::string calibrated_file(const vjm::Robot& robot, const Adoption& adoption) {
  try {
    return calibration::adopted(io::read_text(robot.file), adoption);
  } catch (const std::invalid_argument& error) {
    throw common::InputError({.file = robot.file, .what = error.what()});
  }
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
  io::Json json{{"headline", report::headline(campaign, result)},
                {"inputs", report::provenance(robot)}};
  say_which_robot(robot, campaign, json, run);
  run.print(report::first_screen(robot, campaign, result, next_after(request, result, run)));
  run.print_more("\n" + report::text(campaign, result));
  json.update(report::to_json(campaign, result));
  if (result.geometry.empty()) return json;
  const std::string text = calibrated_file(robot, adoption_of(robot, campaign, result));
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

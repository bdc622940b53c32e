// kinetostat plan: what to measure next.
#include "kinetostat/calibration/design/plan.h"

#include <memory>

#include <fmt/format.h>

#include "kinetostat/apps/cli/campaign_request.h"
#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/apps/cli/pose_list.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/commands/diagnosis_steps.h"
#include "kinetostat/apps/results/adoption.h"
#include "kinetostat/apps/results/results.h"
#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/diagnosis_file.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/plan.h"
#include "kinetostat/report/screen/plan.h"
#include "kinetostat/report/screen/wording.h"

namespace kinetostat::apps {
namespace {

struct PlanRequest {
  CampaignRequest campaign;
  std::string diagnosis, work_at, most_force, most_moment;
  std::vector<std::string> show, within;
  calibration::PlanOptions options;
  calibration::DiagnosisOptions diagnose;
  KeptFits kept;
};

// A diagnosis is of one robot file and one table of readings.
calibration::DiagnosisRecord read_diagnosis(const PlanRequest& request, const vjm::Robot& robot,
                                            const calibration::Campaign& campaign) {
  calibration::DiagnosisRecord diagnosis = report::read_diagnosis(request.diagnosis);
  require_same_robot(diagnosis, robot.file);
  if (diagnosis.readings_sha256 != io::sha256(io::read_text(campaign.readings_file)))
    throw common::InputError({.file = request.diagnosis,
                              .key = "readings",
                              .what = "the diagnosis is of other readings than these",
                              .cure = "Run 'kinetostat diagnose -o' again on this campaign"});
  return diagnosis;
}

calibration::DiagnosisRecord diagnosis_of(const PlanRequest& request, const vjm::Robot& robot,
                                          const calibration::Campaign& campaign, Run& run) {
  if (!request.diagnosis.empty()) return read_diagnosis(request, robot, campaign);
  return report::diagnosis_record(
      report::to_json(robot, campaign,
                      resumable_diagnosis(robot, campaign, request.diagnose, request.kept, run)),
      {});
}

calibration::PlanQuestion question_of(const PlanRequest& request, const vjm::Robot& robot,
                                      const calibration::DiagnosisRecord& diagnosis) {
  try {
    return calibration::question_of(robot, diagnosis, request.show);
  } catch (const std::invalid_argument& error) {
    throw UsageError("--show", error.what(), "'kinetostat effect list ROBOT.yaml' names effects");
  }
}

// A coordinate as configurations call it, and its dimension.
std::pair<std::string, spatial::Dimension> coordinate_named(const vjm::Robot& robot,
                                                            const std::string& name) {
  if (name == "x" || name == "y" || name == "z") return {name, spatial::dimension::length};
  std::vector<std::pair<std::string, spatial::Dimension>> found;
  std::vector<std::string> known;
  for (const vjm::Chain& chain : robot.manipulator.chains())
    for (const vjm::Coordinate& c : chain.coordinates()) {
      if (c.role != vjm::Role::actuated) continue;
      const std::string full = chain.name() + "." + c.name;
      known.insert(known.end(), {c.name, full});
      if (name == c.name || name == full)
        found.emplace_back(
            full, is_rotation(c.motion) ? spatial::dimension::angle : spatial::dimension::length);
    }
  if (found.size() == 1) return found.front();
  if (found.size() > 1)
    throw UsageError("--within", fmt::format("several chains have a joint '{}'", name),
                     fmt::format("Name its chain too, as in {}", found.front().first));
  const std::string near = common::nearest_spelling(name, known);
  throw UsageError("--within", fmt::format("there is no drive '{}'", name),
                   near.empty() ? "" : fmt::format("Did you mean '{}'?", near));
}

// "q2=-90..110"
void read_range(const std::string& text, const vjm::Robot& robot,
                calibration::MeasuringOptions& measuring) {
  const std::size_t equals = text.find('='), dots = text.find("..", equals);
  if (equals == std::string::npos || dots == std::string::npos)
    throw UsageError("--within", fmt::format("'{}' is no range of a joint", text),
                     "Write --within q2=-90..110");
  const auto [name, dimension] = coordinate_named(robot, text.substr(0, equals));
  const double least = quantity("--within", text.substr(equals + 1, dots - equals - 1), dimension,
                                robot.units),
               largest = quantity("--within", text.substr(dots + 2), dimension, robot.units);
  if (!(least < largest))
    throw UsageError("--within", fmt::format("'{}' needs the least value first", text));
  if (!measuring.within.emplace(name, std::array{least, largest}).second)
    throw UsageError("--within", fmt::format("'{}' is given twice", name));
}

std::vector<spatial::Pose> read_work(const std::string& file, const vjm::Robot& robot,
                                     const Run& run) {
  const vjm::PoseList path = read_path(file, robot, {});
  remark_on(path, run);
  std::vector<spatial::Pose> work;
  for (const vjm::TargetPose& pose : path.poses) {
    if (!pose.held.empty())
      throw UsageError("--work-at", "the work is where the platform is, not a joint",
                       "Leave the columns of joints out of the file");
    work.push_back(pose.platform);
  }
  return work;
}

calibration::PlanOptions options_of(const PlanRequest& request, const vjm::Robot& robot,
                                    const Run& run) {
  calibration::PlanOptions options = request.options;
  const auto positive = [&](const char* name, const std::string& text,
                            const spatial::Dimension& dimension) {
    if (text.empty()) return 0.0;
    const double value = quantity(name, text, dimension, robot.units);
    if (!(value > 0)) throw UsageError(name, fmt::format("'{}' is not positive", text));
    return value;
  };
  options.measuring.most_force =
      positive("--most-force", request.most_force, spatial::dimension::force);
  options.measuring.most_moment =
      positive("--most-moment", request.most_moment, spatial::dimension::moment);
  for (const std::string& range : request.within) read_range(range, robot, options.measuring);
  if (!request.work_at.empty()) options.work_at = read_work(request.work_at, robot, run);
  return options;
}

std::string after_plan(const PlanRequest& request, const calibration::Plan& plan, const Run& run) {
  if (plan.blocks.empty()) return {};
  if (run.out())
    return report::next_step("take the readings of " + report::quoted(*run.out()),
                             "add them to the campaign, and diagnose again");
  return report::next_step(fmt::format("kinetostat plan {} -o next.csv", request.campaign.typed()),
                           "writes these readings as a table");
}

io::Json plan(const PlanRequest& request, Run& run) {
  const vjm::Robot robot = request.campaign.read_robot();
  const calibration::Campaign campaign = request.campaign.read_campaign(robot, run);
  const calibration::PlanOptions options = options_of(request, robot, run);
  const calibration::DiagnosisRecord diagnosis = diagnosis_of(request, robot, campaign, run);
  const calibration::PlanQuestion question = question_of(request, robot, diagnosis);
  const calibration::Plan plan =
      calibration::plan(robot, campaign, question, options, run.threads(), run.progress());
  say_which_robot(robot, campaign, run);
  if (run.out() && !plan.blocks.empty())
    io::write_atomically(*run.out(), report::plan_table(robot, plan));
  run.print(report::first_screen(robot, question, options, plan, after_plan(request, plan, run)));
  run.print_more(report::text(robot, campaign, question, options, plan));
  if (plan.blocks.empty())
    run.leave_unidentified("no readings of this kind would change what is known");
  return plan_result(robot, campaign, question, options, plan);
}

void add_cost_options(OptionList& app, calibration::PlanOptions& options) {
  const auto minutes = [&app](const char* name, double& value, const char* what) {
    app.add_option(name, value, what).show_default().between(0.0, 1e5);
  };
  minutes("--minutes", options.minutes, "That the readings may take");
  minutes("--minutes-per-pose", options.measuring.minutes_per_pose, "Of changing the posture");
  minutes("--minutes-per-load", options.measuring.minutes_per_load, "Of changing the load");
  minutes("--minutes-per-reading", options.measuring.minutes_per_reading, "Of one reading");
  minutes("--hold", options.measuring.hold, "That a load is held where time matters");
  app.add_option("--margin", options.measuring.margin,
                 "The robot must stand, stably, under so many times the load")
      .show_default()
      .between(1.0, 100.0);
  app.add_option("--wanted", options.wanted, "d' from which two models count as distinguished")
      .show_default()
      .between(0.1, 1e3);
}

}  // namespace

void add_plan(Program& program) {
  const auto request = std::make_shared<PlanRequest>();
  OptionList app = program.add(
      {.name = "plan",
       .summary = "What to measure next, to distinguish effects or sharpen the model",
       .example = "kinetostat plan data/robots/bench.yaml "
                  "data/measurements/nist_load_cell/campaign.yaml -o plan.csv",
       .out = "Write the readings to take, for 'simulate' and for people, to a CSV file"},
      [request](Run& run) { return plan(*request, run); });
  request->campaign.add_options(app);
  app.add_option("--diagnosis", request->diagnosis,
                 "Diagnosis of these readings (default: it is made first)")
      .type_name("DIAGNOSIS.json");
  app.add_option("--show", request->show,
                 "Effects, or \"EFFECT at PLACE\", that the readings shall show if they are there")
      .delimiter(',')
      .type_name("NAMES");
  app.add_option(
         "--work-at", request->work_at,
         "Where the model is used: columns x y z rx ry rz (default: the campaign's postures)")
      .type_name("POSES.csv");
  app.add_option("--within", request->within,
                 "How far joints may go, q2=-90..110,... (default: as far as in the campaign; a "
                 "joint in question alone also through the 'range' of the robot file)")
      .delimiter(',')
      .type_name("RANGES");
  app.add_option("--most-force", request->most_force,
                 "Largest force (default: the largest of the campaign)")
      .type_name("FORCE");
  app.add_option("--most-moment", request->most_moment, "Largest moment (the same)")
      .type_name("MOMENT");
  add_cost_options(app, request->options);
  app.add_option("--effects", request->diagnose.kinds, "As in 'diagnose', where that is made first")
      .delimiter(',')
      .type_name("NAMES");
  app.add_option("--draws", request->diagnose.draws, "The same").show_default().between(99, 100000);
  app.add_option("--seed", request->diagnose.seed, "The same").seed().show_default();
  add_options(app, request->kept);
}

}  // namespace kinetostat::apps

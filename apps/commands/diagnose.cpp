// kinetostat diagnose: which physical effect is missing from a model?
#include <algorithm>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "kinetostat/apps/cli/campaign_request.h"
#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/fit_cache.h"
#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/commands/diagnosis_steps.h"
#include "kinetostat/apps/results/results.h"
#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/diagnosis/diagnosis.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/comparison.h"
#include "kinetostat/report/diagnosis.h"
#include "kinetostat/report/diagnosis_file.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/plan.h"
#include "kinetostat/report/readings_picture.h"
#include "kinetostat/report/screen/diagnosis.h"
#include "kinetostat/report/screen/joint_curve.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/report/signature_table.h"

namespace kinetostat::apps {
namespace {

struct DiagnoseRequest {
  CampaignRequest campaign;
  calibration::DiagnosisOptions options;
  std::vector<std::string> without;
  std::string plan, signatures;
  bool profiles = false;
  KeptFits kept;
};

void require_known_kinds(const char* option, const std::vector<std::string>& kinds,
                         const vjm::Robot& robot) {
  for (const std::string& kind : kinds) {
    try {
      (void)vjm::effect_kind(kind, robot.kinds());
    } catch (const std::invalid_argument& error) {
      throw UsageError(option, error.what(), "'kinetostat effect list ROBOT.yaml' names them");
    }
  }
}

// Kinds to try; none stands for all of them.
std::vector<std::string> kinds_to_try(const DiagnoseRequest& request, const vjm::Robot& robot) {
  require_known_kinds("--effects", request.options.kinds, robot);
  require_known_kinds("--without", request.without, robot);
  if (request.without.empty()) return request.options.kinds;
  std::vector<std::string> kinds;
  for (const auto& kind : robot.kinds())
    if (std::find(request.without.begin(), request.without.end(), kind->name) ==
        request.without.end())
      kinds.push_back(kind->name);
  return kinds;
}

// The comparisons that the charts show, each made once.
void draw(const vjm::Robot& robot, const calibration::Campaign& campaign,
          const calibration::Diagnosis& diagnosis, Run& run) {
  const auto compared = [&](const vjm::Robot& model) {
    return calibration::compare(model, campaign, run.threads(), run.progress());
  };
  const calibration::Comparison before = compared(robot);
  std::optional<calibration::Comparison> after;
  if (!diagnosis.found.empty()) after = compared(report::with_found(robot, diagnosis));
  io::Json picture = diagnosis_picture(robot, campaign, before, after ? &*after : nullptr);
  if (after)
    picture["joint_curve"] = report::joint_curve_picture(robot, campaign, diagnosis, before, *after,
                                                         run.threads(), run.progress());
  run.draw(std::move(picture));
  io::Json comparison = report::to_json(campaign, before);
  comparison.erase("readings");  // they are in the picture
  run.add_to_page({.result = std::move(comparison), .picture = {}, .text = {}});
}

// What to do with the verdict.
std::string after_diagnosis(const DiagnoseRequest& request, const vjm::Robot& robot,
                            const calibration::Diagnosis& diagnosis, const Run& run) {
  const std::string files = request.campaign.typed();
  const std::string file = run.out() ? report::quoted(*run.out()) : "";
  if (diagnosis.by_kinematics)
    return report::next_step("kinetostat calibrate " + files + " -o calibrated.yaml",
                             "then diagnose with that robot file");
  std::string plan = report::next_step(fmt::format("kinetostat plan {}{} -o next.csv", files,
                                                   file.empty() ? "" : " --diagnosis " + file),
                                       "what to read next");
  switch (diagnosis.verdict) {
    case calibration::Verdict::identified:
      if (diagnosis.predicts_worse()) return plan;
      if (file.empty())
        return report::next_step("kinetostat study " + files + " -o study",
                                 "adopts it, compares again and plans what to read next");
      return report::next_step(fmt::format("kinetostat adopt {} {} -o calibrated.yaml",
                                           report::quoted(robot.file), file),
                               "then compare again");
    case calibration::Verdict::unexplained:
      return report::next_step("kinetostat compare " + files + " --html compare.html",
                               "what does the rest of the error depend on?");
    default:
      if (diagnosis.verdict == calibration::Verdict::none_needed && !diagnosis.doubted &&
          diagnosis.leaves_misfit())
        return report::next_step("kinetostat compare " + files + " --html compare.html",
                                 "what does the error depend on?");
      return plan;
  }
}

io::Json diagnose(const DiagnoseRequest& request, Run& run) {
  const vjm::Robot robot = request.campaign.read_robot();
  calibration::DiagnosisOptions options = request.options;
  options.kinds = kinds_to_try(request, robot);
  const calibration::Campaign campaign = request.campaign.read_campaign(robot, run);
  if (request.profiles || run.wants_page()) options.profiles = most_profiles;
  options.signatures = !request.signatures.empty();
  const calibration::Diagnosis diagnosis =
      resumable_diagnosis(robot, campaign, options, request.kept, run);
  io::Json json = diagnosis_result(robot, campaign, request.options, diagnosis);
  say_which_robot(robot, campaign, run);
  run.print(report::first_screen(robot, campaign, diagnosis,
                                 after_diagnosis(request, robot, diagnosis, run)));
  run.print_more(report::text(robot, campaign, diagnosis));
  if (run.wants_page()) draw(robot, campaign, diagnosis, run);
  if (!request.plan.empty()) {
    const auto score =
        calibration::score_plan(report::promise_of(io::read_json(request.plan), request.plan),
                                robot, campaign, diagnosis, run.threads(), run.progress());
    run.print(report::text(score));
    json["plan"] = report::to_json(score);
  }
  if (run.out()) io::write_json(*run.out(), json);
  if (diagnosis.signatures)
    io::write_atomically(request.signatures,
                         report::signature_csv(campaign, *diagnosis.signatures));
  else if (options.signatures)
    run.warn(request.signatures +
             " is not written: signatures are counted in the noise, which "
             "nothing is known of");
  if (diagnosis.verdict == calibration::Verdict::inconclusive)
    run.leave_unidentified("inconclusive: these data do not show which effect is missing");
  return json;
}

// What other workers wait for must not go to make room.
io::Cache folder_of(const KeptFits& kept) {
  constexpr std::uintmax_t shared_limit = std::uintmax_t{1} << 40;  // [bytes]
  if (!kept.shared.empty()) return io::Cache(kept.shared, shared_limit);
  return kept.nowhere ? io::Cache() : io::Cache::of_user();
}

}  // namespace

calibration::Diagnosis resumable_diagnosis(const vjm::Robot& robot,
                                           const calibration::Campaign& campaign,
                                           calibration::DiagnosisOptions options,
                                           const KeptFits& kept, Run& run) {
  const io::Cache folder = folder_of(kept);
  FitCache cache(
      folder, robot, campaign, [&run](const std::string& sentence) { run.warn(sentence); },
      kept.shared.empty() ? nullptr : std::make_unique<io::Claims>(kept.shared));
  const auto remark = [&run](const std::string& sentence) {
    if (!sentence.empty()) run.remark(sentence);
  };
  if (folder.enabled()) options.journal = &cache;
  try {
    calibration::Diagnosis diagnosis =
        calibration::diagnose(robot, campaign, options, run.threads(), run.progress());
    remark(cache.what_was_found());
    return diagnosis;
  } catch (const common::Cancelled&) {
    remark(cache.what_is_left());
    throw;
  }
}

void add_options(OptionList& app, KeptFits& kept) {
  app.add_flag("--no-cache", kept.nowhere, "Make all fits anew, and keep none to go on from");
  app.add_option("--share", kept.shared,
                 "Share the work with all runs of the same command that name this folder, on any "
                 "machine; each ends with the whole result")
      .type_name("DIR")
      .excludes("--no-cache");
}

io::Json diagnosis_picture(const vjm::Robot& robot, const calibration::Campaign& campaign,
                           const calibration::Comparison& before,
                           const calibration::Comparison* after) {
  std::vector<report::ReadingsModel> models = report::readings_models(before);
  if (after != nullptr) models.push_back({"with the effect", after->best().residual});
  return {{"readings", report::readings_picture(robot, campaign, before.noise, models)}};
}

void add_diagnose(Program& program) {
  const auto request = std::make_shared<DiagnoseRequest>();
  OptionList app =
      program.add({.name = "diagnose",
                   .summary = "Which physical effect is missing from a model",
                   .example = "kinetostat diagnose data/robots/bench.yaml "
                              "data/measurements/nist_load_cell/campaign.yaml -o diagnosis.json",
                   .out = "Write the diagnosis, for 'adopt', to a JSON file"},
                  [request](Run& run) { return diagnose(*request, run); });
  request->campaign.add_options(app);
  app.add_option("--effects", request->options.kinds,
                 "Effects to try (default: the whole catalogue; see 'effect list')")
      .delimiter(',')
      .type_name("NAMES");
  app.add_option("--without", request->without, "Effects not to try")
      .delimiter(',')
      .type_name("NAMES")
      .excludes("--effects");
  app.add_option("--plan", request->plan,
                 "Score the plan (from 'plan --json') that some of the readings follow")
      .type_name("PLAN.json");
  app.add_flag("--profiles", request->profiles,
               "Likelihood profiles of the fitted values, for --json; pages have them anyway");
  app.add_output("--signatures", request->signatures,
                 "Write the residual and the signature of every candidate as a table, in units of "
                 "the noise: for methods of your own");
  add_options(app, request->kept);
  app.add_option("--draws", request->options.draws, "Simulated campaigns of the bootstraps")
      .show_default()
      .between(99, 100000);
  app.add_option("--seed", request->options.seed, "Seed of the bootstraps").seed().show_default();
  app.add_option("--most-effects", request->options.most_effects,
                 "Most effects that are named one after the other")
      .show_default()
      .between(1, 10);
}

}  // namespace kinetostat::apps

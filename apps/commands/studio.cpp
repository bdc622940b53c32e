// kinetostat studio: a robot and its readings in a browser on this machine, where effects are added
// to the model, fitted, diagnosed and adopted.
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "kinetostat/apps/cli/campaign_request.h"
#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/shipped_files.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/commands/diagnosis_steps.h"
#include "kinetostat/apps/results/results.h"
#include "kinetostat/apps/studio/studio_files.h"
#include "kinetostat/apps/studio/studio_notes.h"
#include "kinetostat/apps/studio/studio_server.h"
#include "kinetostat/apps/studio/studio_session.h"
#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/comparison/compare.h"
#include "kinetostat/calibration/design/plan.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/base64.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/diagnosis_file.h"
#include "kinetostat/report/plan.h"
#include "kinetostat/report/screen/comparison.h"
#include "kinetostat/report/screen/diagnosis.h"
#include "kinetostat/report/screen/plan.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::apps {
namespace {

using io::Json;
using std::filesystem::path;

constexpr char studio_notes_name[] = "studio.json",
               studio_diagnosis_name[] = "studio-diagnosis.json",
               studio_table_name[] = "studio-next.csv";

struct StudioRequest {
  std::vector<std::string> files;
  std::string folder;
  int port = 0;
};

struct Demo {
  const char *name, *campaign, *sentence;
};
constexpr Demo demos[] = {
    {"six-axis arm", "data/measurements/six_axis_balancer/campaign.yaml",
     "A tracker sees a six-axis arm bend otherwise than its model does. What is missing?"},
    {"arm with hysteresis", "data/measurements/arm_hysteresis/campaign.yaml",
     "Loads go up and come down again, and the arm does not come back on the same line."},
    {"cycloidal drive", "data/measurements/cycloidal_drives/as_built.yaml",
     "Real readings of one drive on a bench (Jelmer V., CC BY-SA 4.0)."},
    {"Orthoglide", "data/measurements/orthoglide_clearance/campaign.yaml",
     "A parallel robot of three chains, with something loose in one of them."}};

std::string text_at(const Json& request, const char* key) {
  const Json value = request.value(key, Json());
  if (!value.is_string()) throw common::InputError(key, "is missing");
  return value.get<std::string>();
}

class Studio {
 public:
  Studio(const StudioRequest& request, Run& run)
      : run_(run),
        given_(request.files),
        files_(request.folder.empty() ? default_folder(request) : path(request.folder)) {}

  StudioRooms rooms();

 private:
  static path default_folder(const StudioRequest& request) {
    return request.files.empty() ? std::filesystem::current_path()
                                 : std::filesystem::absolute(request.files.back()).parent_path();
  }
  Json state() const;
  Json starters();
  Json open(const Json& request, StudioJob& job);
  Json close();
  Json fit(const Json& request, StudioJob& job);
  Json diagnose(StudioJob& job);
  Json plan(StudioJob& job);
  Json adopt(const Json& request, StudioJob& job);
  void write_own(const std::string& name, const std::string& content) const;
  StudioSession& session() const {
    if (!session_) throw common::InputError("files", "no robot is open", "Open one first");
    return *session_;
  }

  Run& run_;
  std::vector<std::string> given_;
  StudioFiles files_;
  std::unique_ptr<StudioSession> session_;
  std::optional<StudioNotes> notes_;
};

Json Studio::state() const {
  Json shown = Json::array();
  for (const Demo& demo : demos)
    shown.push_back({{"name", demo.name}, {"sentence", demo.sentence}});
  return {{"folder", files_.folder().string()},
          {"files", files_.list()},
          {"demos", shown},
          {"given", !given_.empty()},
          {"project", session_ ? session_->opening() : Json()},
          {"notes", notes_ ? notes_->all() : Json()}};
}

// Files of a robot to start with.
Json Studio::starters() {
  for (const char* name : {"robot.yaml", "readings.csv", "campaign.yaml"}) {
    const std::string text = io::read_text(shipped(path("data/starters") / name));
    const Json written = files_.drop({{"name", name}, {"content", io::base64(text)}});
    if (written["file"] != name)
      throw common::InputError(files_.file(name), "is there already, and is not written over",
                               "Name another folder with --folder");
  }
  return {{"robot", "robot.yaml"}, {"campaign", "campaign.yaml"}};
}

// The files of the command line, a demo, or files of the folder.
Json Studio::open(const Json& request, StudioJob& job) {
  CampaignRequest chosen;
  if (request.contains("demo")) {
    for (const Demo& demo : demos)
      if (text_at(request, "demo") == demo.name) chosen.files = {shipped(demo.campaign).string()};
    if (chosen.files.empty()) throw common::InputError("demo", "there is none of this name");
  } else if (request.contains("campaign")) {
    if (request.contains("robot"))
      chosen.files.push_back(files_.file(text_at(request, "robot")).string());
    chosen.files.push_back(files_.file(text_at(request, "campaign")).string());
  } else {
    chosen.files = given_;
  }
  if (chosen.files.empty()) throw common::InputError("files", "none is named");
  vjm::Robot robot = chosen.read_robot();
  calibration::Campaign campaign = chosen.read_campaign(robot, run_);
  const std::string about = io::sha256(io::read_text(robot.file) + io::read_text(campaign.file) +
                                       io::read_text(campaign.readings_file));
  session_ = std::make_unique<StudioSession>(std::move(robot), std::move(campaign), files_.folder(),
                                             run_.threads(), job);
  notes_.emplace(files_.folder() / studio_notes_name, about);
  return Json::object();
}

Json Studio::close() {
  session_.reset();
  notes_.reset();
  given_.clear();
  return Json::object();
}

Json Studio::fit(const Json& request, StudioJob& job) {
  Json fitted = session().fit(request, job);
  if (!request.at("effects").empty()) notes_->keep_card(fitted["card"]);
  notes_->keep("chosen", fitted["card"]["name"]);
  return fitted;
}

// A file of the studio's own: nothing is written through a link.
void Studio::write_own(const std::string& name, const std::string& content) const {
  io::write_in_place_of(io::Replace::entry, files_.folder() / name, content);
}

Json Studio::diagnose(StudioJob& job) {
  const vjm::Robot& robot = session().robot();
  const calibration::Campaign& campaign = session().campaign();
  const calibration::DiagnosisOptions options;
  CommonOptions quiet;
  quiet.threads = run_.threads();
  const auto say = [&job](std::string_view text) { job.say(std::string(text)); };
  Run run(quiet, Json::object(), job, say, say);
  const calibration::Diagnosis found = resumable_diagnosis(robot, campaign, options, {}, run);
  Json verdict{{"headline", report::headline(robot, campaign, found)},
               {"excluded", Json::array()},
               {"not_observable", report::not_observable(found)},
               {"found", Json::array()},
               {"probabilities", Json::object()}};
  job.say(verdict["headline"]);
  write_own(studio_diagnosis_name,
            diagnosis_result(robot, campaign, options, found).dump(1) + "\n");
  for (const auto& [name, odds] : report::excluded(robot, found, 6))
    verdict["excluded"].push_back({{"effect", name}, {"odds", report::odds(odds)}});
  for (const calibration::DiagnosisStep& step : found.steps)
    for (const calibration::RankedCandidate& ranked : step.ranking)
      if (ranked.fit && !verdict["probabilities"].contains(ranked.candidate.name()))
        verdict["probabilities"][ranked.candidate.name()] = ranked.fit->probability;
  for (const calibration::FoundEffect& one : found.found) {
    verdict["found"].push_back(one.candidate.name());
    fit({{"effects", verdict["found"]}}, job);
  }
  notes_->keep("verdict", verdict);
  return verdict;
}

Json Studio::plan(StudioJob& job) {
  const vjm::Robot& robot = session().robot();
  const calibration::PlanOptions options;
  const path diagnosis = files_.folder() / studio_diagnosis_name;
  if (!notes_->all().contains("verdict"))
    throw common::InputError("plan", "there is no verdict yet", "Diagnose first");
  const calibration::PlanQuestion question =
      calibration::question_of(robot, report::read_diagnosis(diagnosis), {});
  const calibration::Plan plan =
      calibration::plan(robot, session().campaign(), question, options, run_.threads(), job);
  Json planned{{"headline", report::headline(robot, question, options, plan)},
               {"work_list", report::to_json(report::work_list(robot, plan))}};
  if (!plan.blocks.empty()) {
    const std::string table = report::plan_table(robot, plan);
    write_own(studio_table_name, table);
    planned["file"] = studio_table_name;
    planned["text"] = table;
  }
  notes_->keep("plan", planned);
  return planned;
}

Json Studio::adopt(const Json& request, StudioJob& job) {
  const path file = session().save(request).at("file").get<std::string>();
  const vjm::Robot robot = vjm::read_robot(file);
  const calibration::Comparison again =
      calibration::compare(robot, session().campaign(), run_.threads(), job);
  Json adopted{{"file", file.filename().string()},
               {"headline", report::headline(again)},
               {"error", again.nominal.error_over_noise()},
               {"text", io::read_text(file)}};
  notes_->keep("adopted", adopted);
  return adopted;
}

StudioRooms Studio::rooms() {
  StudioRooms rooms;
  rooms.page =
      report::page("Studio", {{.result = {{"command", "studio"}}, .picture = {}, .text = {}}},
                   report::PageHost::studio);
  rooms.actions = {
      {"state", [this](const Json&) { return state(); }},
      {"new", [this](const Json&) { return starters(); }},
      {"close", [this](const Json&) { return close(); }},
      {"drop", [this](const Json& asked) { return files_.drop(asked); }},
      {"readings", [this](const Json& asked) { return files_.look(asked); }},
      {"use", [this](const Json& asked) { return files_.use(asked); }},
      {"try", [this](const Json& asked) { return session().try_values(asked, run_.progress()); }},
      {"posture", [this](const Json& asked) { return session().posture(asked); }},
      {"save", [this](const Json& asked) { return session().save(asked); }},
      {"remove", [this](const Json& asked) {
         session();
         notes_->remove_card(text_at(asked, "name"));
         return notes_->all();
       }}};
  rooms.jobs = {{"open", [this](const Json& asked, StudioJob& job) { return open(asked, job); }},
                {"fit", [this](const Json& asked, StudioJob& job) { return fit(asked, job); }},
                {"diagnose", [this](const Json&, StudioJob& job) { return diagnose(job); }},
                {"plan", [this](const Json&, StudioJob& job) { return plan(job); }},
                {"adopt", [this](const Json& asked, StudioJob& job) { return adopt(asked, job); }}};
  return rooms;
}

Json studio(const StudioRequest& request, Run& run) {
  report::require_pages();
  Studio studio(request, run);
  const StudioRooms rooms = studio.rooms();
  serve_studio(rooms, {.port = request.port,
                       .opened =
                           [&run](const std::string& address) {
                             run.say_now("Open " + address + "\nCtrl-C ends the session.\n");
                           },
                       .stopped = [&run] { return run.progress().cancelled(); }});
  run.print("The session has ended.\n");
  return Json::object();
}

}  // namespace

void add_studio(Program& program) {
  const auto request = std::make_shared<StudioRequest>();
  OptionList app = program.add(
      {.name = "studio",
       .summary = "Robot and readings in a browser on this machine: try effects, diagnose, adopt",
       .example = "kinetostat studio data/robots/bench.yaml "
                  "data/measurements/nist_load_cell/campaign.yaml",
       .out = {},
       .runs_until_stopped = true},
      [request](Run& run) { return studio(*request, run); });
  app.add_option("files", request->files,
                 "Robot file and campaign file; none: the start page asks for them")
      .type_name("[ROBOT] [CAMPAIGN]")
      .hide_default()
      .count(0, 2);
  app.add_option("--folder", request->folder,
                 "Where files are dropped, found and saved (default: beside the campaign file)")
      .type_name("DIR");
  app.add_option("--port", request->port, "Port to listen on (default: any that is free)")
      .hide_default()
      .between(0, 65535);
}

}  // namespace kinetostat::apps

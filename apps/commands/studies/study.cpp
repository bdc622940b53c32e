// kinetostat study: from readings to a model that explains them, step by step, and one page.
#include "kinetostat/apps/commands/studies/study.h"

#include <memory>
#include <optional>

#include <fmt/format.h>

#include "kinetostat/apps/cli/fit_cache.h"
#include "kinetostat/apps/cli/write_robot.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/commands/diagnosis_steps.h"
#include "kinetostat/apps/commands/studies/table_request.h"
#include "kinetostat/apps/results/adoption.h"
#include "kinetostat/apps/results/calibrated_robot.h"
#include "kinetostat/apps/results/results.h"
#include "kinetostat/calibration/campaign/campaign_check.h"
#include "kinetostat/calibration/campaign/joint_loads.h"
#include "kinetostat/calibration/comparison/before_after.h"
#include "kinetostat/calibration/comparison/compare.h"
#include "kinetostat/calibration/design/plan.h"
#include "kinetostat/io/document_kind.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/campaign_check.h"
#include "kinetostat/report/comparison.h"
#include "kinetostat/report/diagnosis_file.h"
#include "kinetostat/report/kinematics.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/plan.h"
#include "kinetostat/report/readings_overview.h"
#include "kinetostat/report/readings_picture.h"
#include "kinetostat/report/screen/comparison.h"
#include "kinetostat/report/screen/diagnosis.h"
#include "kinetostat/report/screen/joint_curve.h"
#include "kinetostat/report/screen/kinematics.h"
#include "kinetostat/report/screen/plan.h"
#include "kinetostat/report/screen/readings.h"
#include "kinetostat/report/screen/study.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/report/waterfall.h"

namespace kinetostat::apps {
namespace {

using calibration::Campaign;
using calibration::Comparison;
using report::Station;

constexpr char robot_name[] = "calibrated.yaml", table_name[] = "next.csv",
               page_name[] = "index.html", diagnosis_name[] = "diagnosis.json";

struct StudyRequest {
  CampaignRequest campaign;
  TableRequest table;
  KeptFits kept;
};

// One step as its file keeps it: the result as its command writes it, and beside it, under "study",
// what it says and what its charts need.
struct Step {  // NOLINT(bugprone-exception-escape): moving a Json throws nothing
  io::Json result, picture;
  std::string text, headline;
  std::vector<Station> stations;
};

// The files of a study. A step that is there and was made of the same inputs is not made again, as
// long as the file is there, too, that it wrote beside its own.
class StudyFolder {
 public:
  StudyFolder(std::filesystem::path folder, std::string inputs, Run& run)
      : folder_(std::move(folder)), inputs_(std::move(inputs)), run_(run) {}

  std::filesystem::path file(const std::string& name) const { return folder_ / name; }

  template <class Make>
  Step step(const std::string& name, const std::string& product, const Make& make) {
    std::optional<Step> kept = find(name);
    const bool has_product = kept && kept->result.value("wrote", "") == product;
    std::error_code ignored;
    if (kept && (!has_product || std::filesystem::exists(file(product), ignored))) {
      run_.remark(fmt::format("{}: made of the same files before", name));
      return *kept;
    }
    Step made = make();
    keep(name, made);
    return made;
  }

 private:
  // Whatever is not as keep() writes it is made anew.
  std::optional<Step> find(const std::string& name) const {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file(name), ignored)) return std::nullopt;
    try {
      io::Json json = io::read_json(file(name));
      const io::Json kept = json.at("study");
      if (kept.at("inputs") != inputs_) return std::nullopt;
      Step step{.result = {},
                .picture = kept.at("picture"),
                .text = kept.at("text").get<std::string>(),
                .headline = kept.at("headline").get<std::string>(),
                .stations = {}};
      for (const io::Json& station : kept.at("stations"))
        step.stations.push_back(report::station_of(station));
      json.erase("study");
      step.result = std::move(json);
      return step;
    } catch (const io::Json::exception&) {
      return std::nullopt;
    } catch (const common::InputError&) {
      return std::nullopt;
    }
  }

  void keep(const std::string& name, const Step& step) const {
    io::Json json = step.result, stations = io::Json::array();
    for (const Station& station : step.stations) stations.push_back(report::to_json(station));
    json["study"] = {{"inputs", inputs_},
                     {"headline", step.headline},
                     {"stations", stations},
                     {"text", step.text},
                     {"picture", step.picture}};
    io::write_json(file(name), json);
  }

  std::filesystem::path folder_;
  std::string inputs_;
  Run& run_;
};

class Study {
 public:
  Study(const CampaignRequest& request, const std::filesystem::path& folder, const KeptFits& kept,
        Run& run, const calibration::ReadingsOverview* table)
      : table_(table),
        kept_(kept),
        run_(run),
        robot_(request.read_robot()),
        campaign_(request.read_campaign(robot_, run)),
        files_(folder, inputs_of(robot_, campaign_), run) {}

  io::Json all();

 private:
  io::Json inputs() const { return report::provenance(robot_); }
  const Comparison& comparison();
  Step check();
  Step compare();
  Step diagnose();
  Step adopt();
  Step adopt_found(const calibration::DiagnosisRecord& record);
  std::string robot_in_words(const calibration::DiagnosisRecord& record) const;
  Step calibrate();
  Step plan();
  Step study_again() const;
  Step do_first(const std::string& what) const;
  /// Errors of the geometry explain most of the error: they come before anything elastic.
  bool is_kinematic() const {
    return !diagnose_.result.value("by_kinematics", io::Json()).is_null();
  }
  std::size_t set_aside() const {
    return diagnose_.result.value("set_aside", io::Json::array()).size();
  }
  /// Readings were set aside, and nothing but noise is left of the others.
  bool is_explained_without_set_aside() const {
    const io::Json after = diagnose_.result.value("chi_square_after", io::Json());
    return set_aside() > 0 && after.is_object() &&
           after.value("p_value", 0.0) > calibration::certain_level;
  }
  bool is_of_wrong_columns() const {
    return diagnose_.result.value("verdict", "") == to_string(calibration::Verdict::unexplained) &&
           compare_.result.value("unit_error", io::Json()).is_string();
  }
  bool scatters_beyond_noise() const {
    const io::Json test = compare_.result.value("noise_check", io::Json());
    return test.is_object() && test.value("p_value", 1.0) < calibration::certain_level;
  }
  bool knows_noise() const { return compare_.result.value("noise", "") != "unknown"; }
  bool is_calibrated() const { return adopt_.result["command"] == "calibrate"; }
  std::string headline() const {
    return diagnose_.headline + (is_calibrated() ? " " + adopt_.headline : "");
  }
  io::Json summary(const std::vector<Station>& stations) const;
  io::Json files() const;
  void write_page(const std::vector<Station>& stations) const;
  std::string remarks() const;
  void print(const std::vector<Station>& stations) const;
  std::string why_inconclusive() const;

  const calibration::ReadingsOverview* table_;  // null where a campaign file was given
  KeptFits kept_;
  Run& run_;
  vjm::Robot robot_;
  Campaign campaign_;
  StudyFolder files_;
  std::optional<Comparison> comparison_;
  Step check_, compare_, diagnose_, adopt_, plan_;
};

const Comparison& Study::comparison() {
  if (!comparison_)
    comparison_ = calibration::compare(robot_, campaign_, run_.threads(), run_.progress());
  return *comparison_;
}

Step Study::check() {
  const auto checks = calibration::check_campaign(campaign_, robot_);
  const auto joints = calibration::joint_loads(campaign_, robot_.without_effects());
  io::Json result{{"command", "measure check"}, {"inputs", inputs()}};
  result.update(report::to_json(campaign_, checks, joints));
  return {.result = std::move(result),
          .picture = {},
          .text = report::first_screen(campaign_, checks, joints, ""),
          .headline = report::readings_in_words(campaign_, checks),
          .stations = {report::readings_station(campaign_, checks)}};
}

Step Study::compare() {
  const Comparison& both = comparison();
  io::Json result{{"command", "compare"}, {"inputs", inputs()}};
  result.update(report::to_json(campaign_, both));
  result["configurations"] = report::configurations(robot_, campaign_);
  return {.result = std::move(result),
          .picture = {},
          .text = report::first_screen(robot_, campaign_, both, ""),
          .headline = report::headline(both),
          .stations = {report::model_station(both), report::fitted_station(robot_, both)}};
}

Step Study::diagnose() {
  const calibration::DiagnosisOptions options;
  const calibration::Diagnosis found = resumable_diagnosis(robot_, campaign_, options, kept_, run_);
  io::Json result{{"command", "diagnose"}};
  result.update(diagnosis_result(robot_, campaign_, options, found));
  result["excluded"] = io::Json::array();
  for (const auto& [name, probability] : report::excluded(robot_, found, 6))
    result["excluded"].push_back({{"effect", name}, {"odds", report::odds(probability)}});
  result["not_observable"] = report::not_observable(found);
  std::optional<Comparison> after;
  if (!found.found.empty())
    after = calibration::compare(report::with_found(robot_, found), campaign_, run_.threads(),
                                 run_.progress());
  io::Json picture = diagnosis_picture(robot_, campaign_, comparison(), after ? &*after : nullptr);
  picture["robot"] = report::bent_robot_picture(robot_, campaign_, found);
  // Where nothing is established, no joint is to be looked at.
  if (after && found.verdict != calibration::Verdict::unexplained)
    picture["joint_curve"] = report::joint_curve_picture(robot_, campaign_, found, comparison(),
                                                         *after, run_.threads(), run_.progress());
  return {.result = std::move(result),
          .picture = std::move(picture),
          .text = report::first_screen(robot_, campaign_, found, ""),
          .headline = report::headline(robot_, campaign_, found),
          .stations = {report::missing_station(robot_, found)}};
}

// The geometry in bulk, where no single effect is to be adopted; then compared again.
Step Study::calibrate() {
  const calibration::KinematicCalibration found =
      calibration::calibrate_kinematics(robot_, campaign_, {}, run_.threads(), run_.progress());
  Step step{.result = {{"command", "calibrate"}, {"inputs", inputs()}},
            .picture = {},
            .text = report::first_screen(robot_, campaign_, found, ""),
            .headline = report::headline(campaign_, found),
            .stations = {}};
  step.result.update(report::to_json(campaign_, found));
  if (found.geometry.empty()) {
    step.stations = {report::not_adopted_station(step.headline, calibration::Verdict::unexplained)};
    return step;
  }
  const std::filesystem::path out = files_.file(robot_name);
  write_robot(out, calibrated_robot(robot_, io::read_text(robot_.file), campaign_, found));
  step.result["wrote"] = robot_name;
  const calibration::BeforeAfter both = calibration::compare_before_after(
      robot_, vjm::read_robot(out), campaign_, run_.threads(), run_.progress());
  step.result["error_over_noise"] = both.after.nominal.error_over_noise();
  step.result["held_out"] = both.held_out;
  step.result["waterfall"] = report::to_json(both.stages);
  step.stations = {report::adopted_station(robot_name, both.after)};
  return step;
}

// The file that was written; of a list of answers with the one that is in it.
std::string Study::robot_in_words(const calibration::DiagnosisRecord& record) const {
  if (record.verdict != calibration::Verdict::narrowed_down) return robot_name;
  std::vector<std::string> effects;
  for (const calibration::RecordedFinding& found : record.found)
    effects.push_back(fmt::format(
        "{} ({})",
        report::effect_in_words(robot_.without_effects(), found.effect.effect, found.effect.at),
        report::short_percent(found.probability)));
  return fmt::format("{} with {}", robot_name, report::listed(effects, "and"));
}

// What was found, or the stiffnesses alone where nothing is missing; then compared again.
Step Study::adopt_found(const calibration::DiagnosisRecord& record) {
  const bool is_needed = record.verdict != calibration::Verdict::none_needed;
  Step step{
      .result = {{"command", "adopt"}}, .picture = {}, .text = {}, .headline = {}, .stations = {}};
  const std::filesystem::path out = files_.file(robot_name);
  const Adopted adopted = write_adopted({.robot = robot_.file.string(),
                                         .diagnosis = files_.file(diagnosis_name).string(),
                                         .effect = "",
                                         .stiffnesses_only = !is_needed},
                                        out);
  const vjm::Robot calibrated = vjm::read_robot(out);
  const Comparison again =
      calibration::compare(calibrated, campaign_, run_.threads(), run_.progress());
  step.result.update(adopted.result);
  step.result["wrote"] = robot_name;
  step.result["compared_again"] = report::headline(again);
  step.result["still_fails"] = again.nominal.adequacy == calibration::Adequacy::inadequate;
  step.result["error_over_noise"] = nullptr;
  if (again.noise.source != calibration::NoiseSource::unknown)
    step.result["error_over_noise"] = again.nominal.error_over_noise();
  step.text = report::first_screen(calibrated, adopted.summary, "");
  step.headline = report::headline(calibrated, adopted.summary);
  step.stations = {report::adopted_station(robot_in_words(record), again,
                                           is_explained_without_set_aside() ? set_aside() : 0)};
  return step;
}

Step Study::adopt() {
  const calibration::DiagnosisRecord record = report::read_diagnosis(files_.file(diagnosis_name));
  const bool is_needed = record.verdict != calibration::Verdict::none_needed;
  try {
    return is_kinematic() ? calibrate() : adopt_found(record);
  } catch (const common::NotIdentifiable& refusal) {
    const std::string headline =
        !is_needed ? "nothing to adopt: nothing was fitted, nothing is missing"
        : record.verdict == calibration::Verdict::identified
            ? "nothing was adopted: with what was found the error does not fall"
            : "nothing was adopted: no effect is established";
    return {.result = {{"command", "adopt"}, {"reason", refusal.what()}},
            .picture = {},
            .text = report::wrapped(headline + "."),
            .headline = headline,
            .stations = {report::not_adopted_station(headline, record.verdict)}};
  }
}

// Which effect is left beside what was adopted.
Step Study::study_again() const {
  const std::string command = fmt::format(
      "kinetostat study {} {} -o {}", report::quoted(files_.file(robot_name).string()),
      report::quoted(campaign_.file.string()), report::quoted(files_.file("calibrated").string()));
  const std::string what = fmt::format("which effect is left? {}", command);
  return {.result = {{"command", "plan"}, {"inputs", inputs()}, {"reason", what}},
          .picture = {},
          .text = report::next_step(command, "which effect is left?"),
          .headline = what,
          .stations = {report::nothing_next_station(what)}};
}

// What has to be done before readings are any use.
Step Study::do_first(const std::string& what) const {
  return {.result = {{"command", "plan"}, {"inputs", inputs()}, {"reason", what}},
          .picture = {},
          .text = report::wrapped(what + "."),
          .headline = what,
          .stations = {report::nothing_next_station(what)}};
}

Step Study::plan() {
  if (is_calibrated()) return study_again();
  if (is_of_wrong_columns())
    return do_first(
        "correct that in the table, the campaign file or the robot file, and study again");
  Step step{.result = {{"command", "plan"}, {"inputs", inputs()}},
            .picture = {},
            .text = {},
            .headline = {},
            .stations = {}};
  const calibration::PlanOptions options;
  try {
    const calibration::DiagnosisRecord record = report::read_diagnosis(files_.file(diagnosis_name));
    const bool is_refused =
        record.verdict == calibration::Verdict::identified && adopt_.result.contains("reason");
    const calibration::PlanQuestion question = calibration::question_of(robot_, record, {});
    if (question.open.empty() && adopt_.result.value("still_fails", false)) {
      if (is_explained_without_set_aside())
        return do_first(
            "look at the readings that were set aside, mask what is wrong, and study again");
      if (record.verdict != calibration::Verdict::none_needed) return study_again();
      if (scatters_beyond_noise())
        return do_first("state the noise that repeated readings show, and study again");
    }
    if (question.open.empty() && record.verdict == calibration::Verdict::unexplained)
      return do_first(
          "look at where the error is, on the page: readings that distinguish effects of the "
          "catalogue do not find one that it lacks");
    const calibration::Plan plan =
        calibration::plan(robot_, campaign_, question, options, run_.threads(), run_.progress());
    step.result.update(report::to_json(question, options, plan));
    step.result["work_list"] = report::to_json(report::work_list(robot_, plan));
    if (!plan.blocks.empty()) {
      io::write_atomically(files_.file(table_name), report::plan_table(robot_, plan));
      step.result["wrote"] = table_name;
    }
    step.text = report::first_screen(robot_, question, options, plan, "");
    step.headline = report::headline(robot_, question, options, plan);
    step.stations = {
        !knows_noise() ? report::nothing_next_station(
                             "say how exact the readings are, or take some of them again")
        : is_refused ? report::nothing_next_station(
                           "look at the readings that were set aside, or take those again where "
                           "the effect acts most")
                     : report::next_station(robot_, question, plan)};
  } catch (const common::NotIdentifiable& refusal) {
    step.headline = std::string("nothing can be planned: ") + refusal.what();
    step.result["reason"] = refusal.what();
    step.text = report::wrapped(step.headline);
    step.stations = {report::nothing_next_station(step.headline)};
  }
  return step;
}

io::Json Study::files() const {
  io::Json list = io::Json::array();
  std::error_code ignored;
  for (const auto& [name, what] :
       {std::pair(robot_name, "the robot file with what was adopted"),
        std::pair(table_name, "the readings to take next"),
        std::pair(diagnosis_name, "the diagnosis, for 'adopt' and 'plan'"),
        std::pair("comparison.json", "every reading with its errors"),
        std::pair(drafted_campaign_name, "the campaign file, as the table was understood"),
        std::pair("study.json", "all of this for programs")})
    if (name == std::string("study.json") ||
        (std::filesystem::exists(files_.file(name), ignored) &&
         (table_ != nullptr || name != std::string(drafted_campaign_name))))
      list.push_back({{"file", name}, {"what", what}});
  return list;
}

io::Json Study::summary(const std::vector<Station>& stations) const {
  io::Json list = io::Json::array();
  for (const Station& station : stations) list.push_back(report::to_json(station));
  const auto of = [](const Step& step, const char* key) {
    return step.result.value(key, io::Json());
  };
  const Step& judged = is_calibrated() ? adopt_ : diagnose_;
  return {{"headline", headline()},
          {"inputs", inputs()},
          {"campaign_name", campaign_.name},
          {"campaign", report::occasion_json(campaign_)},
          {"about", check_.headline},
          {"stations", list},
          {"compared", compare_.headline},
          {"adopted", adopt_.headline},
          {"planned", plan_.headline},
          {"verdict", of(diagnose_, "verdict")},
          {"waterfall", of(judged, "waterfall")},
          {"held_out", of(judged, "held_out")},
          {"excluded", of(diagnose_, "excluded")},
          {"not_observable", of(diagnose_, "not_observable")},
          {"error_as_written", of(adopt_, "error_over_noise")},
          {"work_list", of(plan_, "work_list")},
          {"files", files()}};
}

void Study::write_page(const std::vector<Station>& stations) const {
  if (!report::has_pages()) return;
  io::Json study{{"command", "study"}};
  study.update(summary(stations));
  io::Json comparison = compare_.result;
  comparison.erase("readings");  // they are in the picture
  std::vector<report::PageResult> results{
      {.result = std::move(study), .picture = diagnose_.picture, .text = report::text(stations)},
      {.result = diagnose_.result,
       .picture = {{"readings", diagnose_.picture.value("readings", io::Json())}},
       .text = diagnose_.text},
      {.result = std::move(comparison), .picture = {}, .text = compare_.text}};
  if (table_ != nullptr) {
    io::Json readings{{"command", "readings"}};
    readings.update(report::readings_json(*table_));
    results.push_back(
        {.result = std::move(readings), .picture = {}, .text = report::readings_text(*table_)});
  }
  if (plan_.result.contains("cycles"))
    results.push_back({.result = plan_.result, .picture = {}, .text = plan_.text});
  std::string title = headline();
  for (std::size_t at = title.find("+-"); at != std::string::npos; at = title.find("+-", at))
    title.replace(at, 2, "\u00b1");
  io::write_atomically(files_.file(page_name), report::page(title, results));
}

// What qualifies the verdict, as `diagnose` says it below its headline.
std::string Study::remarks() const {
  constexpr std::size_t most = 2;
  std::string text;
  std::size_t said = 0;
  for (const io::Json& remark : diagnose_.result.value("remarks", io::Json::array()))
    if (const auto sentence = remark.get<std::string>();
        sentence != diagnose_.headline && said++ < most)
      text += report::wrapped(sentence, 0, 2);
  return text;
}

void Study::print(const std::vector<Station>& stations) const {
  run_.print(report::wrapped(headline()) + remarks() + "\n" + report::text(stations));
  if (table_ != nullptr)
    run_.print(fmt::format("campaign: {}\n", files_.file(drafted_campaign_name).string()));
  if (report::has_pages()) run_.print(fmt::format("page: {}\n", files_.file(page_name).string()));
  if (table_ != nullptr) run_.print_more("\n" + report::readings_text(*table_));
  for (const Step* step : {&check_, &compare_, &diagnose_, &adopt_, &plan_})
    run_.print_more("\n" + step->text);
}

std::string Study::why_inconclusive() const {
  if (knows_noise()) return "inconclusive: these data do not show which effect is missing";
  return fmt::format(
      "inconclusive: the noise is not known. {} 'noise: {{translation: 3 um}}' to {}, with the "
      "standard deviation of your instrument, or take readings several times",
      table_ != nullptr ? "Give --noise 3um, or add" : "Add", campaign_.file.string());
}

io::Json Study::all() {
  check_ = files_.step("check.json", "", [&] { return check(); });
  compare_ = files_.step("comparison.json", "", [&] { return compare(); });
  diagnose_ = files_.step(diagnosis_name, "", [&] { return diagnose(); });
  adopt_ = files_.step("adoption.json", robot_name, [&] { return adopt(); });
  plan_ = files_.step("plan.json", table_name, [&] { return plan(); });
  std::vector<Station> stations;
  for (const Step* step : {&check_, &compare_, &diagnose_, &adopt_, &plan_})
    stations.insert(stations.end(), step->stations.begin(), step->stations.end());
  io::Json json = summary(stations);
  io::write_json(files_.file("study.json"), json);
  write_page(stations);
  run_.draw(diagnose_.picture);
  print(stations);
  if (compare_.result.contains("refit_failure") && compare_.result["refit_failure"].is_string())
    run_.leave_unidentified(compare_.result["refit_failure"].get<std::string>());
  if (diagnose_.result.value("verdict", "") == to_string(calibration::Verdict::inconclusive))
    run_.leave_unidentified(why_inconclusive());
  return json;
}

// A table with the robot file beside it, in either order.
io::Json study_table(const TableRequest& table, const StudyRequest& request, Run& run) {
  const std::vector<std::string>& files = request.campaign.files;
  if (files.size() == 1)
    throw common::InputError(
        files[0], "a table names no robot",
        fmt::format("Write 'kinetostat study {} ROBOT.yaml -o {}'; 'kinetostat new robot' or "
                    "'kinetostat import' makes a robot file",
                    report::quoted(files[0]), report::quoted(run.out()->string())));
  const vjm::Robot robot = vjm::read_robot(files[0] == table.file ? files[1] : files[0]);
  const calibration::ReadingsOverview overview = table.look(&robot);
  const std::filesystem::path campaign =
      keep_drafted_campaign(table, overview, robot, *run.out(), run);
  return study_readings({.files = {robot.file.string(), campaign.string()}}, *run.out(),
                        request.kept, run, &overview);
}

// Also what does not look like one, where it stands before a robot file; empty where none is given.
std::string table_among(const std::vector<std::string>& files) {
  for (const std::string& file : files)
    if (io::document_kind(file) == io::DocumentKind::table) return file;
  const bool before_robot =
      files.size() == 2 && io::document_kind(files[1]) == io::DocumentKind::robot;
  return before_robot ? files[0] : "";
}

io::Json study(const StudyRequest& request, Run& run) {
  if (!run.out()) throw UsageError("--out", "the study has no folder", "Give -o DIR");
  const std::vector<std::string>& files = request.campaign.files;
  if (const std::string file = table_among(files); !file.empty()) {
    TableRequest table = request.table;
    table.file = file;
    return study_table(table, request, run);
  }
  if (request.table.says_something())
    throw UsageError("--column, --units, --displacement, --noise, --sheet",
                     "none of the files is a table",
                     "A campaign file says the same by its own keys");
  if (files.size() == 1 && io::document_kind(files.front()) == io::DocumentKind::robot)
    return study_design(files.front(), *run.out(), run);
  return study_readings(request.campaign, *run.out(), request.kept, run);
}

}  // namespace

io::Json study_readings(const CampaignRequest& campaign, const std::filesystem::path& folder,
                        const KeptFits& kept, Run& run,
                        const calibration::ReadingsOverview* table) {
  return Study(campaign, folder, kept, run, table).all();
}

void add_study(Program& program) {
  const auto request = std::make_shared<StudyRequest>();
  OptionList app = program.add(
      {.name = "study",
       .summary = "From readings to a model that explains them, or all about a robot: one page",
       .example = "kinetostat study data/measurements/nist_load_cell/campaign.yaml -o study",
       .out =
           "Write the page, the calibrated robot file, the readings to take next, and every step "
           "as JSON there; asked for again, it goes on where it stopped",
       .out_is_folder = true},
      [request](Run& run) { return study(*request, run); });
  app.add_option("files", request->campaign.files,
                 "Robot file (may be left out when the campaign names it) and campaign file; or a "
                 "table (CSV, .xlsx, .ods) and robot file; or a robot file alone")
      .type_name("[ROBOT] CAMPAIGN | TABLE ROBOT | ROBOT")
      .required()
      .count(1, 2);
  request->table.add_options(app);
  add_options(app, request->kept);
}

}  // namespace kinetostat::apps

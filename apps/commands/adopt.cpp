// kinetostat adopt, kinetostat revert: an effect that was found goes into the robot file, or out.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/version.h"
#include "kinetostat/apps/cli/write_robot.h"
#include "kinetostat/apps/commands/commands.h"
#include "kinetostat/apps/commands/diagnosis_steps.h"
#include "kinetostat/calibration/diagnosis/adoption.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/diagnosis.h"
#include "kinetostat/report/text.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::apps {
namespace {

using calibration::Adoption;

struct AdoptRequest {
  std::string robot, diagnosis, effect;
  bool all = false, force = false;
};

common::InputError not_a_diagnosis(const std::filesystem::path& file, const std::string& key,
                                   const std::string& why) {
  return common::InputError({.file = file,
                             .key = key,
                             .what = "this is not a diagnosis: " + why,
                             .cure = "Give a file that 'kinetostat diagnose -o FILE' wrote"});
}

const io::Json& need(const io::Json& json, const char* key, const std::string& file) {
  const auto found = json.find(key);
  if (found == json.end()) throw not_a_diagnosis(file, key, "the key is missing");
  return *found;
}

std::string name_of(const io::Json& entry) {
  return entry.at("effect").get<std::string>() + " at " + entry.at("at").get<std::string>();
}

std::string names_of(const std::vector<io::Json>& entries) {
  std::string names;
  for (const io::Json& entry : entries) names += (names.empty() ? "" : " and ") + name_of(entry);
  return names;
}

// The effects to adopt: all, or one by name, else the first that was found.
std::vector<io::Json> chosen(const io::Json& diagnosis, const AdoptRequest& request) {
  const io::Json& found = need(diagnosis, "found", request.diagnosis);
  if (request.all && !found.empty()) return {found.begin(), found.end()};
  std::string known;
  for (const io::Json& entry : found) {
    if (request.effect.empty() || request.effect == name_of(entry) ||
        request.effect == entry.at("effect").get<std::string>())
      return {entry};
    known += (known.empty() ? "'" : ", '") + name_of(entry) + "'";
  }
  if (known.empty())
    throw common::NotIdentifiable(
        fmt::format("{}: the verdict is '{}'; there is no effect to adopt", request.diagnosis,
                    report::verdict_in_words(
                        need(diagnosis, "verdict", request.diagnosis).get<std::string>())));
  throw UsageError("--effect", fmt::format("'{}' was not found by the diagnosis", request.effect),
                   fmt::format("It found {}", known));
}

// Held-out error before and after an effect, in units of the noise.
struct Fall {
  double before = std::numeric_limits<double>::quiet_NaN(), after = before;
};

Fall fall_of(const io::Json& diagnosis, const std::string& name, const std::string& file) {
  Fall fall;
  double last = fall.before;
  for (const io::Json& stage : need(diagnosis, "waterfall", file)) {
    const double error = stage.at("whitened").get<double>();
    if (stage.at("name").get<std::string>() == "+ " + name) fall = {last, error};
    last = error;
  }
  return fall;
}

bool has_stage(const io::Json& diagnosis, const std::string& name, const std::string& file) {
  const io::Json& stages = need(diagnosis, "waterfall", file);
  return std::any_of(stages.begin(), stages.end(),
                     [&](const io::Json& stage) { return stage.at("name") == name; });
}

void require_adequate(const io::Json& diagnosis, const std::vector<io::Json>& entries,
                      const Fall& fall, const std::string& file) {
  const auto verdict = need(diagnosis, "verdict", file).get<std::string>();
  if (calibration::verdict_named(verdict) == calibration::Verdict::unexplained)
    throw common::NotIdentifiable(fmt::format(
        "{}: the verdict is '{}': {} came nearest but does not explain these readings; it is not "
        "adopted. --force adopts it all the same.",
        file, verdict, names_of(entries)));
  if (fall.after < fall.before) return;
  throw common::NotIdentifiable(fmt::format(
      "{}: with {} the held-out error does not fall ({} before, {} after, times the noise); it "
      "is not adopted. --force adopts it all the same.",
      file, names_of(entries), report::number(fall.before, 4), report::number(fall.after, 4)));
}

std::vector<std::string> reasons_for(const io::Json& diagnosis, const io::Json& entry,
                                     const Fall& fall) {
  std::vector<std::string> reasons;
  reasons.push_back(fmt::format("by kinetostat {} from the campaign '{}', readings sha256 {}",
                                version(), diagnosis.at("campaign").get<std::string>(),
                                diagnosis.at("readings").get<std::string>()));
  reasons.push_back(
      fmt::format("verdict: {}; probability {}, chance of a false alarm {}",
                  report::verdict_in_words(diagnosis.at("verdict").get<std::string>()),
                  report::probability_in_words(entry.at("probability").get<double>()),
                  report::percent(entry.at("gate_p_value").get<double>())));
  reasons.push_back(fmt::format("held-out error, times the noise: {} before, {} after",
                                report::number(fall.before, 4), report::number(fall.after, 4)));
  for (const io::Json& p : entry.at("parameters"))
    reasons.push_back(fmt::format("prior of {}: {} +- {} {}", p.at("name").get<std::string>(),
                                  report::number(p.at("prior_mean").get<double>(), 4),
                                  report::number(p.at("prior_sd").get<double>(), 4),
                                  p.at("unit").get<std::string>()));
  return reasons;
}

Adoption adoption_of(const io::Json& diagnosis, const io::Json& entry, const Fall& fall) {
  Adoption adoption;
  adoption.effect = entry.at("effect").get<std::string>();
  adoption.at = entry.at("at").get<std::string>();
  const io::Json& parameters = entry.at("parameters");
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const io::Json& deviation = entry.at("deviations").at(k);
    adoption.values.push_back({.name = parameters[k].at("name").get<std::string>(),
                               .unit = parameters[k].at("unit").get<std::string>(),
                               .value = entry.at("values").at(k).get<double>(),
                               .deviation = deviation.is_null()
                                                ? std::numeric_limits<double>::quiet_NaN()
                                                : deviation.get<double>()});
  }
  adoption.reasons = reasons_for(diagnosis, entry, fall);
  return adoption;
}

// What a reader of the new robot file should know, in sentences.
std::vector<std::string> reservations(const io::Json& diagnosis,
                                      const std::vector<io::Json>& entries,
                                      const std::string& file) {
  std::vector<std::string> said;
  for (const io::Json& entry : entries)
    if (const io::Json& instead = need(entry, "instead", file); !instead.empty())
      said.push_back(fmt::format("{} may be something else: {}", name_of(entry),
                                 fmt::join(instead.get<std::vector<std::string>>(), "; ")));
  if (need(diagnosis, "or_something_else", file))
    said.push_back("it may be an effect outside the catalogue");
  std::vector<io::Json> left_out;
  for (const io::Json& found : need(diagnosis, "found", file))
    if (std::find(entries.begin(), entries.end(), found) == entries.end())
      left_out.push_back(found);
  if (!left_out.empty())
    said.push_back(fmt::format("found as well, not adopted: {} (--all adopts everything)",
                               names_of(left_out)));
  if (has_stage(diagnosis, "refitted", file))
    said.push_back(
        "parameters under 'uncertain' keep their values in the file: 'compare' and 'diagnose' fit "
        "them, other commands do not");
  return said;
}

io::Json adopt_from(const io::Json& diagnosis, const AdoptRequest& request,
                    const std::filesystem::path& out, Run& run) {
  const std::vector<io::Json> entries = chosen(diagnosis, request);
  if (!request.force) require_same_robot(diagnosis, request.diagnosis, request.robot);
  const auto fall_with = [&](const io::Json& entry) {
    return fall_of(diagnosis, name_of(entry), request.diagnosis);
  };
  const Fall fall{fall_with(entries.front()).before, fall_with(entries.back()).after};
  if (!request.force) require_adequate(diagnosis, entries, fall, request.diagnosis);
  std::string text = io::read_text(request.robot);
  try {
    for (const io::Json& entry : entries)
      text = calibration::adopted(text, adoption_of(diagnosis, entry, fall_with(entry)));
  } catch (const std::invalid_argument& error) {
    throw common::InputError({.file = request.robot, .key = "effects", .what = error.what()});
  }
  write_robot(out, text);
  run.print(fmt::format("{}: adopted {}; held-out error {} -> {} times the noise\n", out.string(),
                        names_of(entries), report::number(fall.before, 4),
                        report::number(fall.after, 4)));
  const std::vector<std::string> said = reservations(diagnosis, entries, request.diagnosis);
  for (const std::string& sentence : said) run.print("  " + sentence + "\n");
  io::Json adopted = io::Json::array();
  for (const io::Json& entry : entries)
    adopted.push_back({{"effect", entry.at("effect")}, {"at", entry.at("at")}});
  return {{"robot", out.string()},
          {"adopted", adopted},
          {"held_out_before", fall.before},
          {"held_out_after", fall.after},
          {"reservations", said}};
}

io::Json adopt(const AdoptRequest& request, const std::filesystem::path& out, Run& run) {
  const io::Json diagnosis = io::read_json(request.diagnosis);
  try {
    return adopt_from(diagnosis, request, out, run);
  } catch (const io::Json::exception& error) {
    throw not_a_diagnosis(request.diagnosis, "", error.what());
  }
}

io::Json revert(const std::string& robot, Run& run) {
  std::string text;
  try {
    text = calibration::reverted(io::read_text(robot));
  } catch (const std::invalid_argument& error) {
    throw common::InputError({.file = robot, .key = "effects", .what = error.what()});
  }
  const std::filesystem::path out = run.out() ? *run.out() : std::filesystem::path(robot);
  write_robot(out, text);
  run.print(fmt::format("{}: the effect that was adopted last is taken out\n", out.string()));
  return {{"robot", out.string()}};
}

}  // namespace

void require_same_robot(const io::Json& diagnosis, const std::filesystem::path& file,
                        const std::filesystem::path& robot) {
  const io::Json& inputs = need(diagnosis, "inputs", file.string());
  const io::Json::json_pointer at("/robot/sha256");
  if (!inputs.is_object() || !inputs.contains(at) || !inputs.at(at).is_string())
    throw not_a_diagnosis(file, "inputs.robot.sha256", "the key is missing");
  if (inputs.at(at) == io::sha256(io::read_text(robot))) return;
  throw common::InputError(
      {.file = file,
       .key = "inputs.robot",
       .what = fmt::format("the diagnosis is of another state of {}", robot.string()),
       .cure = "Run 'kinetostat diagnose -o' again on this robot file"});
}

io::Json adopt_effect(const std::filesystem::path& robot, const std::filesystem::path& diagnosis,
                      const std::string& effect, bool force, const std::filesystem::path& out,
                      Run& run) {
  return adopt(
      {.robot = robot.string(), .diagnosis = diagnosis.string(), .effect = effect, .force = force},
      out, run);
}

void add_adopt(Program& program) {
  const auto request = std::make_shared<AdoptRequest>();
  CLI::App& app = program.add(
      {.name = "adopt",
       .summary = "Write an effect that a diagnosis found into the robot file",
       .example = "kinetostat adopt data/robots/bench.yaml diagnosis.json -o better.yaml",
       .out = "Write the robot file there instead of changing it"},
      [request](Run& run) {
        return adopt(*request, run.out() ? *run.out() : std::filesystem::path(request->robot), run);
      });
  app.add_option("ROBOT", request->robot, "Robot file (YAML)")->required();
  app.add_option("DIAGNOSIS", request->diagnosis, "What 'diagnose -o' wrote (JSON)")->required();
  app.add_option("--effect", request->effect,
                 "Which of the effects that were found (default: the "
                 "first)")
      ->type_name("NAME");
  app.add_flag("--all", request->all, "All effects that were found, together")
      ->excludes("--effect");
  app.add_flag("--force", request->force,
               "Adopt it although the held-out error does not fall, the verdict is that none of "
               "the catalogue explains the readings, or the robot file has changed");
}

void add_revert(Program& program) {
  const auto robot = std::make_shared<std::string>();
  CLI::App& app =
      program.add({.name = "revert",
                   .summary = "Take the effect that was adopted last out of a robot file",
                   .example = "kinetostat revert better.yaml",
                   .out = "Write the robot file there instead of changing it"},
                  [robot](Run& run) { return revert(*robot, run); });
  app.add_option("ROBOT", *robot, "Robot file (YAML)")->required();
}

}  // namespace kinetostat::apps

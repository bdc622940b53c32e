// kinetostat adopt, kinetostat revert: what a diagnosis found goes into the robot file, or out.
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
#include "kinetostat/calibration/comparison/waterfall.h"
#include "kinetostat/calibration/diagnosis/adoption.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/diagnosis.h"
#include "kinetostat/report/text.h"
#include "kinetostat/spatial/units.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::apps {
namespace {

using calibration::AdoptedEffect;
using calibration::AdoptedParameter;
using calibration::AdoptedValue;
using calibration::Adoption;

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

struct AdoptRequest {
  std::string robot, diagnosis, effect;
  bool force = false;
  bool effects_only = false;      // the stiffnesses stay as the file has them
  bool stiffnesses_only = false;  // as fitted without any effect
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

// The effects to adopt: all that were found, or one by name.
std::vector<io::Json> effects_to_adopt(const io::Json& diagnosis, const AdoptRequest& request) {
  const io::Json& found = need(diagnosis, "found", request.diagnosis);
  if (request.stiffnesses_only) return {};
  if (found.empty())
    throw common::NotIdentifiable(
        fmt::format("{}: the verdict is '{}'; there is no effect to adopt; --stiffnesses-only "
                    "writes the fitted stiffnesses without one",
                    request.diagnosis,
                    report::verdict_in_words(
                        need(diagnosis, "verdict", request.diagnosis).get<std::string>())));
  if (request.effect.empty()) return {found.begin(), found.end()};
  std::string known;
  for (const io::Json& entry : found) {
    if (request.effect == name_of(entry) || request.effect == entry.at("effect").get<std::string>())
      return {entry};
    known += (known.empty() ? "'" : ", '") + name_of(entry) + "'";
  }
  throw UsageError("--effect", fmt::format("'{}' was not found by the diagnosis", request.effect),
                   fmt::format("It found {}", known));
}

// Held-out error before and after an effect, in units of the noise.
struct Fall {
  double before = unknown, after = unknown;
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

// Error of a stage of the waterfall; NaN where it has none of that name.
double error_of_stage(const io::Json& diagnosis, const std::string& name, const std::string& file) {
  for (const io::Json& stage : need(diagnosis, "waterfall", file))
    if (stage.at("name") == name) return stage.at("whitened").get<double>();
  return unknown;
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

double number_or_unknown(const io::Json& json) {
  return json.is_null() ? unknown : json.get<double>();
}

// A value and its deviation in the file's unit, where that is a length, an angle or a force.
AdoptedValue in_units_of(const spatial::UnitSystem& units, AdoptedValue v) {
  if (v.unit.empty()) return v;
  const spatial::Unit stated = spatial::parse_unit(v.unit);
  for (const auto& [dimension, unit] :
       {std::pair(spatial::dimension::length, units.length),
        std::pair(spatial::dimension::angle, units.angle),
        std::pair(spatial::dimension::force, units.force),
        std::pair(spatial::dimension::linear_stiffness, units.force + "/" + units.length)}) {
    if (stated.dimension != dimension) continue;
    const double factor = stated.factor / spatial::parse_unit(unit).factor;
    return {v.name, unit, v.value * factor, v.deviation * factor};
  }
  return v;
}

AdoptedEffect effect_of(const io::Json& diagnosis, const io::Json& entry, const Fall& fall,
                        const spatial::UnitSystem& units) {
  AdoptedEffect adopted;
  adopted.effect = entry.at("effect").get<std::string>();
  adopted.at = entry.at("at").get<std::string>();
  const io::Json& parameters = entry.at("parameters");
  for (std::size_t k = 0; k < parameters.size(); ++k)
    adopted.values.push_back(
        in_units_of(units, {.name = parameters[k].at("name").get<std::string>(),
                            .unit = parameters[k].at("unit").get<std::string>(),
                            .value = entry.at("values").at(k).get<double>(),
                            .deviation = number_or_unknown(entry.at("deviations").at(k))}));
  adopted.reasons = reasons_for(diagnosis, entry, fall);
  return adopted;
}

// "was 6e+04, is 5.239e+04 +- 250 N m/rad"
std::string remark_on(const io::Json& estimate, double deviation,
                      const spatial::UnitSystem& units) {
  if (!estimate.contains("designed") || !estimate.contains("unit")) return {};
  const auto unit = estimate.at("unit").get<std::string>();
  const AdoptedValue was =
      in_units_of(units, {"", unit, estimate.at("designed").get<double>(), unknown});
  const AdoptedValue is =
      in_units_of(units, {"", unit, estimate.at("fitted").get<double>(), deviation});
  return fmt::format("was {}, is {}{}{}", report::number(was.value, 6), report::number(is.value, 4),
                     std::isnan(is.deviation) ? "" : " +- " + report::number(is.deviation, 2),
                     is.unit.empty() ? "" : " " + is.unit);
}

AdoptedParameter parameter_of(const io::Json& estimate, const spatial::UnitSystem& units) {
  const bool at_bound = !estimate.at("bound").is_null();
  AdoptedParameter adopted;
  const auto deviation = [&](const char* key) {
    return at_bound || !estimate.contains(key) ? unknown : number_or_unknown(estimate.at(key));
  };
  adopted.remark = remark_on(estimate, deviation("standard_error"), units);
  if (estimate.contains("effect")) {
    adopted.effect = estimate.at("effect").get<std::string>();
    adopted.at = estimate.at("at").get<std::string>();
    adopted.parameter = estimate.at("value_of").get<std::string>();
    adopted.value =
        in_units_of(units, {"value", estimate.at("unit").get<std::string>(),
                            estimate.at("fitted").get<double>(), deviation("standard_error")});
    return adopted;
  }
  const auto factor = estimate.at("factor").get<double>();
  adopted.stiffness = estimate.at("stiffness").get<std::string>();
  adopted.value = {"factor", "", factor, factor * deviation("standard_error_of_log_factor")};
  return adopted;
}

// What was fitted with the effects (or without any) and goes into the file with them; nothing that
// was kept as the file has it.
std::vector<AdoptedParameter> fitted_with(const io::Json& diagnosis, const AdoptRequest& request,
                                          std::size_t effects, const spatial::UnitSystem& units) {
  std::vector<AdoptedParameter> adopted;
  const auto fitted = diagnosis.find("fitted");
  if (request.effects_only || fitted == diagnosis.end()) return adopted;
  if (!request.stiffnesses_only && effects < diagnosis.at("found").size()) return adopted;
  for (const io::Json& estimate :
       fitted->at(request.stiffnesses_only ? "without_effects" : "with_effects"))
    if (estimate.at("bound") != "kept") adopted.push_back(parameter_of(estimate, units));
  return adopted;
}

std::string name_of(const AdoptedParameter& p) {
  return p.effect.empty() ? p.stiffness
                          : fmt::format("{} of {} at {}", p.parameter, p.effect, p.at);
}

std::string names_of(const std::vector<AdoptedParameter>& parameters) {
  std::vector<std::string> names;
  for (const AdoptedParameter& p : parameters) names.push_back(name_of(p));
  return fmt::format("{}", fmt::join(names, ", "));
}

// What a reader of the new robot file should know, in sentences.
std::vector<std::string> reservations(const io::Json& diagnosis,
                                      const std::vector<io::Json>& entries,
                                      const Adoption& adoption, const std::string& file) {
  std::vector<std::string> said;
  for (const io::Json& entry : entries)
    if (const io::Json& instead = need(entry, "instead", file); !instead.empty())
      said.push_back(fmt::format("{} may be something else: {}", name_of(entry),
                                 fmt::join(instead.get<std::vector<std::string>>(), "; ")));
  if (!entries.empty() && need(diagnosis, "or_something_else", file))
    said.push_back("it may be an effect outside the catalogue");
  std::vector<io::Json> left_out;
  for (const io::Json& found : need(diagnosis, "found", file))
    if (std::find(entries.begin(), entries.end(), found) == entries.end())
      left_out.push_back(found);
  if (!left_out.empty())
    said.push_back(fmt::format("found as well, not adopted: {}", names_of(left_out)));
  if (adoption.fitted.empty() && !std::isnan(error_of_stage(diagnosis, "refitted", file)))
    said.push_back(
        "parameters under 'uncertain' keep their values in the file, so that the error there is "
        "not the one that the diagnosis shows: 'compare' and 'diagnose' fit them, other commands "
        "do not");
  if (const auto aside = diagnosis.find("set_aside"); aside != diagnosis.end() && !aside->empty())
    said.push_back(fmt::format("{} readings were set aside in the search, and count in that error",
                               aside->size()));
  return said;
}

std::string sentence(const std::filesystem::path& out, const std::vector<io::Json>& entries,
                     const Adoption& adoption, const Fall& fall) {
  std::vector<std::string> what;
  if (!entries.empty()) what.push_back(names_of(entries));
  if (!adoption.fitted.empty()) what.push_back("fitted values of " + names_of(adoption.fitted));
  std::string text = fmt::format("{}: adopted {}", out.string(), fmt::join(what, ", with "));
  if (!entries.empty())
    text += fmt::format("; held-out error {} -> {} times the noise", report::number(fall.before, 4),
                        report::number(fall.after, 4));
  return text + "\n";
}

// The error of the file as it is written, where that is the model that the diagnosis ended with.
double error_as_written(const io::Json& diagnosis, const AdoptRequest& request,
                        const Adoption& adoption) {
  const bool is_whole = !adoption.effects.empty() && !request.effects_only &&
                        adoption.effects.size() == diagnosis.at("found").size();
  return is_whole ? error_of_stage(diagnosis, calibration::as_adopted, request.diagnosis) : unknown;
}

// An adoption, the effects in it as the diagnosis has them, and what they do to the error.
struct Chosen {
  std::vector<io::Json> entries;
  Adoption adoption;
  Fall fall;
};

Chosen adoption_from(const io::Json& diagnosis, const AdoptRequest& request) {
  Chosen chosen{.entries = effects_to_adopt(diagnosis, request), .adoption = {}, .fall = {}};
  if (!request.force) require_same_robot(diagnosis, request.diagnosis, request.robot);
  const auto fall_with = [&](const io::Json& entry) {
    return fall_of(diagnosis, name_of(entry), request.diagnosis);
  };
  if (!chosen.entries.empty()) {
    chosen.fall = {fall_with(chosen.entries.front()).before,
                   fall_with(chosen.entries.back()).after};
    if (!request.force) require_adequate(diagnosis, chosen.entries, chosen.fall, request.diagnosis);
  }
  const spatial::UnitSystem units = vjm::read_robot(request.robot).units;
  for (const io::Json& entry : chosen.entries)
    chosen.adoption.effects.push_back(effect_of(diagnosis, entry, fall_with(entry), units));
  chosen.adoption.fitted = fitted_with(diagnosis, request, chosen.entries.size(), units);
  if (chosen.entries.empty() && chosen.adoption.fitted.empty())
    throw common::NotIdentifiable(
        fmt::format("{}: nothing was fitted that could be adopted", request.diagnosis));
  return chosen;
}

io::Json adopt_from(const io::Json& diagnosis, const AdoptRequest& request,
                    const std::filesystem::path& out, Run& run) {
  const auto [entries, adoption, fall] = adoption_from(diagnosis, request);
  try {
    write_robot(out, calibration::adopted(io::read_text(request.robot), adoption));
  } catch (const std::invalid_argument& error) {
    throw common::InputError({.file = request.robot, .what = error.what()});
  }
  run.print(sentence(out, entries, adoption, fall));
  const double as_written = error_as_written(diagnosis, request, adoption);
  if (!std::isnan(as_written))
    run.print(fmt::format("  as written: {} times the noise on all these readings\n",
                          report::number(as_written, 4)));
  const std::vector<std::string> said =
      reservations(diagnosis, entries, adoption, request.diagnosis);
  for (const std::string& one : said) run.print("  " + one + "\n");
  io::Json effects = io::Json::array(), fitted = io::Json::array();
  for (const io::Json& entry : entries)
    effects.push_back({{"effect", entry.at("effect")}, {"at", entry.at("at")}});
  for (const AdoptedParameter& p : adoption.fitted) fitted.push_back(name_of(p));
  const auto known = [](double x) { return std::isnan(x) ? io::Json() : io::Json(x); };
  return {{"robot", out.string()},
          {"adopted", effects},
          {"fitted", fitted},
          {"held_out_before", known(fall.before)},
          {"held_out_after", known(fall.after)},
          {"error_as_written", known(as_written)},
          {"reservations", said}};
}

io::Json adopt(const AdoptRequest& request, const std::filesystem::path& out, Run& run) {
  const io::Json diagnosis = io::read_json(request.diagnosis);
  try {
    return adopt_from(diagnosis, request, out, run);
  } catch (const io::Json::exception& error) {
    throw not_a_diagnosis(request.diagnosis, "", error.what());
  } catch (const std::invalid_argument& error) {  // a unit that is none
    throw not_a_diagnosis(request.diagnosis, "", error.what());
  }
}

io::Json revert(const std::string& robot, Run& run) {
  std::string text;
  try {
    text = calibration::reverted(io::read_text(robot));
  } catch (const std::invalid_argument& error) {
    throw common::InputError({.file = robot, .what = error.what()});
  }
  const std::filesystem::path out = run.out() ? *run.out() : std::filesystem::path(robot);
  write_robot(out, text);
  run.print(fmt::format("{}: what was adopted last is taken out\n", out.string()));
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
       .summary = "Write what a diagnosis found and fitted into the robot file",
       .example = "kinetostat adopt data/robots/bench.yaml diagnosis.json -o better.yaml",
       .out = "Write the robot file there instead of changing it"},
      [request](Run& run) {
        return adopt(*request, run.out() ? *run.out() : std::filesystem::path(request->robot), run);
      });
  app.add_option("ROBOT", request->robot, "Robot file (YAML)")->required();
  app.add_option("DIAGNOSIS", request->diagnosis, "What 'diagnose -o' wrote (JSON)")->required();
  app.add_option("--effect", request->effect,
                 "One of the effects that were found, with the stiffnesses as they are (default: "
                 "all, with the stiffnesses that were fitted beside them)")
      ->type_name("NAME");
  app.add_flag("--all")
      ->description("All effects that were found (the default)")
      ->excludes("--effect");
  CLI::Option* effects_only = app.add_flag("--effects-only", request->effects_only,
                                           "Leave stiffnesses as the robot file has them");
  app.add_flag("--stiffnesses-only", request->stiffnesses_only,
               "Write the stiffnesses that were fitted without any effect, and no effect")
      ->excludes("--effect")
      ->excludes(effects_only);
  app.add_flag("--force", request->force,
               "Adopt it although the held-out error does not fall, the verdict is that none of "
               "the catalogue explains the readings, or the robot file has changed");
}

void add_revert(Program& program) {
  const auto robot = std::make_shared<std::string>();
  CLI::App& app = program.add({.name = "revert",
                               .summary = "Take what was adopted last out of a robot file",
                               .example = "kinetostat revert better.yaml",
                               .out = "Write the robot file there instead of changing it"},
                              [robot](Run& run) { return revert(*robot, run); });
  app.add_option("ROBOT", *robot, "Robot file (YAML)")->required();
}

}  // namespace kinetostat::apps

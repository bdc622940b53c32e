#include "kinetostat/apps/results/adoption.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/version.h"
#include "kinetostat/apps/cli/write_robot.h"
#include "kinetostat/calibration/comparison/waterfall.h"
#include "kinetostat/calibration/diagnosis/adoption.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/diagnosis_file.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/report/text/text.h"
#include "kinetostat/spatial/units.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::apps {
namespace {

using calibration::AdoptedEffect;
using calibration::AdoptedParameter;
using calibration::AdoptedValue;
using calibration::Adoption;
using calibration::DiagnosisRecord;
using calibration::in_units_of;
using calibration::RecordedEstimate;
using calibration::RecordedFinding;

constexpr double unknown = calibration::not_recorded;

std::string names_of(const std::vector<RecordedFinding>& found) {
  std::vector<std::string> names;
  names.reserve(found.size());
  for (const RecordedFinding& one : found) names.push_back(one.effect.name());
  return fmt::format("{}", fmt::join(names, " and "));
}

// The effects to adopt: all that were found, or one by name.
std::vector<RecordedFinding> effects_to_adopt(const DiagnosisRecord& diagnosis,
                                              const AdoptRequest& request) {
  if (request.stiffnesses_only) return {};
  if (diagnosis.found.empty())
    throw common::NotIdentifiable(
        fmt::format("{}: the verdict is '{}'; there is no effect to adopt; --stiffnesses-only "
                    "writes the fitted stiffnesses without one",
                    request.diagnosis, to_string(diagnosis.verdict)));
  if (request.effect.empty()) return diagnosis.found;
  std::string known;
  for (const RecordedFinding& one : diagnosis.found) {
    if (request.effect == one.effect.name() || request.effect == one.effect.effect) return {one};
    known += (known.empty() ? "'" : ", '") + one.effect.name() + "'";
  }
  throw UsageError("--effect", fmt::format("'{}' was not found by the diagnosis", request.effect),
                   fmt::format("It found {}", known));
}

// Held-out error before and after an effect, in units of the noise.
struct Fall {
  double before = unknown, after = unknown;
};

Fall fall_of(const DiagnosisRecord& diagnosis, const std::string& name) {
  Fall fall;
  double last = fall.before;
  for (const calibration::RecordedStage& stage : diagnosis.waterfall) {
    if (stage.name == "+ " + name) fall = {last, stage.error};
    last = stage.error;
  }
  return fall;
}

void require_adequate(const DiagnosisRecord& diagnosis, const std::vector<RecordedFinding>& chosen,
                      const Fall& fall) {
  if (diagnosis.verdict == calibration::Verdict::unexplained)
    throw common::NotIdentifiable(fmt::format(
        "{}: the verdict is '{}': {} came nearest but does not explain these readings; it is not "
        "adopted. --force adopts it all the same.",
        diagnosis.file.string(), to_string(diagnosis.verdict), names_of(chosen)));
  const calibration::RecordedStage written = diagnosis.stage_of(calibration::as_adopted);
  if (written.error >= written.before)
    throw common::NotIdentifiable(fmt::format(
        "{}: with {} the error on all readings does not fall ({} before, {} after, times the "
        "noise){}; it is not adopted. --force adopts it all the same.",
        diagnosis.file.string(), names_of(chosen), report::number(written.before, 4),
        report::number(written.error, 4),
        diagnosis.set_aside > 0
            ? fmt::format(", though it does without the {} readings that were set aside",
                          diagnosis.set_aside)
            : ""));
  if (fall.after < fall.before) return;
  throw common::NotIdentifiable(fmt::format(
      "{}: with {} the held-out error does not fall ({} before, {} after, times the noise); it "
      "is not adopted. --force adopts it all the same.",
      diagnosis.file.string(), names_of(chosen), report::number(fall.before, 4),
      report::number(fall.after, 4)));
}

std::vector<std::string> reasons_for(const DiagnosisRecord& diagnosis, const RecordedFinding& found,
                                     const Fall& fall) {
  std::vector<std::string> reasons;
  reasons.push_back(fmt::format("by kinetostat {} from the campaign '{}', readings sha256 {}",
                                version(), diagnosis.campaign, diagnosis.readings_sha256));
  reasons.push_back(fmt::format(
      "verdict: {}; probability {}, chance of a false alarm {}", to_string(diagnosis.verdict),
      report::probability_in_words(found.probability), report::percent(found.false_alarm_chance)));
  reasons.push_back(fmt::format("held-out error, times the noise: {} before, {} after",
                                report::number(fall.before, 4), report::number(fall.after, 4)));
  for (const calibration::RecordedParameter& p : found.effect.parameters)
    reasons.push_back(fmt::format("prior of {}: {} +- {} {}", p.name,
                                  report::number(p.prior_mean, 4), report::number(p.prior_sd, 4),
                                  p.unit));
  return reasons;
}

AdoptedEffect effect_of(const DiagnosisRecord& diagnosis, const RecordedFinding& found,
                        const Fall& fall, const spatial::UnitSystem& units) {
  AdoptedEffect adopted;
  adopted.effect = found.effect.effect;
  adopted.at = found.effect.at;
  for (std::size_t k = 0; k < found.effect.parameters.size(); ++k)
    adopted.values.push_back(in_units_of(units, {.name = found.effect.parameters[k].name,
                                                 .unit = found.effect.parameters[k].unit,
                                                 .value = found.effect.values[k],
                                                 .deviation = found.effect.deviations[k]}));
  adopted.reasons = reasons_for(diagnosis, found, fall);
  return adopted;
}

// "was 6e+04, is 5.239e+04 +- 250 N m/rad"
std::string remark_on(const RecordedEstimate& estimate, double deviation,
                      const spatial::UnitSystem& units) {
  if (std::isnan(estimate.designed) || std::isnan(estimate.fitted)) return {};
  const AdoptedValue was = in_units_of(units, {"", estimate.unit, estimate.designed, unknown});
  const AdoptedValue is = in_units_of(units, {"", estimate.unit, estimate.fitted, deviation});
  return fmt::format("was {}, is {}{}{}", report::number(was.value, 6), report::number(is.value, 4),
                     std::isnan(is.deviation) ? "" : " +- " + report::number(is.deviation, 2),
                     is.unit.empty() ? "" : " " + is.unit);
}

AdoptedParameter parameter_of(const RecordedEstimate& estimate, const spatial::UnitSystem& units) {
  const auto deviation = [&](double known) { return estimate.is_at_bound ? unknown : known; };
  AdoptedParameter adopted;
  adopted.remark = remark_on(estimate, deviation(estimate.standard_error), units);
  if (!estimate.effect.empty()) {
    adopted.effect = estimate.effect;
    adopted.at = estimate.at;
    adopted.parameter = estimate.value_of;
    adopted.value = in_units_of(
        units, {"value", estimate.unit, estimate.fitted, deviation(estimate.standard_error)});
    return adopted;
  }
  adopted.stiffness = estimate.stiffness;
  adopted.value = {"factor", "", estimate.factor,
                   estimate.factor * deviation(estimate.standard_error_of_log_factor)};
  return adopted;
}

// What was fitted with the effects (or without any) and goes into the file with them; nothing that
// was kept as the file has it.
std::vector<AdoptedParameter> fitted_with(const DiagnosisRecord& diagnosis,
                                          const AdoptRequest& request, std::size_t effects,
                                          const spatial::UnitSystem& units) {
  std::vector<AdoptedParameter> adopted;
  if (request.effects_only) return adopted;
  if (!request.stiffnesses_only && effects < diagnosis.found.size()) return adopted;
  for (const RecordedEstimate& estimate :
       request.stiffnesses_only ? diagnosis.fitted_without : diagnosis.fitted_beside)
    if (!estimate.is_kept) adopted.push_back(parameter_of(estimate, units));
  return adopted;
}

// The names that what is adopted with a standard deviation has as a source of uncertainty.
std::vector<std::string> sources_of(const Adoption& adoption, const vjm::EffectKinds& kinds) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& effect, const std::string& at,
                       const std::string& parameter, double deviation) {
    if (deviation > 0 && vjm::effect_kind(effect, kinds)->acts_on_chains())
      names.push_back(fmt::format("{} of {} at {}", parameter, effect, at));
  };
  for (const AdoptedEffect& e : adoption.effects)
    for (const AdoptedValue& v : e.values) add(e.effect, e.at, v.name, v.deviation);
  for (const AdoptedParameter& p : adoption.fitted)
    if (!p.effect.empty())
      add(p.effect, p.at, p.parameter, p.value.deviation);
    else if (p.value.deviation > 0)
      names.push_back(vjm::fitted_source(p.stiffness));
  return names;
}

std::string name_of(const AdoptedParameter& p) {
  return p.effect.empty() ? p.stiffness
                          : fmt::format("{} of {} at {}", p.parameter, p.effect, p.at);
}

// Of an effect that is not of the robot: what becomes of it in a robot file.
std::string reservation_of_measuring(const vjm::EffectKind& kind, const std::string& name) {
  using vjm::NamesReadings;
  const bool is_of_moments = std::any_of(
      kind.parameters.begin(), kind.parameters.end(), [](const vjm::EffectParameter& p) {
        return p.names_readings != NamesReadings::no && p.names_readings != NamesReadings::axes;
      });
  return name +
         (is_of_moments
              ? " is of the session that it names: compare other readings with a file without it"
              : " is of how it was measured, not of the robot: 'compare' and 'diagnose' count with "
                "it, and no stiffness changes");
}

// What a reader of the new robot file should know, in sentences.
std::vector<std::string> reservations(const DiagnosisRecord& diagnosis,
                                      const std::vector<RecordedFinding>& chosen,
                                      const Adoption& adoption, const vjm::Robot& robot) {
  std::vector<std::string> said;
  for (const RecordedFinding& one : chosen)
    if (!one.instead.empty())
      said.push_back(fmt::format("{} may be something else: {}", one.effect.name(),
                                 fmt::join(one.instead, "; ")));
  for (const RecordedFinding& one : chosen) {
    const auto kind = vjm::effect_kind(one.effect.effect, robot.kinds());
    if (kind->place == vjm::EffectPlace::sensor || kind->place == vjm::EffectPlace::load)
      said.push_back(reservation_of_measuring(
          *kind,
          report::effect_in_words(robot.without_effects(), one.effect.effect, one.effect.at)));
  }
  if (!chosen.empty() && diagnosis.or_something_else)
    said.push_back("it may be an effect outside the catalogue");
  std::vector<RecordedFinding> left_out;
  for (const RecordedFinding& found : diagnosis.found)
    if (std::none_of(chosen.begin(), chosen.end(), [&](const RecordedFinding& one) {
          return one.effect.name() == found.effect.name();
        }))
      left_out.push_back(found);
  if (!left_out.empty())
    said.push_back(fmt::format("found as well, not adopted: {}", names_of(left_out)));
  if (adoption.fitted.empty() && !std::isnan(diagnosis.stage_of("refitted").error))
    said.push_back(
        "parameters under 'uncertain' keep their values in the file, so that the error there is "
        "not the one that the diagnosis shows: 'compare' and 'diagnose' fit them, other commands "
        "do not");
  if (diagnosis.set_aside > 0)
    said.push_back(fmt::format("{} readings were set aside in the search, and count in that error",
                               diagnosis.set_aside));
  return said;
}

// The error of the file as it is written, where that is the model that the diagnosis ended with.
double error_as_written(const DiagnosisRecord& diagnosis, const AdoptRequest& request,
                        const Adoption& adoption) {
  const bool is_whole = !adoption.effects.empty() && !request.effects_only &&
                        adoption.effects.size() == diagnosis.found.size();
  return is_whole ? diagnosis.stage_of(calibration::as_adopted).error : unknown;
}

// An adoption, the effects in it as the diagnosis has them, and what they do to the error.
struct Chosen {
  std::vector<RecordedFinding> found;
  Adoption adoption;
  Fall fall;
};

// Of what was fitted together, where all of it is adopted.
void add_correlation_of(const DiagnosisRecord& diagnosis, const AdoptRequest& request,
                        const vjm::Robot& robot, Chosen& chosen) {
  if (chosen.found.size() < diagnosis.found.size() && !request.stiffnesses_only) return;
  const calibration::EstimateCorrelation& all =
      request.stiffnesses_only ? diagnosis.correlation_without : diagnosis.correlation_beside;
  add_correlation(robot, all.only(sources_of(chosen.adoption, robot.kinds())), chosen.adoption);
}

Chosen adoption_from(const DiagnosisRecord& diagnosis, const AdoptRequest& request) {
  Chosen chosen{.found = effects_to_adopt(diagnosis, request), .adoption = {}, .fall = {}};
  if (!request.force) require_same_robot(diagnosis, request.robot);
  const auto fall_with = [&](const RecordedFinding& one) {
    return fall_of(diagnosis, one.effect.name());
  };
  if (!chosen.found.empty()) {
    chosen.fall = {fall_with(chosen.found.front()).before, fall_with(chosen.found.back()).after};
    if (!request.force) require_adequate(diagnosis, chosen.found, chosen.fall);
  }
  const vjm::Robot robot = vjm::read_robot(request.robot, request.reading);
  const spatial::UnitSystem& units = robot.units;
  try {
    for (const RecordedFinding& one : chosen.found)
      chosen.adoption.effects.push_back(effect_of(diagnosis, one, fall_with(one), units));
    chosen.adoption.fitted = fitted_with(diagnosis, request, chosen.found.size(), units);
    add_correlation_of(diagnosis, request, robot, chosen);
  } catch (const std::invalid_argument& error) {  // a unit that is none
    throw common::InputError({.file = request.diagnosis,
                              .what = fmt::format("this is not a diagnosis: {}", error.what()),
                              .cure = "Give a file that 'kinetostat diagnose -o FILE' wrote"});
  }
  if (chosen.found.empty() && chosen.adoption.fitted.empty())
    throw common::NotIdentifiable(
        fmt::format("{}: nothing was fitted that could be adopted", request.diagnosis));
  return chosen;
}

io::Json result_of(const Chosen& chosen, const std::filesystem::path& out, double as_written,
                   const std::vector<std::string>& said) {
  io::Json effects = io::Json::array(), fitted = io::Json::array();
  for (const RecordedFinding& one : chosen.found)
    effects.push_back({{"effect", one.effect.effect}, {"at", one.effect.at}});
  for (const AdoptedParameter& p : chosen.adoption.fitted) fitted.push_back(name_of(p));
  const auto known = [](double x) { return std::isnan(x) ? io::Json() : io::Json(x); };
  return {{"robot", out.string()},
          {"adopted", effects},
          {"fitted", fitted},
          {"held_out_before", known(chosen.fall.before)},
          {"held_out_after", known(chosen.fall.after)},
          {"error_as_written", known(as_written)},
          {"reservations", said}};
}

report::AdoptionSummary summary_of(const DiagnosisRecord& diagnosis, const Chosen& chosen,
                                   const vjm::Robot& robot, double as_written,
                                   const std::vector<std::string>& said) {
  report::AdoptionSummary summary{.file = robot.file,
                                  .effects = {},
                                  .fitted = chosen.adoption.fitted,
                                  .nominal = diagnosis.stage_of(calibration::as_adopted).before,
                                  .before = chosen.fall.before,
                                  .after = chosen.fall.after,
                                  .as_written = as_written,
                                  .reservations = said};
  for (const RecordedFinding& one : chosen.found)
    summary.effects.push_back(
        report::effect_in_words(robot.without_effects(), one.effect.effect, one.effect.at));
  return summary;
}

}  // namespace

void require_same_robot(const DiagnosisRecord& diagnosis, const std::filesystem::path& robot) {
  if (diagnosis.robot_sha256.empty())
    throw common::InputError({.file = diagnosis.file,
                              .key = "inputs.robot.sha256",
                              .what = "this is not a diagnosis: the key is missing",
                              .cure = "Give a file that 'kinetostat diagnose -o FILE' wrote"});
  if (diagnosis.robot_sha256 == io::sha256(io::read_text(robot))) return;
  throw common::InputError(
      {.file = diagnosis.file,
       .key = "inputs.robot",
       .what = fmt::format("the diagnosis is of another state of {}", robot.string()),
       .cure = "Run 'kinetostat diagnose -o' again on this robot file"});
}

Adopted adopt(const DiagnosisRecord& diagnosis, const AdoptRequest& request,
              const std::filesystem::path& out) {
  const Chosen chosen = adoption_from(diagnosis, request);
  const vjm::Robot robot = vjm::read_robot(request.robot, request.reading);
  Adopted adopted;
  try {
    adopted.text = calibration::adopted(io::read_text(request.robot), chosen.adoption);
  } catch (const std::invalid_argument& error) {
    throw common::InputError({.file = request.robot, .what = error.what()});
  }
  const double as_written = error_as_written(diagnosis, request, chosen.adoption);
  const std::vector<std::string> said =
      reservations(diagnosis, chosen.found, chosen.adoption, robot);
  adopted.summary = summary_of(diagnosis, chosen, robot, as_written, said);
  adopted.summary.file = out;
  adopted.result = {{"headline", report::headline(robot, adopted.summary)}};
  adopted.result.update(result_of(chosen, out, as_written, said));
  return adopted;
}

Adopted write_adopted(const AdoptRequest& request, const std::filesystem::path& out) {
  Adopted adopted = adopt(report::read_diagnosis(request.diagnosis), request, out);
  write_robot(out, adopted.text);
  return adopted;
}

}  // namespace kinetostat::apps

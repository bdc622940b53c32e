#include "kinetostat/report/screen/study.h"

#include <fmt/format.h>

#include "kinetostat/report/screen/comparison.h"
#include "kinetostat/report/screen/diagnosis.h"
#include "kinetostat/report/screen/plan.h"
#include "kinetostat/report/screen/wording.h"

namespace kinetostat::report {
namespace {

using calibration::Adequacy;
using calibration::Assessment;
using calibration::Comparison;
using calibration::Verdict;

constexpr const char* lights[] = {"good", "open", "bad"};

Light light_of(const Assessment& assessment) {
  switch (assessment.adequacy) {
    case Adequacy::adequate:
      return Light::good;
    case Adequacy::inadequate:
      return Light::bad;
    default:
      return Light::open;
  }
}

std::string error_in_words(const Comparison& comparison, const Assessment& assessment) {
  if (assessment.is_exact) return "explains the readings to rounding";
  if (comparison.noise.source == calibration::NoiseSource::unknown)
    return "not judged: the noise is not known";
  const std::string error = times(assessment.error_over_noise());
  return assessment.adequacy == Adequacy::inadequate
             ? fmt::format("fails: {} times the noise", error)
             : fmt::format("agrees: {} times the noise", error);
}

}  // namespace

Station readings_station(const calibration::Campaign& campaign,
                         const std::vector<calibration::Observability>& checks) {
  bool has_noise = false;
  for (const auto& check : checks)
    if (check.topic == "noise") has_noise = check.observable;
  return {"readings", readings_in_words(campaign, checks),
          has_noise && campaign.warnings.empty() ? Light::good : Light::open};
}

Station model_station(const Comparison& comparison) {
  if (!comparison.unit_error.empty())
    return {"model",
            error_in_words(comparison, comparison.nominal) +
                "; a mistake in units, signs or axes makes most of it",
            Light::bad};
  return {"model", error_in_words(comparison, comparison.nominal), light_of(comparison.nominal)};
}

Station fitted_station(const vjm::Robot& robot, const Comparison& comparison) {
  if (!comparison.refit_failure.empty()) return {"fitted", comparison.refit_failure, Light::bad};
  if (!comparison.fitted)
    return {"fitted", "nothing is stated as uncertain, so nothing was fitted", Light::open};
  const std::string changes = changed_in_words(robot, comparison.fitted->fit);
  return {
      "fitted",
      error_in_words(comparison, *comparison.fitted) + (changes.empty() ? "" : "; " + changes),
      comparison.adequacy() == Adequacy::inconclusive ? Light::open : light_of(*comparison.fitted)};
}

Station missing_station(const vjm::Robot& robot, const calibration::Diagnosis& diagnosis) {
  const std::string words = verdict_in_short(robot, diagnosis);
  if (diagnosis.by_kinematics) return {"missing", words, Light::bad};
  switch (diagnosis.verdict) {
    case Verdict::identified:
      return {"missing", words, Light::good};
    case Verdict::none_needed:
      return {"missing", words, diagnosis.doubted ? Light::open : Light::good};
    case Verdict::unexplained:
      return {"missing", words, Light::bad};
    default:
      return {"missing", words, Light::open};
  }
}

Station adopted_station(const std::string& file, const Comparison& again, std::size_t set_aside) {
  const std::string error = error_in_words(again, again.nominal);
  if (set_aside > 0 && again.nominal.adequacy == Adequacy::inadequate)
    return {"adopted",
            fmt::format("{} {}, by the {} that {} set aside", file, error,
                        set_aside == 1 ? "reading" : fmt::format("{} readings", set_aside),
                        set_aside == 1 ? "was" : "were"),
            Light::open};
  return {"adopted", fmt::format("{} {}", file, error), light_of(again.nominal)};
}

Station not_adopted_station(const std::string& why, Verdict verdict) {
  const Light light = verdict == Verdict::none_needed    ? Light::good
                      : verdict == Verdict::inconclusive ? Light::open
                                                         : Light::bad;
  return {"adopted", why, light};
}

Station next_station(const vjm::Robot& robot, const calibration::PlanQuestion& question,
                     const calibration::Plan& plan) {
  const std::string lead = !question.open.empty() ? ""
                           : plan.blocks.empty()  ? "nothing is open; "
                                                  : "nothing is open; to ";
  return {"next", lead + plan_in_short(robot, question, plan),
          question.open.empty() ? Light::good : Light::open};
}

Station nothing_next_station(const std::string& why) { return {"next", why, Light::open}; }

io::Json to_json(const Station& station) {
  return {{"name", station.name},
          {"sentence", station.sentence},
          {"light", lights[static_cast<std::size_t>(station.light)]}};
}

Station station_of(const io::Json& json) {
  Station station{json.at("name").get<std::string>(), json.at("sentence").get<std::string>(),
                  Light::open};
  const auto light = json.at("light").get<std::string>();
  for (std::size_t i = 0; i < std::size(lights); ++i)
    if (light == lights[i]) station.light = static_cast<Light>(i);
  return station;
}

std::string text(const std::vector<Station>& stations) {
  std::string lines;
  for (std::size_t i = 0; i < stations.size(); ++i)
    lines += labelled(fmt::format("{} {}", i + 1, stations[i].name), 13, stations[i].sentence);
  return lines;
}

}  // namespace kinetostat::report

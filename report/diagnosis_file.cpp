#include "kinetostat/report/diagnosis_file.h"

#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/report/base_fit.h"
#include "kinetostat/report/campaign_check.h"
#include "kinetostat/report/diagnosis.h"
#include "kinetostat/report/effect.h"
#include "kinetostat/report/waterfall.h"

namespace kinetostat::report {
namespace {

using calibration::Candidate;
using calibration::Diagnosis;
using calibration::DiagnosisRecord;
using calibration::DiagnosisStep;
using calibration::RankedCandidate;
using calibration::RecordedAnswer;
using calibration::RecordedCandidate;
using calibration::RecordedEffect;
using calibration::RecordedEstimate;
using calibration::RecordedFinding;
using calibration::RecordedStep;
using io::Json;
using io::numbers;

Json candidate_json(const vjm::Robot& robot, const Candidate& candidate) {
  const vjm::EffectKind& kind = *candidate.effect.kind;
  const bool angular = vjm::turns(candidate.effect, robot.without_effects());
  Json parameters = Json::array();
  for (std::size_t k = 0; k < kind.parameters.size(); ++k)
    parameters.push_back({{"name", kind.parameters[k].name},
                          {"unit", unit_of(kind.parameters[k], angular)},
                          {"prior_mean", kind.parameters[k].none},
                          {"prior_sd", candidate.deviations[k]}});
  return {{"effect", kind.name}, {"at", candidate.effect.at}, {"parameters", parameters}};
}

Json decision_json(const calibration::Decision& decision) {
  Json answers = Json::array();
  for (const calibration::Answer& answer : decision.answers) {
    Json laws = Json::array();
    for (const calibration::LawShare& law : answer.laws)
      laws.push_back({{"effect", law.effect}, {"at", law.at}, {"share", law.share}});
    answers.push_back({{"class", answer.effect_class},
                       {"places", answer.places},
                       {"probability", answer.probability},
                       {"inseparable", answer.is_inseparable},
                       {"laws", laws}});
  }
  return {{"answers", answers},
          {"nothing", decision.nothing},
          {"unexplained", decision.unexplained},
          {"depends_on", decision.depends_on}};
}

Json ranked_json(const vjm::Robot& robot, const RankedCandidate& r) {
  Json json = candidate_json(robot, r.candidate);
  json["observable"] = r.unobservable.empty();
  if (!r.unobservable.empty()) json["reason"] = r.unobservable;
  json["detectability"] = r.detectability;
  json["most_detectability"] = r.most_detectability;
  json["surprise"] = r.significance;
  if (!r.not_fitted.empty()) json["not_fitted"] = r.not_fitted;
  if (r.fit)
    json["fit"] = {{"values", numbers(r.fit->values)},
                   {"deviations", numbers(r.fit->deviations)},
                   {"chi_square", r.fit->squared_error},
                   {"degrees_of_freedom", r.fit->degrees_of_freedom},
                   {"log_score_gain", r.fit->log_score_gain},
                   {"log_score_deviation", r.fit->log_score_deviation},
                   {"log_evidence", r.fit->log_evidence},
                   {"probability", r.fit->probability},
                   {"told_apart", r.fit->discriminability}};
  return json;
}

Json step_json(const vjm::Robot& robot, const DiagnosisStep& step) {
  Json ranking = Json::array();
  for (const RankedCandidate& r : step.ranking) ranking.push_back(ranked_json(robot, r));
  return {{"beside", step.beside},
          {"gate",
           {{"largest", step.max_score.largest},
            {"critical", step.max_score.critical},
            {"p_value", step.max_score.p_value},
            {"draws", step.max_score.draws}}},
          {"indistinguishable", step.indistinguishable},
          {"log_evidence_without", step.log_evidence_without},
          {"free_form",
           {{"log_evidence", step.free_form.log},
            {"depends_on", step.free_form.depends_on},
            {"probability", step.free_form_probability}}},
          {"confusion", {{"candidates", step.confused}, {"cosines", io::rows(step.confusion)}}},
          {"ranking", ranking}};
}

// Values in the coordinate that was fitted: of a stiffness the logarithm of its factor.
Json profile_json(const calibration::Profile& profile) {
  Json json = report::to_json(profile.estimate), points = Json::array(), interval = Json::array();
  for (const calibration::ProfilePoint& p : profile.points)
    points.push_back({{"value", p.value}, {"rise", p.rise}});
  for (const auto& end : profile.interval) interval.push_back(end ? Json(*end) : Json());
  json.update({{"points", points}, {"interval", interval}, {"ended", profile.ended}});
  return json;
}

// Of what the robot file declares uncertain; a value of an effect with its place.
Json estimates_json(const vjm::Robot& robot,
                    const std::vector<calibration::ParameterEstimate>& estimates) {
  Json list = Json::array();
  for (const calibration::ParameterEstimate& e : estimates) {
    Json json = report::to_json(e);
    if (!e.parameter.is_logarithm()) {
      const vjm::Effect& effect = robot.effects.at(e.parameter.effect);
      const auto value = static_cast<std::size_t>(e.parameter.value);
      json.update({{"effect", effect.kind->name},
                   {"at", effect.at},
                   {"value_of", effect.kind->parameters.at(value).name}});
    }
    list.push_back(std::move(json));
  }
  return list;
}

Json correlation_json(const calibration::EstimateCorrelation& correlation) {
  return {{"of", correlation.names}, {"matrix", io::rows(correlation.matrix)}};
}

Json test_json(const std::optional<calibration::ChiSquareTest>& test) {
  if (!test) return {};
  return {{"chi_square", test->statistic},
          {"degrees_of_freedom", test->degrees_of_freedom},
          {"p_value", test->p_value}};
}

Json found_json(const vjm::Robot& robot, const calibration::FoundEffect& f) {
  Json entry = candidate_json(robot, f.candidate);
  entry["values"] = numbers(f.candidate.effect.values);
  entry["deviations"] = numbers(f.deviations);
  entry["probability"] = f.probability;
  entry["decision"] = decision_json(f.decision);
  entry["sentence"] = answers_text(f.decision);
  entry["which_law"] = laws_text(f.decision);
  entry["inseparable"] = inseparable_text(f.decision);
  entry["gate_p_value"] = f.false_alarm_chance;
  entry["instead"] = names_of(f.instead);
  return entry;
}

Json unseen_json(const Diagnosis& d) {
  Json unseen = Json::array();
  for (const calibration::UnseenKind& kind : calibration::unseen_kinds(d))
    unseen.push_back({{"effect", kind.name},
                      {"detectability", kind.detectability},
                      {"absorbed", kind.confounded_with_fit},
                      {"reason", kind.reason.empty() ? Json() : Json(kind.reason)}});
  return unseen;
}

Json common_cause_json(const vjm::Robot& robot, const Diagnosis& d) {
  if (!d.common_cause) return {};
  Json json = candidate_json(robot, d.common_cause->candidate);
  json["values"] = numbers(d.common_cause->candidate.effect.values);
  json["deviations"] = numbers(d.common_cause->deviations);
  json["chi_square"] = test_json(d.common_cause->test);
  return json;
}

double number_or_unknown(const Json& json) {
  return json.is_null() ? calibration::not_recorded : json.get<double>();
}

double number_or_unknown(const Json& json, const char* key) {
  return json.contains(key) ? number_or_unknown(json.at(key)) : calibration::not_recorded;
}

// Throws where it is no list.
const Json::array_t& list_of(const Json& json, const char* key) {
  return json.at(key).get_ref<const Json::array_t&>();
}

std::vector<double> numbers_of(const Json& json, const char* key) {
  std::vector<double> numbers;
  for (const Json& x : list_of(json, key)) numbers.push_back(number_or_unknown(x));
  return numbers;
}

std::string text_of(const Json& json, const char* key) { return json.at(key).get<std::string>(); }

RecordedEffect effect_of(const Json& json, const Json& fit) {
  RecordedEffect effect{.effect = text_of(json, "effect"),
                        .at = text_of(json, "at"),
                        .parameters = {},
                        .values = {},
                        .deviations = {}};
  for (const Json& p : list_of(json, "parameters"))
    effect.parameters.push_back({.name = text_of(p, "name"),
                                 .unit = text_of(p, "unit"),
                                 .prior_mean = p.at("prior_mean").get<double>(),
                                 .prior_sd = p.at("prior_sd").get<double>()});
  if (fit.is_null()) return effect;
  effect.values = numbers_of(fit, "values");
  effect.deviations = numbers_of(fit, "deviations");
  if (effect.values.size() != effect.parameters.size() ||
      effect.deviations.size() != effect.parameters.size())
    throw std::invalid_argument(
        fmt::format("'{}' has not as many values as parameters", effect.name()));
  return effect;
}

RecordedAnswer answer_of(const Json& json) {
  RecordedAnswer answer{.laws = {}, .probability = json.at("probability").get<double>()};
  for (const Json& law : list_of(json, "laws"))
    answer.laws.push_back(fmt::format("{} at {}", law.at("effect").get<std::string>(),
                                      law.at("at").get<std::string>()));
  return answer;
}

RecordedFinding finding_of(const Json& json) {
  const Json decision = json.value("decision", Json::object());
  RecordedFinding finding{.effect = effect_of(json, json),
                          .probability = json.at("probability").get<double>(),
                          .false_alarm_chance = json.at("gate_p_value").get<double>(),
                          .instead = json.at("instead").get<std::vector<std::string>>(),
                          .nothing = decision.value("nothing", 0.0)};
  if (decision.contains("answers"))
    for (const Json& answer : list_of(decision, "answers"))
      finding.answers.push_back(answer_of(answer));
  return finding;
}

RecordedCandidate candidate_of(const Json& json) {
  const Json fit = json.value("fit", Json());
  RecordedCandidate candidate{.effect = effect_of(json, fit),
                              .detectability = json.at("detectability").get<double>(),
                              .most_detectability = json.at("most_detectability").get<double>(),
                              .unobservable = json.value("reason", ""),
                              .is_fitted = !fit.is_null()};
  if (candidate.is_fitted) {
    candidate.probability = fit.at("probability").get<double>();
    candidate.log_evidence = fit.at("log_evidence").get<double>();
  }
  return candidate;
}

RecordedStep step_of(const Json& json) {
  RecordedStep step{.beside = json.at("beside").get<std::vector<std::string>>(), .ranking = {}};
  for (const Json& entry : list_of(json, "ranking")) step.ranking.push_back(candidate_of(entry));
  return step;
}

RecordedEstimate estimate_of(const Json& json) {
  const Json& bound = json.at("bound");
  RecordedEstimate estimate;
  estimate.is_kept = bound == "kept";
  estimate.is_at_bound = !bound.is_null();
  estimate.unit = json.value("unit", "");
  estimate.designed = number_or_unknown(json, "designed");
  estimate.fitted = number_or_unknown(json, "fitted");
  estimate.standard_error = number_or_unknown(json, "standard_error");
  if (json.contains("effect")) {
    estimate.effect = text_of(json, "effect");
    estimate.at = text_of(json, "at");
    estimate.value_of = text_of(json, "value_of");
    return estimate;
  }
  estimate.stiffness = text_of(json, "stiffness");
  estimate.factor = json.at("factor").get<double>();
  estimate.standard_error_of_log_factor = number_or_unknown(json, "standard_error_of_log_factor");
  return estimate;
}

// None where an earlier version wrote the file.
calibration::EstimateCorrelation correlation_of(const Json& fitted, const char* which) {
  calibration::EstimateCorrelation correlation;
  const Json json = fitted.value("correlations", Json::object()).value(which, Json());
  if (json.is_null()) return correlation;
  correlation.names = json.at("of").get<std::vector<std::string>>();
  const auto rows = json.at("matrix").get<std::vector<std::vector<double>>>();
  const auto count = static_cast<Eigen::Index>(correlation.names.size());
  correlation.matrix = Eigen::MatrixXd::Identity(count, count);
  if (rows.size() != correlation.names.size())
    throw std::invalid_argument("a correlation matrix has not as many rows as names");
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j < rows.size(); ++j)
      correlation.matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          rows[i].at(j);
  return correlation;
}

std::string sha256_of_robot(const Json& json) {
  static const Json::json_pointer at("/inputs/robot/sha256");
  return json.contains(at) ? json.at(at).get<std::string>() : std::string();
}

calibration::Verdict verdict_of(const Json& json, const std::filesystem::path& file) {
  if (const auto verdict = calibration::verdict_named(text_of(json, "verdict"))) return *verdict;
  throw common::InputError({.file = file,
                            .key = "verdict",
                            .what = "is none that a diagnosis has",
                            .cure = "Run 'kinetostat diagnose' again"});
}

// A text alone in files of before it had a date.
std::string campaign_of(const Json& json) {
  const Json& campaign = json.at("campaign");
  return campaign.is_object() ? text_of(campaign, "name") : campaign.get<std::string>();
}

DiagnosisRecord record_of(const Json& json, const std::filesystem::path& file) {
  DiagnosisRecord record{.file = file,
                         .campaign = campaign_of(json),
                         .readings_sha256 = json.value("readings", ""),
                         .robot_sha256 = sha256_of_robot(json),
                         .verdict = verdict_of(json, file),
                         .found = {},
                         .ambiguous = json.at("ambiguous").get<std::vector<std::string>>(),
                         .doubted = {},
                         .instead_of_refit = {},
                         .or_something_else = json.at("or_something_else").get<bool>(),
                         .waterfall = {},
                         .fitted_without = {},
                         .fitted_beside = {},
                         .correlation_without = {},
                         .correlation_beside = {},
                         .set_aside = json.value("set_aside", Json::array()).size(),
                         .steps = {}};
  for (const Json& entry : list_of(json, "found")) record.found.push_back(finding_of(entry));
  if (const Json one = json.value("doubted", Json()); !one.is_null())
    record.doubted = finding_of(one);
  if (const Json one = json.value("instead_of_refit", Json()); !one.is_null())
    record.instead_of_refit = effect_of(one, one);
  for (const Json& stage : list_of(json, "waterfall"))
    record.waterfall.push_back({.name = text_of(stage, "name"),
                                .error = stage.at("whitened").get<double>(),
                                .before = number_or_unknown(stage, "before")});
  if (const Json fitted = json.value("fitted", Json()); !fitted.is_null()) {
    for (const Json& e : list_of(fitted, "without_effects"))
      record.fitted_without.push_back(estimate_of(e));
    for (const Json& e : list_of(fitted, "with_effects"))
      record.fitted_beside.push_back(estimate_of(e));
    record.correlation_without = correlation_of(fitted, "without_effects");
    record.correlation_beside = correlation_of(fitted, "with_effects");
  }
  for (const Json& step : list_of(json, "steps")) record.steps.push_back(step_of(step));
  return record;
}

}  // namespace

Json to_json(const vjm::Robot& robot, const calibration::Campaign& campaign, const Diagnosis& d) {
  Json found = Json::array(), steps = Json::array();
  for (const calibration::FoundEffect& f : d.found) found.push_back(found_json(robot, f));
  for (const DiagnosisStep& step : d.steps) steps.push_back(step_json(robot, step));
  Json json{{"campaign", occasion_json(campaign)},
            {"verdict", calibration::to_string(d.verdict)},
            {"found", found},
            {"ambiguous", d.ambiguous},
            {"doubted", d.doubted ? found_json(robot, *d.doubted) : Json()},
            {"instead_of_refit", common_cause_json(robot, d)},
            {"missing", d.missing},
            {"by_kinematics", d.by_kinematics ? Json(*d.by_kinematics) : Json()},
            {"not_shown", unseen_json(d)},
            {"remarks", remarks(robot, campaign, d)},
            {"chi_square_before", test_json(d.before)},
            {"chi_square_after", test_json(d.after)},
            {"rest_p_value", d.rest_p_value},
            {"rest_of_laws", d.rest_of_laws.empty() ? Json() : Json(d.rest_of_laws)},
            {"or_something_else", d.or_something_else},
            {"above_free_form", d.found.empty() ? Json() : Json(d.above_free_form)},
            {"structure_left",
             {{"p_value", d.left.p_value()},
              {"depends_on", d.left.depends_on},
              {"log_evidence", d.left.log}}},
            {"waterfall", to_json(d.waterfall)},
            {"fitted",
             {{"without_effects", estimates_json(robot, d.fitted_without)},
              {"with_effects", estimates_json(robot, d.fitted_beside)},
              {"correlations",
               {{"without_effects", correlation_json(d.correlation_without)},
                {"with_effects", correlation_json(d.correlation_beside)}}}}},
            {"held_out", d.held_out},
            {"correlated_noise", d.correlated_noise.empty() ? Json() : Json(d.correlated_noise)},
            {"far_values", d.far_values},
            {"set_aside", d.set_aside},
            {"weak", d.weak},
            {"steps", steps}};
  for (const calibration::Profile& p : d.profiles) json["profiles"].push_back(profile_json(p));
  return json;
}

DiagnosisRecord diagnosis_record(const Json& json, const std::filesystem::path& file) {
  const auto no_diagnosis = [&](const char* why) {
    return common::InputError({.file = file,
                               .what = fmt::format("this is not a diagnosis: {}", why),
                               .cure = "Give a file that 'kinetostat diagnose -o FILE' wrote"});
  };
  try {
    return record_of(json, file);
  } catch (const Json::exception&) {
    throw no_diagnosis("what a diagnosis says is missing in it, or of another kind");
  } catch (const std::invalid_argument& error) {
    throw no_diagnosis(error.what());
  }
}

DiagnosisRecord read_diagnosis(const std::filesystem::path& file) {
  return diagnosis_record(io::read_json(file), file);
}

}  // namespace kinetostat::report

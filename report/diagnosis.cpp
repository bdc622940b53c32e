#include "kinetostat/report/diagnosis.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/calibration/search/outliers.h"
#include "kinetostat/report/base_fit.h"
#include "kinetostat/report/effect.h"
#include "kinetostat/report/text.h"
#include "kinetostat/report/waterfall.h"

namespace kinetostat::report {
namespace {

using calibration::Candidate;
using calibration::Diagnosis;
using calibration::DiagnosisStep;
using calibration::RankedCandidate;
using calibration::Verdict;
using io::Json;

constexpr std::size_t shown_candidates = 12, most_places = 6;

// Simple units as the campaign has them, compound ones in SI.
std::string unit_for_people(const calibration::Campaign& campaign,
                            const vjm::EffectParameter& parameter, bool angular) {
  const spatial::Dimension& dimension = angular ? parameter.angular : parameter.linear;
  if (dimension == spatial::dimension::length) return campaign.units.length;
  if (dimension == spatial::dimension::angle) return campaign.units.angle;
  if (dimension == spatial::dimension::force) return campaign.units.force;
  return unit_of(parameter, angular);
}

// "gap = 0.052 +- 0.003 mm"
std::string values_text(const vjm::Robot& robot, const calibration::Campaign& campaign,
                        const Candidate& candidate, const Eigen::VectorXd& values,
                        const Eigen::VectorXd& deviations) {
  const vjm::EffectKind& kind = *candidate.effect.kind;
  const bool angular = vjm::turns(candidate.effect, robot.without_effects());
  std::vector<std::string> texts;
  for (std::size_t k = 0; k < kind.parameters.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const std::string unit = unit_for_people(campaign, kind.parameters[k], angular);
    const double factor = unit.empty() ? 1 : spatial::parse_unit(unit).factor;
    const std::vector<double>& usual =
        angular ? kind.parameters[k].usual_angular : kind.parameters[k].usual_linear;
    const bool at_bound = std::isnan(deviations[i]) && usual.empty();  // else it was tried
    texts.push_back(fmt::format(
        "{} = {}{}{}{}", kind.parameters[k].name, number(values[i] / factor, 4),
        std::isnan(deviations[i]) ? "" : fmt::format(" +- {}", number(deviations[i] / factor, 2)),
        unit.empty() ? "" : " " + unit, at_bound ? " (at a bound of its range)" : ""));
  }
  return fmt::format("{}", fmt::join(texts, ", "));
}

std::string left_text(const char* what, const Diagnosis& d) {
  return fmt::format("{} depends on {} (p = {}).", what, d.left.depends_on,
                     number(d.left.p_value(), 2));
}

std::string noise_words(const Diagnosis& d) {
  if (d.noise != calibration::NoiseSource::replicates) return "the stated noise";
  return d.noise_without_load ? "the noise that repeated readings without load show"
                              : "the noise that repeated readings show";
}

// Where something looked like an effect, or the misfit is large, though none is needed.
std::vector<std::string> remarks_on_nothing(const Diagnosis& d) {
  std::vector<std::string> result;
  if (!d.steps.empty() && d.steps[0].max_score.p_value <= calibration::significance_level)
    result.push_back(fmt::format(
        "A signature exceeds the detection threshold (chance of a false alarm {}), but no fitted "
        "effect improves the prediction of held-out readings, or is far more probable than no "
        "missing effect.",
        percent(d.steps[0].max_score.p_value)));
  if (d.before && d.before->p_value <= calibration::certain_level)
    result.push_back(fmt::format(
        "The misfit is {} times {} (p = {}): that noise is too small, or an effect is missing that "
        "is not observable in these readings.",
        number(std::sqrt(d.before->reduced()), 3), noise_words(d), number(d.before->p_value, 2)));
  return result;
}

// The meaning of a verdict here, in sentences.
std::vector<std::string> remarks_on_verdict(const vjm::Robot& robot,
                                            const calibration::Campaign& campaign,
                                            const Diagnosis& d) {
  const bool is_left = d.left.p_value() < calibration::structure_level;
  switch (d.verdict) {
    case Verdict::unexplained:
      if (!d.found.empty() && d.found.front().decision.unexplained > 0.5)
        return {fmt::format(
            "An unmodelled smooth error that depends on {} explains these readings better than any "
            "effect of the catalogue ({}); {} comes nearest.",
            d.found.front().decision.depends_on,
            probability_in_words(d.found.front().decision.unexplained),
            d.found.front().candidate.name())};
      if (d.above_free_form < calibration::beaten_by_free_form)
        return {fmt::format(
            "An unmodelled smooth error, which depends on {}, explains these readings better than "
            "the nearest effect (log evidence {} more).",
            d.free_form.depends_on, number(-d.above_free_form, 2))};
      if (d.found.empty() && d.is_left_open())
        return {
            fmt::format("No effect explains these readings: with the model as it is, they "
                        "would have {} times {}.",
                        number(std::sqrt(d.after->reduced()), 2), noise_words(d))};
      if (!is_left) return {};
      return {left_text(d.found.empty()
                            ? "No effect of the catalogue explains the rest of the error. It"
                            : "The nearest effect leaves too much unexplained, and the rest",
                        d)};
    case Verdict::identified:
    case Verdict::narrowed_down:
      if (!d.or_something_else && !d.rest_of_laws.empty())
        return {
            fmt::format("The rest of the error is most like {} (chance of a false alarm {}), but "
                        "no larger than the error of an idealised law may be.",
                        d.rest_of_laws, percent(d.rest_p_value))};
      if (!d.or_something_else) return {};
      if (d.predicts_no_better())
        return {
            "Held-out readings are predicted no better with it than without: it may stand for an "
            "effect outside the catalogue."};
      if (d.is_left_open())
        return {fmt::format(
            "It may also stand for an effect outside the catalogue: the rest of the error would "
            "need {} times {}.",
            number(std::sqrt(d.after->reduced()), 2), noise_words(d))};
      return {fmt::format(
          "It may also stand for an effect outside the catalogue: the rest of the error "
          "exceeds the detection threshold (chance of a false alarm {}), and no effect "
          "explains it.",
          percent(d.rest_p_value))};
    case Verdict::inconclusive:
      if (d.common_cause)
        return {fmt::format(
            "{} alone, at {}, explains these readings as well as fitting all uncertain parameters "
            "does (chi-square per degree of freedom {} and {}): either is the error of the nominal "
            "model.",
            d.common_cause->candidate.name(),
            values_text(robot, campaign, d.common_cause->candidate,
                        d.common_cause->candidate.effect.values, d.common_cause->deviations),
            number(d.common_cause->test.reduced(), 3), number(d.before->reduced(), 3))};
      if (!d.missing.empty()) return {};
      return {"No effect of its usual size is observable in these readings."};
    case Verdict::none_needed:
      return remarks_on_nothing(d);
    default:
      return {};
  }
}

std::vector<std::string> remarks(const vjm::Robot& robot, const calibration::Campaign& campaign,
                                 const Diagnosis& d) {
  std::vector<std::string> result = remarks_on_verdict(robot, campaign, d);
  if (calibration::uncertain_parameters(robot).empty())
    result.push_back(
        "The robot file declares nothing 'uncertain', so nothing is fitted: a stiffness that is a "
        "little off may be taken for an effect.");
  if (!d.correlated_noise.empty())
    result.push_back(fmt::format("The noise is not independent, which is taken into account: {}.",
                                 d.correlated_noise));
  if (d.far_values > 0)
    result.push_back(
        fmt::format("{} values are more than {:g} standard deviations from what any effect "
                    "explains, to first order: too many to be set aside as outliers. If "
                    "something is known to be wrong with them, mask them.",
                    d.far_values, calibration::outlying));
  if (!d.unit_error.empty()) result.insert(result.begin(), d.unit_error);
  if (d.noise_check && d.noise_check->p_value < calibration::certain_level)
    result.insert(result.begin(),
                  fmt::format("Repeated readings scatter {} times the stated noise (p = {}): state "
                              "that noise and diagnose again before this verdict is believed.",
                              number(std::sqrt(d.noise_check->reduced()), 3),
                              number(d.noise_check->p_value, 2)));
  return result;
}

// Effects that are not observable in these readings, and the command that plans for them.
std::string unseen_text(const Diagnosis& d) {
  if (d.verdict != Verdict::none_needed && d.verdict != Verdict::inconclusive) return {};
  std::vector<std::string> weak, confounded_with_fit;
  for (const calibration::UnseenKind& kind : calibration::unseen_kinds(d))
    if (kind.reason.empty())
      (kind.confounded_with_fit ? confounded_with_fit : weak).push_back(kind.name);
  if (weak.empty() && confounded_with_fit.empty()) return {};
  std::string text;
  if (!weak.empty())
    text += fmt::format("  Not observable in these readings at their usual sizes: {}.\n",
                        fmt::join(weak, ", "));
  if (!confounded_with_fit.empty())
    text += fmt::format("  Confounded with fitted parameters: {}.\n",
                        fmt::join(confounded_with_fit, ", "));
  return text + "  'kinetostat plan --show NAMES' says which readings would show them.\n";
}

std::string answer_text(const calibration::Answer& answer) {
  return fmt::format("{} at {} ({})", answer.effect_class, fmt::join(answer.places, " or "),
                     probability_in_words(answer.probability));
}

// "backlash at q2 (over 99.9 %)", or a list.
std::string answers_text(const calibration::Decision& decision) {
  if (decision.answers.empty()) return "an effect outside the catalogue";
  std::vector<std::string> words;
  for (const calibration::Answer& answer : decision.answers) words.push_back(answer_text(answer));
  constexpr double worth_a_word = 0.01;
  if (!decision.is_identified && decision.unexplained > worth_a_word)
    words.push_back(fmt::format("an effect outside the catalogue ({})",
                                probability_in_words(decision.unexplained)));
  if (!decision.is_identified && decision.nothing > worth_a_word)
    words.push_back(fmt::format("nothing ({})", probability_in_words(decision.nothing)));
  return words.size() == 1 ? words.front() : fmt::format("one of: {}", fmt::join(words, ", "));
}

// Of the most probable answer; empty where one law is all of it.
std::string laws_text(const calibration::Decision& decision) {
  constexpr double worth_a_word = 0.01;
  if (decision.answers.empty()) return {};
  const calibration::Answer& answer = decision.answers.front();
  std::vector<std::string> words;
  for (const calibration::LawShare& law : answer.laws)
    if (law.share >= worth_a_word)
      words.push_back(answer.places.size() > 1
                          ? fmt::format("{} at {} {}", law.effect, law.at, percent(law.share))
                          : fmt::format("{} {}", law.effect, percent(law.share)));
  return words.size() > 1 ? fmt::format("{}", fmt::join(words, ", ")) : std::string();
}

// Why more readings would be no use; empty where they would.
std::string inseparable_text(const calibration::Decision& decision) {
  if (decision.answers.empty() || !decision.answers.front().is_inseparable) return {};
  return "whatever is read at the target, these move it alike; choose either; the torque of the "
         "drive, or another target, would distinguish them";
}

std::string verdict_text(const vjm::Robot& robot, const calibration::Campaign& campaign,
                         const Diagnosis& d) {
  std::string text =
      fmt::format("Verdict: {}\n", verdict_in_words(calibration::to_string(d.verdict)));
  for (std::size_t i = 0; i < d.found.size(); ++i) {
    const calibration::FoundEffect& found = d.found[i];
    text += fmt::format("  {}: {}\n    {}: {}\n", i + 1, answers_text(found.decision),
                        found.candidate.name(),
                        values_text(robot, campaign, found.candidate, found.candidate.effect.values,
                                    found.deviations));
    if (const std::string laws = laws_text(found.decision); !laws.empty())
      text += fmt::format("    which law: {}\n", laws);
    if (const std::string why = inseparable_text(found.decision); !why.empty())
      text += fmt::format("    {}\n", why);
    text += fmt::format("    chance of a false alarm {}\n", percent(found.false_alarm_chance));
    if (found.times_usual > calibration::unusual)
      text += fmt::format("    {:.0f} times as large as such an effect usually is\n",
                          found.times_usual);
    if (!found.instead.empty())
      text += fmt::format("    these readings do not distinguish it from: {}\n",
                          fmt::join(found.instead, "; "));
  }
  for (const std::string& remark : remarks(robot, campaign, d))
    text += fmt::format("  {}\n", remark);
  for (const std::string& sentence : d.missing) text += "  Missing: " + sentence + ".\n";
  return text + unseen_text(d);
}

// Kinds of effects that the robot has no place for, by the reason.
std::string without_place_text(const Diagnosis& d) {
  std::map<std::string, std::vector<std::string>> kinds;
  for (const calibration::KindWithoutPlace& kind : d.without_place)
    kinds[kind.reason].push_back(kind.name);
  std::string text;
  for (const auto& [reason, names] : kinds)
    text += fmt::format("  not observable, because {}: {}\n", reason, fmt::join(names, ", "));
  return text;
}

std::string ranking_text(const vjm::Robot& robot, const calibration::Campaign& campaign,
                         const DiagnosisStep& step, std::size_t round) {
  std::string text = fmt::format(
      "\nRound {}{}: chance of a false alarm {} ({} candidates, {} simulations)\n", round + 1,
      step.beside.empty() ? "" : fmt::format(", beside {}", fmt::join(step.beside, ", ")),
      percent(step.max_score.p_value), step.ranking.size(), step.max_score.draws);
  Table table({"candidate", "d' at usual size", "-ln p", "probability", "held-out gain", "+-",
               "discriminability d'", "value"});
  std::size_t shown = 0, hidden = 0;
  std::map<std::string, std::map<std::string, std::vector<std::string>>> unobservable;
  for (const RankedCandidate& r : step.ranking) {
    if (!r.unobservable.empty()) {
      unobservable[r.unobservable][r.candidate.effect.kind->name].push_back(r.candidate.effect.at);
      continue;
    }
    if (++shown > shown_candidates) {
      ++hidden;
      continue;
    }
    std::vector<std::string> row{r.candidate.name(), number(r.detectability, 3),
                                 number(r.significance, 3)};
    if (r.fit) {
      row.insert(row.end(),
                 {number(r.fit->probability, 3), number(r.fit->log_score_gain, 3),
                  number(r.fit->log_score_deviation, 2), number(r.fit->discriminability, 3),
                  values_text(robot, campaign, r.candidate, r.fit->values, r.fit->deviations)});
    } else {
      row.insert(row.end(), {"-", "-", "-", "-", r.not_fitted.empty() ? "" : "not fitted"});
    }
    table.add_row(row);
  }
  text += table.text();
  if (hidden > 0) text += fmt::format("  and {} more with a smaller signature\n", hidden);
  if (step.free_form_probability > 0)
    text += fmt::format("  an unmodelled smooth error: probability {}; it would depend on {}\n",
                        number(step.free_form_probability, 3), step.free_form.depends_on);
  for (const auto& [reason, kinds] : unobservable) {
    text += fmt::format("  not observable, because {}:\n", reason);
    for (const auto& [kind, places] : kinds)
      text += places.size() > most_places
                  ? fmt::format("    {} at {} places\n", kind, places.size())
                  : fmt::format("    {} at {}\n", kind, fmt::join(places, ", "));
  }
  return text;
}

Json numbers(const Eigen::VectorXd& v) {
  Json list = Json::array();
  for (const double x : v) list.push_back(std::isnan(x) ? Json() : Json(x));
  return list;
}

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
  Json json = to_json(profile.estimate), points = Json::array(), interval = Json::array();
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
    Json json = to_json(e);
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

Json test_json(const std::optional<calibration::ChiSquareTest>& test) {
  if (!test) return {};
  return {{"chi_square", test->statistic},
          {"degrees_of_freedom", test->degrees_of_freedom},
          {"p_value", test->p_value}};
}

}  // namespace

std::string verdict_in_words(const std::string& verdict) {
  const auto known = calibration::verdict_named(verdict);
  return known ? to_string(*known) : verdict;
}

std::string text(const vjm::Robot& robot, const calibration::Campaign& campaign,
                 const Diagnosis& d) {
  std::string text = fmt::format("\n{}\n", campaign.name) + verdict_text(robot, campaign, d);
  if (d.before && d.after)
    text += fmt::format("  chi-square per degree of freedom: fitted {}, final {}\n",
                        number(d.before->reduced(), 4), number(d.after->reduced(), 4));
  text += waterfall_text(campaign, d.waterfall, d.held_out);
  for (std::size_t i = 0; i < d.steps.size(); ++i)
    text += ranking_text(robot, campaign, d.steps[i], i) + (i == 0 ? without_place_text(d) : "");
  for (const std::string& sentence : d.weak) text += "Weak: " + sentence + "\n";
  for (const std::string& sentence : d.set_aside) text += "Set aside: " + sentence + "\n";
  return text;
}

Json to_json(const vjm::Robot& robot, const calibration::Campaign& campaign, const Diagnosis& d) {
  Json found = Json::array(), steps = Json::array(), waterfall = Json::array();
  for (const calibration::FoundEffect& f : d.found) {
    Json entry = candidate_json(robot, f.candidate);
    entry["values"] = numbers(f.candidate.effect.values);
    entry["deviations"] = numbers(f.deviations);
    entry["probability"] = f.probability;
    entry["decision"] = decision_json(f.decision);
    entry["sentence"] = answers_text(f.decision);
    entry["which_law"] = laws_text(f.decision);
    entry["inseparable"] = inseparable_text(f.decision);
    entry["gate_p_value"] = f.false_alarm_chance;
    entry["instead"] = f.instead;
    found.push_back(std::move(entry));
  }
  for (const DiagnosisStep& step : d.steps) steps.push_back(step_json(robot, step));
  for (const calibration::WaterfallStage& s : d.waterfall) waterfall.push_back(to_json(s));
  Json unseen = Json::array();
  for (const calibration::UnseenKind& kind : calibration::unseen_kinds(d))
    unseen.push_back({{"effect", kind.name},
                      {"detectability", kind.detectability},
                      {"absorbed", kind.confounded_with_fit},
                      {"reason", kind.reason.empty() ? Json() : Json(kind.reason)}});
  Json instead;
  if (const auto& one = d.common_cause) {
    instead = candidate_json(robot, one->candidate);
    instead["values"] = numbers(one->candidate.effect.values);
    instead["deviations"] = numbers(one->deviations);
    instead["chi_square"] = test_json(one->test);
  }
  Json json{{"campaign", campaign.name},
            {"verdict", calibration::to_string(d.verdict)},
            {"found", found},
            {"ambiguous", d.ambiguous},
            {"instead_of_refit", instead},
            {"missing", d.missing},
            {"not_shown", unseen},
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
            {"waterfall", waterfall},
            {"fitted",
             {{"without_effects", estimates_json(robot, d.fitted_without)},
              {"with_effects", estimates_json(robot, d.fitted_beside)}}},
            {"held_out", d.held_out},
            {"correlated_noise", d.correlated_noise.empty() ? Json() : Json(d.correlated_noise)},
            {"far_values", d.far_values},
            {"set_aside", d.set_aside},
            {"weak", d.weak},
            {"steps", steps}};
  for (const calibration::Profile& p : d.profiles) json["profiles"].push_back(profile_json(p));
  return json;
}

}  // namespace kinetostat::report

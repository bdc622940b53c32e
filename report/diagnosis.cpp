#include "kinetostat/report/diagnosis.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/calibration/regression/undetermined.h"
#include "kinetostat/calibration/search/outliers.h"
#include "kinetostat/report/base_fit.h"
#include "kinetostat/report/effect.h"
#include "kinetostat/report/text/text.h"
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

// The name of a session or cycle that an effect is of; empty for other values.
std::string named_readings(const calibration::Campaign& campaign, vjm::NamesReadings names,
                           double value) {
  const auto number = static_cast<std::size_t>(value);
  if (names == vjm::NamesReadings::axes)
    return number == 1 ? "along axes of the platform" : "along axes of the readings";
  if (names == vjm::NamesReadings::session && number - 1 < campaign.sessions.size())
    return fmt::format("session = {} ('{}')", number, campaign.sessions[number - 1]);
  if (names != vjm::NamesReadings::cycle) return {};
  const std::vector<calibration::Cycle> cycles = calibration::cycles_as_run(campaign);
  if (number - 1 >= cycles.size()) return {};
  return fmt::format("cycle = {} ('{}')", number,
                     campaign.readings[cycles[number - 1].front()].cycle);
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
    if (std::string named = named_readings(campaign, kind.parameters[k].names_readings, values[i]);
        !named.empty()) {
      texts.push_back(std::move(named));
      continue;
    }
    const std::string unit = unit_for_people(campaign, kind.parameters[k], angular);
    const double factor = unit.empty() ? 1 : spatial::parse_unit(unit).factor;
    const std::vector<double>& usual =
        angular ? kind.parameters[k].usual_angular : kind.parameters[k].usual_linear;
    // Else it was tried, or need not be.
    const bool is_none = !kind.parameters[k].required && values[i] == kind.parameters[k].none;
    const bool at_bound = std::isnan(deviations[i]) && usual.empty() && !is_none;
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

std::string misfit_in_words(const char* what, const Diagnosis& d) {
  return fmt::format("{} is {} times {} (p = {}): that noise is too small, or ", what,
                     number(std::sqrt(d.after->reduced()), 3), noise_words(d),
                     number(d.after->p_value, 2));
}

// Where something looked like an effect, or the misfit is large, though none is needed.
std::vector<std::string> remarks_on_nothing(const Diagnosis& d) {
  std::vector<std::string> result;
  if (d.doubted)
    result.push_back(fmt::format(
        "A signature exceeds the detection threshold (chance of a false alarm {}), and yet nothing "
        "missing is more probable: what 'kinetostat plan' asks for would tell.",
        percent(d.doubted->false_alarm_chance)));
  else if (!d.steps.empty() && d.steps[0].max_score.p_value <= calibration::significance_level)
    result.push_back(fmt::format(
        "A signature exceeds the detection threshold (chance of a false alarm {}), but no fitted "
        "effect improves the prediction of held-out readings, or is far more probable than no "
        "missing effect.",
        percent(d.steps[0].max_score.p_value)));
  if (d.leaves_misfit() && !d.shares_noise())
    result.push_back(misfit_in_words("The misfit", d) +
                     "an effect is missing that is not observable in these readings.");
  return result;
}

// Which readings were left out, and what of the error is theirs.
std::string remark_on_set_aside(const Diagnosis& d) {
  constexpr std::size_t most = 4;
  std::vector<std::string> which;
  for (const std::string& sentence : d.set_aside) {  // "reading 'a3' (readings.csv:12): more than"
    if (which.size() == most) {
      which.emplace_back("...");
      break;
    }
    which.push_back(sentence.substr(0, sentence.find("): ") + 1));
  }
  std::string text = fmt::format(
      "{} reading{} set aside, more than {:g} standard deviations from what any effect "
      "explains: {}.",
      d.set_aside.size(), d.set_aside.size() == 1 ? " is" : "s are", calibration::outlying,
      fmt::join(which, ", "));
  for (const calibration::WaterfallStage& stage : d.waterfall)
    if (stage.name == calibration::as_adopted)
      text += fmt::format(" With {} the error is {} times the noise.",
                          d.set_aside.size() == 1 ? "it" : "them", number(stage.whitened, 3));
  return text;
}

std::string remark_on_unexplained(const Diagnosis& d) {
  if (!d.found.empty() && d.found.front().decision.unexplained > 0.5)
    return fmt::format(
        "An unmodelled smooth error that depends on {} explains these readings better than any "
        "effect of the catalogue ({}); {} comes nearest.",
        d.found.front().decision.depends_on,
        probability_in_words(d.found.front().decision.unexplained),
        d.found.front().candidate.name());
  if (d.above_free_form < calibration::beaten_by_free_form)
    return fmt::format(
        "An unmodelled smooth error, which depends on {}, explains these readings better than "
        "the nearest effect (log evidence {} more).",
        d.free_form.depends_on, number(-d.above_free_form, 2));
  if (d.found.empty() && d.is_left_open())
    return fmt::format(
        "No effect explains these readings: with the model as it is, they would have {} times {}.",
        number(std::sqrt(d.misfit), 2), noise_words(d));
  if (d.left.p_value() >= calibration::structure_level) return {};
  return left_text(d.found.empty() ? "No effect of the catalogue explains the rest of the error. It"
                                   : "The nearest effect leaves too much unexplained, and the rest",
                   d);
}

// Beside what explains the readings.
std::string remark_on_rest(const Diagnosis& d) {
  if (!d.rest_of_laws.empty())
    return fmt::format(
        "The rest of the error is most like {} (chance of a false alarm {}), but no larger than "
        "the error of an idealised law may be.",
        d.rest_of_laws, percent(d.rest_p_value));
  if (d.predicts_worse())
    return "Readings kept out of the fit are predicted worse with it: too few readings show it to "
           "predict the others, and 'kinetostat adopt' refuses it.";
  if (d.leaves_misfit() && !d.shares_noise())
    return misfit_in_words("What is left", d) + "something else is missing, too.";
  return {};
}

std::string remark_on_found(const Diagnosis& d) {
  if (!d.or_something_else) return remark_on_rest(d);
  if (d.predicts_no_better())
    return "Held-out readings are predicted no better with it than without: it may stand for an "
           "effect outside the catalogue.";
  const char* it = d.found.size() == 1 ? "It" : "They";
  if (d.is_left_open())
    return fmt::format(
        "{} may also stand for an effect outside the catalogue: the rest of the error would need "
        "{} times {}.",
        it, number(std::sqrt(d.misfit), 2), noise_words(d));
  return fmt::format(
      "{} may also stand for an effect outside the catalogue: the rest of the error exceeds the "
      "detection threshold (chance of a false alarm {}), and no effect explains it.",
      it, percent(d.rest_p_value));
}

std::string remark_on_inconclusive(const vjm::Robot& robot, const calibration::Campaign& campaign,
                                   const Diagnosis& d) {
  if (d.common_cause)
    return fmt::format(
        "{} alone, at {}, explains these readings as well as fitting all uncertain parameters does "
        "(chi-square per degree of freedom {} and {}): either is the error of the nominal model.",
        d.common_cause->candidate.name(),
        values_text(robot, campaign, d.common_cause->candidate,
                    d.common_cause->candidate.effect.values, d.common_cause->deviations),
        number(d.common_cause->test.reduced(), 3), number(d.before->reduced(), 3));
  if (!d.missing.empty() || !d.found.empty()) return {};
  return "No effect of its usual size is observable in these readings.";
}

// A size that nobody has seen may be one, or another effect in this one's clothes.
std::string remark_on_size(const Diagnosis& d) {
  for (const calibration::FoundEffect& found : d.found)
    if (found.times_usual > calibration::unusual)
      return fmt::format("{} is {:.2g} times as large as it usually is: see whether that can be.",
                         found.candidate.name(), found.times_usual);
  return {};
}

// The meaning of a verdict here, in sentences.
std::vector<std::string> remarks_on_verdict(const vjm::Robot& robot,
                                            const calibration::Campaign& campaign,
                                            const Diagnosis& d) {
  std::string remark;
  switch (d.verdict) {
    case Verdict::unexplained:
      remark = remark_on_unexplained(d);
      break;
    case Verdict::identified:
    case Verdict::narrowed_down:
      remark = remark_on_found(d);
      break;
    case Verdict::inconclusive:
      remark = remark_on_inconclusive(robot, campaign, d);
      break;
    case Verdict::none_needed:
      return remarks_on_nothing(d);
    default:
      break;
  }
  std::vector<std::string> said;
  const bool is_named = d.verdict == Verdict::identified || d.verdict == Verdict::narrowed_down;
  if (!remark.empty()) said.push_back(std::move(remark));
  if (std::string size = is_named ? remark_on_size(d) : ""; !size.empty())
    said.push_back(std::move(size));
  return said;
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
                          fmt::join(names_of(found.instead), "; "));
  }
  if (d.doubted) text += fmt::format("  perhaps {}\n", answers_text(d.doubted->decision));
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

}  // namespace

std::string unit_for_people(const calibration::Campaign& campaign,
                            const vjm::EffectParameter& parameter, bool angular) {
  const spatial::Dimension& dimension = angular ? parameter.angular : parameter.linear;
  if (dimension == spatial::dimension::length) return campaign.units.length;
  if (dimension == spatial::dimension::angle) return campaign.units.angle;
  if (dimension == spatial::dimension::force) return campaign.units.force;
  constexpr spatial::Dimension compliance{.mass = -1, .time = 2};
  constexpr spatial::Dimension of_rotation{.length = -2, .mass = -1, .time = 2, .angle = 1};
  if (dimension == compliance) return "um/N";
  if (dimension == of_rotation) return "urad/(N m)";
  constexpr spatial::Dimension drift{.length = 1, .time = -1}, turn{.time = -1, .angle = 1};
  if (dimension == drift) return "um/h";
  if (dimension == turn) return "urad/h";
  return unit_of(parameter, angular);
}

std::vector<std::string> remarks(const vjm::Robot& robot, const calibration::Campaign& campaign,
                                 const Diagnosis& d) {
  std::vector<std::string> result = remarks_on_verdict(robot, campaign, d);
  if (calibration::uncertain_parameters(robot).empty())
    result.push_back(
        "The robot file declares nothing 'uncertain', so nothing is fitted: a stiffness that is a "
        "little off may be taken for an effect.");
  for (const vjm::ElasticBody& body : robot.manipulator.elastic_bodies())
    result.push_back(fmt::format(
        "The elastic body '{}' is taken as it is: no effect is looked for on it.", body.name));
  if (!d.correlated_noise.empty())
    result.push_back(fmt::format("The noise is not independent, which is taken into account: {}.",
                                 d.correlated_noise));
  if (!d.set_aside.empty()) result.insert(result.begin(), remark_on_set_aside(d));
  if (d.far_values > 0)
    result.push_back(
        fmt::format("{} values are more than {:g} standard deviations from what any effect "
                    "explains, to first order: too many to be set aside as outliers. If "
                    "something is known to be wrong with them, mask them.",
                    d.far_values, calibration::outlying));
  if (std::string common =
          calibration::common_factor(d.found.empty() ? d.fitted_without : d.fitted_beside);
      !common.empty() && d.unit_error.empty())
    result.push_back(std::move(common));
  if (!d.unit_error.empty()) result.insert(result.begin(), d.unit_error);
  // Where what was found leaves no more than the stated noise, the scatter was its own.
  const bool is_explained =
      !d.found.empty() && d.after && d.after->p_value > calibration::certain_level;
  if (d.noise_check && d.noise_check->p_value < calibration::certain_level && !is_explained &&
      d.unit_error.empty())
    result.insert(result.begin(),
                  fmt::format("Repeated readings scatter {} times the stated noise (p = {}): state "
                              "that noise and diagnose again before this verdict is believed.",
                              number(std::sqrt(d.noise_check->reduced()), 3),
                              number(d.noise_check->p_value, 2)));
  return result;
}

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

std::string inseparable_text(const calibration::Decision& decision) {
  if (decision.answers.empty() || !decision.answers.front().is_inseparable) return {};
  const std::vector<calibration::LawShare>& laws = decision.answers.front().laws;
  const bool is_of_frame = std::any_of(
      laws.begin(), laws.end(), [](const auto& law) { return law.effect == "sensor_frame"; });
  return fmt::format(
      "whatever is read at the target, these move it alike; choose either; {}, or another target, "
      "would distinguish them",
      is_of_frame ? "the instrument set up anew on the base" : "the torque of the drive");
}

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

}  // namespace kinetostat::report

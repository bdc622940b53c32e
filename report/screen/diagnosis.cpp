#include "kinetostat/report/screen/diagnosis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>

#include <fmt/format.h>

#include "kinetostat/calibration/regression/reading_offsets.h"
#include "kinetostat/calibration/search/ranking.h"
#include "kinetostat/report/diagnosis.h"
#include "kinetostat/report/effect.h"
#include "kinetostat/report/screen/bars.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

using calibration::Answer;
using calibration::Decision;
using calibration::Diagnosis;
using calibration::DiagnosisStep;
using calibration::FoundEffect;
using calibration::RankedCandidate;
using calibration::Verdict;

constexpr double decisive_law = 0.95;  // share from which an answer is called by its law
constexpr std::size_t most_remarks = 2, most_excluded = 3, most_unseen = 8, most_missing = 2;

const vjm::Manipulator& bare(const vjm::Robot& robot) { return robot.without_effects(); }

std::string places_in_words(const vjm::Robot& robot, const std::vector<std::string>& places) {
  constexpr std::size_t most = 4;
  std::vector<std::string> words;
  for (const std::string& place : places) {
    if (words.size() == most) {
      const std::size_t left = places.size() - most;
      words.push_back(fmt::format("{} more place{}", left, left == 1 ? "" : "s"));
      break;
    }
    words.push_back(place_in_words(bare(robot), place));
  }
  return listed(words, "or");
}

bool has_no_place(const std::vector<std::string>& places) {
  return places.empty() || places.front() == "load" || places.front() == "sensor";
}

// One law is left, and it ends at no bound where it stands for another.
bool is_called_by_law(const Answer& answer) {
  return !answer.laws.empty() && answer.laws.front().share >= decisive_law &&
         !answer.laws.front().is_at_limit && !answer.is_inseparable;
}

// "friction at joint q2", or by its class where several laws are left.
std::string answer_in_words(const vjm::Robot& robot, const Answer& answer) {
  std::string words = answer.effect_class;
  if (is_called_by_law(answer)) {
    words = answer.laws.front().effect;
    std::replace(words.begin(), words.end(), '_', ' ');
  }
  return has_no_place(answer.places) ? words
                                     : words + " at " + places_in_words(robot, answer.places);
}

std::string with_probability(const vjm::Robot& robot, const Answer& answer) {
  return fmt::format("{} ({})", answer_in_words(robot, answer), short_percent(answer.probability));
}

// A value of an effect, in what people state it in.
struct Value {
  std::string name, text;
  double significance = 0;  // distance from nothing, in standard deviations
};

// How fast something goes on belongs to what it is, as far as it is known.
bool is_known_time(const vjm::EffectParameter& parameter, bool angular, double value,
                   double deviation) {
  return (angular ? parameter.angular : parameter.linear) == spatial::dimension::time &&
         deviation < value / 2;
}

// As people call it: a "force" that turns something is a torque.
std::string name_for_people(const vjm::EffectParameter& parameter, bool angular) {
  const bool is_torque = angular && parameter.angular == spatial::dimension::moment &&
                         parameter.name.rfind("force", 0) == 0;
  return is_torque ? "torque" + parameter.name.substr(5) : parameter.name;
}

std::vector<Value> values_of(const vjm::Robot& robot, const calibration::Campaign& campaign,
                             const FoundEffect& found) {
  const vjm::EffectKind& kind = *found.candidate.effect.kind;
  const bool angular = vjm::turns(found.candidate.effect, bare(robot));
  std::vector<Value> values;
  for (std::size_t k = 0; k < kind.parameters.size(); ++k) {
    const vjm::EffectParameter& parameter = kind.parameters[k];
    const auto i = static_cast<Eigen::Index>(k);
    const double value = found.candidate.effect.values[i], deviation = found.deviations[i];
    const bool is_at_bound = std::isnan(deviation);
    if (k > 0 && (parameter.is_phase ||
                  (parameter.is_shape && !is_known_time(parameter, angular, value, deviation))))
      continue;
    if (k > 0 && is_at_bound && value == parameter.none) continue;
    const std::string unit = unit_for_people(campaign, parameter, angular);
    const double factor = unit.empty() ? 1 : spatial::parse_unit(unit).factor;
    const std::string number_alone =
        is_at_bound ? number(value / factor, 3) : with_error(value / factor, deviation / factor);
    values.push_back({name_for_people(parameter, angular),
                      number_alone + (unit.empty() ? "" : " " + unit_in_words(unit)) +
                          (is_at_bound ? " (at its bound)" : ""),
                      is_at_bound ? std::numeric_limits<double>::infinity()
                                  : std::abs(value - parameter.none) / deviation});
  }
  // The first is no part of it where it ends as nothing and another one does not.
  const bool is_none = std::isnan(found.deviations[0]) &&
                       found.candidate.effect.values[0] == kind.parameters[0].none;
  if (is_none && values.size() > 1) values.erase(values.begin());
  return values;
}

// "order 2": what design fixes, where it is not what comes first; along a slide "pitch 20 mm".
std::vector<std::string> designs_in_words(const vjm::Robot& robot, const FoundEffect& found) {
  const vjm::Effect& effect = found.candidate.effect;
  const bool angular = vjm::turns(effect, bare(robot));
  std::vector<std::string> words;
  for (std::size_t k = 0; k < effect.kind->parameters.size(); ++k) {
    const vjm::EffectParameter& p = effect.kind->parameters[k];
    const std::vector<double>& usual = angular ? p.usual_angular : p.usual_linear;
    const double value = effect.values[static_cast<Eigen::Index>(k)];
    if (p.is_order && !angular) {
      words.push_back(fmt::format("pitch {} mm", number(2e3 * std::numbers::pi / value, 3)));
      continue;
    }
    const auto number_of =
        static_cast<std::size_t>(std::find(usual.begin(), usual.end(), value) - usual.begin());
    if (usual.size() > 1 && value != usual.front())
      words.push_back(number_of < p.usual_in_words.size()
                          ? p.usual_in_words[number_of]
                          : fmt::format("{} {}", p.name, number(value, 3)));
  }
  for (std::string& word : words) std::replace(word.begin(), word.end(), '_', ' ');
  return words;
}

// How large it is: the leading value, and those beside it that stand out from nothing.
std::string size_in_words(const vjm::Robot& robot, const calibration::Campaign& campaign,
                          const FoundEffect& found) {
  constexpr double stands_out = 2;
  constexpr std::size_t most = 3;
  std::vector<Value> values = values_of(robot, campaign, found);
  std::vector<Value> shown;
  for (const Value& value : values)
    if (value.significance > stands_out && shown.size() < most) shown.push_back(value);
  // A size below its own error is none that is known.
  const bool leads = found.candidate.effect.kind->parameters.front().required;
  const auto clearest =
      leads ? values.begin()
            : std::max_element(values.begin(), values.end(), [](const Value& a, const Value& b) {
                return a.significance < b.significance;
              });
  if (shown.empty() && clearest != values.end() && !(clearest->significance < 1))
    shown.push_back(*clearest);
  if (shown.empty()) return {};
  const std::vector<std::string> designs = designs_in_words(robot, found);
  if (leads && shown.size() == 1 && shown.front().name == values.front().name && designs.empty())
    return shown.front().text;
  std::vector<std::string> words;
  words.reserve(shown.size());
  for (const Value& value : shown) words.push_back(value.name + " " + value.text);
  words.insert(words.end(), designs.begin(), designs.end());
  return listed(words, "and");
}

// " from reading 'r50' of session 'pm' on", where it is of some readings only.
std::string readings_in_words(const calibration::Campaign& campaign, const vjm::Effect& effect) {
  if (!effect.kind->offsets_readings) return {};
  const std::vector<vjm::ReadingMoment> moments = calibration::moments_of(campaign);
  std::optional<std::size_t> first;
  for (std::size_t r = 0; r < moments.size(); ++r)
    if (effect.kind->is_off(moments[r], effect.values) &&
        (!first || moments[r].time < moments[*first].time))
      first = r;
  if (!first) return {};
  const calibration::Reading& reading = campaign.readings[*first];
  const std::string& session = campaign.sessions[reading.session];
  const std::string of = session.empty() ? "" : fmt::format(" of session '{}'", session);
  // A slip within a cycle ends with it.
  bool ends = false;
  for (std::size_t r = 0; r < moments.size(); ++r)
    ends |= moments[r].session == moments[*first].session &&
            moments[r].time > moments[*first].time &&
            !effect.kind->is_off(moments[r], effect.values);
  return calibration::is_of_cycles(*effect.kind)
             ? fmt::format(" in cycle '{}'{}", reading.cycle, of)
         : ends ? fmt::format(" from reading '{}'{} to the end of cycle '{}'", reading.id, of,
                              reading.cycle)
         : moments[*first].time == 0  // of its session
             ? fmt::format(" in all{}, as if the instrument or the target had been moved before it",
                           of)
             : fmt::format(" from reading '{}'{} on", reading.id, of);
}

std::string found_in_words(const vjm::Robot& robot, const calibration::Campaign& campaign,
                           const FoundEffect& found) {
  const Decision& decision = found.decision;
  const vjm::Effect& effect = found.candidate.effect;
  if (decision.answers.empty())
    return fmt::format("{}: {}", effect_in_words(bare(robot), effect.kind->name, effect.at),
                       size_in_words(robot, campaign, found));
  const Answer& first = decision.answers.front();
  std::string size = size_in_words(robot, campaign, found) + readings_in_words(campaign, effect);
  if (!is_called_by_law(first) && !size.empty()) {
    std::string law = effect.kind->name;
    std::replace(law.begin(), law.end(), '_', ' ');
    size = law + " " + size;
  }
  return fmt::format("{}{} ({})", answer_in_words(robot, first), size.empty() ? "" : ": " + size,
                     short_percent(first.probability));
}

std::string narrowed_in_words(const vjm::Robot& robot, const Decision& decision) {
  constexpr double worth_a_word = 0.01;
  constexpr std::size_t most_of_long = 3;  // of a list that is none
  std::vector<std::string> words;
  for (const Answer& answer : decision.answers) words.push_back(with_probability(robot, answer));
  if (!decision.is_narrowed_down && words.size() > most_of_long) {
    const std::size_t left = words.size() - most_of_long;
    words.resize(most_of_long);
    words.push_back(fmt::format("{} more", left));
    return "something that these readings leave open: " + listed(words, "or");
  }
  if (decision.unexplained > worth_a_word)
    words.push_back(
        fmt::format("something outside the catalogue ({})", short_percent(decision.unexplained)));
  if (decision.nothing > worth_a_word)
    words.push_back(fmt::format("nothing ({})", short_percent(decision.nothing)));
  if (words.size() < 2) return words.empty() ? std::string() : words.front();
  static const char* const counts[] = {"two",   "three", "four", "five", "six",
                                       "seven", "eight", "nine", "ten"};
  const std::size_t n = words.size();
  return fmt::format("one of {}: {}", n <= 10 ? counts[n - 2] : std::to_string(n),
                     listed(words, "or"));
}

// A list, or one answer and what else may be.
std::string answers_in_words(const vjm::Robot& robot, const calibration::Campaign& campaign,
                             const FoundEffect& found) {
  constexpr double worth_a_word = 0.05;
  const Decision& decision = found.decision;
  if (!decision.is_identified && decision.answers.size() > 1)
    return narrowed_in_words(robot, decision);
  std::string text = found_in_words(robot, campaign, found);
  if (decision.unexplained > worth_a_word)
    text += fmt::format(" or something outside the catalogue ({})",
                        short_percent(decision.unexplained));
  return text;
}

std::string effects_in_words(const vjm::Robot& robot, const calibration::Campaign& campaign,
                             const Diagnosis& d) {
  std::string text;
  for (const FoundEffect& found : d.found)
    text += (text.empty() ? "" : ", and ") + answers_in_words(robot, campaign, found);
  return capitalised(text) + ".";
}

// One of those that were found, whatever the readings leave open beside it.
bool names_something(const Diagnosis& d) {
  return std::any_of(d.found.begin(), d.found.end(),
                     [](const FoundEffect& found) { return found.decision.is_identified; });
}

std::string found_in_short(const vjm::Robot& robot, const FoundEffect& found) {
  const Decision& decision = found.decision;
  if (decision.answers.empty()) return found.candidate.name();
  if (!decision.is_identified && decision.answers.size() > 1)
    return narrowed_in_words(robot, decision);
  return fmt::format("{}, {}", answer_in_words(robot, decision.answers.front()),
                     short_percent(decision.answers.front().probability));
}

std::string depends_on(const Diagnosis& d) {
  if (!d.found.empty() && !d.found.front().decision.depends_on.empty())
    return d.found.front().decision.depends_on;
  return !d.left.depends_on.empty() ? d.left.depends_on : d.free_form.depends_on;
}

// How the noise is not independent, without what makes it so.
std::string correlated_in_short(const Diagnosis& d) {
  const std::string what = d.correlated_noise.substr(0, d.correlated_noise.find(", as "));
  return what.empty() ? "" : ": " + what;
}

std::string nothing_in_words(const vjm::Robot& robot, const Diagnosis& d) {
  if (d.doubted && !d.doubted->decision.answers.empty())
    return fmt::format(
        "No effect stands out: the most probable answer is that nothing is missing "
        "({}), next is {}.",
        short_percent(d.doubted->decision.nothing),
        with_probability(robot, d.doubted->decision.answers.front()));
  if (!d.after) return "Nothing is missing: no effect of the catalogue explains more.";
  const std::string error = times(std::sqrt(d.after->reduced()));
  if (d.leaves_misfit())
    return fmt::format(
        "Nothing that the catalogue holds is missing, but the error of the fitted model is {} "
        "times the noise{}.",
        error, correlated_in_short(d));
  return fmt::format(
      "Nothing is missing: the error of the fitted model is {} times the noise, and no effect of "
      "the catalogue explains more.",
      error);
}

// The round in which the first effect competed beside all the others.
const DiagnosisStep* step_of(const Diagnosis& d) {
  const std::span<const FoundEffect> found = d.found;
  const DiagnosisStep* step =
      calibration::round_beside(found.empty() ? found : found.subspan(1), d.steps);
  return step != nullptr || d.steps.empty() ? step : &d.steps.front();
}

bool is_answer(const Diagnosis& d, const vjm::Effect& effect) {
  for (const FoundEffect& found : d.found) {
    if (found.candidate.name() == effect.kind->name + " at " + effect.at) return true;
    for (const Answer& answer : found.decision.answers) {
      for (const calibration::LawShare& law : answer.laws)
        if (law.effect == effect.kind->name && law.at == effect.at) return true;
      // A further law of the class, at one of the places, is not excluded by it.
      const std::string its_class = to_string(effect.kind->effect_class);
      if (answer.effect_class.find(its_class) != std::string::npos &&
          std::find(answer.places.begin(), answer.places.end(), effect.at) != answer.places.end())
        return true;
    }
  }
  return false;
}

// Of laws of one joint the answers tell.
bool is_relative(const Diagnosis& d, const calibration::Candidate& candidate) {
  return std::any_of(d.found.begin(), d.found.end(), [&](const FoundEffect& found) {
    return calibration::are_laws_of_one_joint(found.candidate, candidate);
  });
}

std::vector<std::pair<std::string, std::string>> stage_names(const vjm::Robot& robot,
                                                             const Diagnosis& d) {
  std::vector<std::pair<std::string, std::string>> names;
  for (const FoundEffect& found : d.found) {
    const vjm::Effect& effect = found.candidate.effect;
    const std::vector<std::string> designs = designs_in_words(robot, found);
    names.emplace_back("+ " + found.candidate.name(),
                       "+ " + effect_in_words(bare(robot), effect.kind->name, effect.at) +
                           (designs.empty() ? "" : " (" + listed(designs, "and") + ")"));
  }
  return names;
}

std::string error_sentence(const Diagnosis& d) {
  if (d.found.empty() || d.waterfall.size() < 3) return {};
  const bool is_one = d.found.size() == 1;
  const char* what = is_one ? "it" : "them";
  if (d.verdict == Verdict::unexplained)
    what = is_one ? "the nearest effect" : "the nearest effects";
  if (d.verdict == Verdict::inconclusive)
    what = is_one ? "the most probable effect" : "the most probable effects";
  return fmt::format("With {} the error on readings kept out of the fit goes {} times the noise.",
                     what, fall_in_words(d.waterfall));
}

// " of the load", " at joint q2": whose laws they are, where several effects have some.
std::string whose_laws(const vjm::Robot& robot, const Diagnosis& d, const Answer& answer) {
  if (d.found.size() < 2 || answer.places.empty()) return {};
  if (answer.places.front() == "load") return " of the load";
  if (answer.places.front() == "sensor") return " of the instrument";
  return " at " + places_in_words(robot, answer.places);
}

std::string laws_sentences(const vjm::Robot& robot, const Diagnosis& d) {
  std::string text;
  for (const FoundEffect& found : d.found) {
    if (std::string laws = laws_text(found.decision);
        !laws.empty() && found.decision.answers.front().laws.front().share < decisive_law) {
      std::replace(laws.begin(), laws.end(), '_', ' ');
      const std::string whose = whose_laws(robot, d, found.decision.answers.front());
      text += wrapped(fmt::format("Which law{}: {}.", whose, laws), 0, 2);
    }
    if (const std::string why = inseparable_text(found.decision); !why.empty())
      text += wrapped(capitalised(why) + ".", 0, 2);
  }
  return text;
}

std::string remarks_text(const vjm::Robot& robot, const calibration::Campaign& campaign,
                         const Diagnosis& d) {
  std::vector<std::string> said = remarks(robot, campaign, d);
  std::erase(said, headline(robot, campaign, d));  // it stands above
  for (std::size_t i = 0; i < std::min(d.missing.size(), most_missing); ++i)
    said.push_back("Missing: " + d.missing[i] + ".");
  std::string text;
  for (std::size_t i = 0; i < std::min(said.size(), most_remarks); ++i)
    text += wrapped(said[i], 0, 2);
  if (said.size() > most_remarks)
    text += fmt::format("({} more remark{} with --verbose)\n", said.size() - most_remarks,
                        said.size() == most_remarks + 1 ? "" : "s");
  return text;
}

std::string excluded_text(const vjm::Robot& robot, const Diagnosis& d) {
  constexpr double possible = 0.01;
  std::vector<std::string> less_likely, not_it;
  for (const auto& [name, probability] : excluded(robot, d, most_excluded))
    (probability > possible ? less_likely : not_it)
        .push_back(fmt::format("{} ({})", name, odds(probability)));
  return (less_likely.empty() ? "" : labelled("less likely:", 18, listed(less_likely, "and"))) +
         (not_it.empty() ? "" : labelled("not it:", 18, listed(not_it, "and")));
}

std::string unseen_text(const Diagnosis& d) {
  std::vector<std::string> kinds = not_observable(d);
  if (kinds.empty()) return {};
  const std::size_t all = kinds.size();
  kinds.resize(std::min(all, most_unseen));
  if (all > most_unseen) kinds.push_back(fmt::format("{} more", all - most_unseen));
  return labelled("not observable:", 18, listed(kinds, "and"));
}

}  // namespace

std::string headline(const vjm::Robot& robot, const calibration::Campaign& campaign,
                     const Diagnosis& d) {
  if (d.by_kinematics)
    return fmt::format(
        "Calibrate the kinematics first: geometric errors of all joints and links together "
        "explain {:.0f} % of the error; no single effect does.",
        100 * *d.by_kinematics);
  switch (d.verdict) {
    case Verdict::identified:
    case Verdict::narrowed_down:
      return effects_in_words(robot, campaign, d);
    case Verdict::unexplained: {
      if (!d.unit_error.empty()) return d.unit_error;
      const std::string factor = depends_on(d);
      return fmt::format("Something is missing that the catalogue does not hold{}.",
                         factor.empty() ? "" : ": the error depends on " + factor);
    }
    case Verdict::none_needed:  // with stiffnesses that make up for wrong units
      return d.unit_error.empty() ? nothing_in_words(robot, d) : d.unit_error;
    default:
      if (names_something(d)) return effects_in_words(robot, campaign, d);
      return d.noise == calibration::NoiseSource::unknown
                 ? "Inconclusive: it is not known how exact the readings are."
                 : "Inconclusive: these readings do not show which effect is missing.";
  }
}

std::string verdict_in_short(const vjm::Robot& robot, const Diagnosis& d) {
  if (d.by_kinematics) return "errors of the geometry: calibrate the kinematics first";
  std::string text;
  for (const FoundEffect& found : d.found)
    text += (text.empty() ? "" : "; ") + found_in_short(robot, found);
  switch (d.verdict) {
    case Verdict::identified:
    case Verdict::narrowed_down:
      return text;
    case Verdict::unexplained:
      return d.unit_error.empty() ? "something outside the catalogue"
                                  : "a mistake in units, signs or frames";
    case Verdict::none_needed:
      return d.doubted ? fmt::format("nothing, most probably ({})",
                                     short_percent(d.doubted->decision.nothing))
                       : "nothing: no effect is needed";
    default:
      return names_something(d) ? text : "inconclusive";
  }
}

std::vector<std::pair<std::string, double>> excluded(const vjm::Robot& robot, const Diagnosis& d,
                                                     std::size_t most) {
  constexpr double improbable = 0.05;
  std::vector<std::pair<std::string, double>> result;
  const DiagnosisStep* step = step_of(d);
  if (d.found.empty() || step == nullptr || d.verdict == Verdict::unexplained) return result;
  for (const RankedCandidate& r : step->ranking) {
    const vjm::Effect& effect = r.candidate.effect;
    if (!r.fit && (!r.is_hopeless || is_relative(d, r.candidate))) continue;
    const double probability = r.fit ? r.fit->probability : 0;
    if (is_answer(d, effect) || probability > improbable) continue;
    result.emplace_back(effect_in_words(bare(robot), effect.kind->name, effect.at), probability);
  }
  std::stable_sort(result.begin(), result.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  result.resize(std::min(result.size(), most));
  return result;
}

std::vector<std::string> not_observable(const Diagnosis& d) {
  std::vector<std::string> kinds;
  for (const calibration::UnseenKind& kind : calibration::unseen_kinds(d)) {
    if (!kind.reason.empty()) continue;
    std::string words = kind.name;
    std::replace(words.begin(), words.end(), '_', ' ');
    kinds.push_back(words);
  }
  return kinds;
}

std::string first_screen(const vjm::Robot& robot, const calibration::Campaign& campaign,
                         const Diagnosis& d, const std::string& next) {
  std::string text = wrapped(headline(robot, campaign, d)) + wrapped(error_sentence(d)) +
                     laws_sentences(robot, d) + remarks_text(robot, campaign, d);
  if (const std::string bars = falling_error(d.waterfall, stage_names(robot, d)); !bars.empty())
    text += "\n" + bars;
  if (const std::string rest = excluded_text(robot, d) + unseen_text(d); !rest.empty())
    text += "\n" + rest;
  return text + (next.empty() ? "" : "\n" + next);
}

}  // namespace kinetostat::report

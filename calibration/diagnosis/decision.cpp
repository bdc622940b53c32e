#include "kinetostat/calibration/diagnosis/decision.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace kinetostat::calibration {
namespace {

std::string class_of(const vjm::EffectKind& kind) {
  return kind.effect_class == vjm::EffectClass::other ? kind.name : to_string(kind.effect_class);
}

// Something that may be so, and its log weight.
struct Hypothesis {
  std::string family, place;
  double log_weight = 0;
  const RankedCandidate* ranked = nullptr;  // none: nothing is missing, or the smooth discrepancy
  std::size_t candidate = 0;
  double probability = 0;
};

// A size at the end of its range, which design has not put there.
bool is_at_limit(const RankedCandidate& ranked) {
  const auto& parameters = ranked.candidate.effect.kind->parameters;
  if (!ranked.fit || std::ssize(parameters) != ranked.fit->values.size()) return false;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const vjm::EffectParameter& p = parameters[k];
    const double value = ranked.fit->values[static_cast<Eigen::Index>(k)];
    if (!p.is_shape && p.usual_angular.empty() && value != p.none &&
        (value == p.lower || value == p.upper))
      return true;
  }
  return false;
}

const char* const nothing = "nothing";
const char* const unexplained = "unexplained";

bool ends_with_name(const std::string& drive, const std::string& at) {
  return drive == at || drive.ends_with("." + at) || at.ends_with("." + drive);
}

class Posterior {
 public:
  Posterior(const DiagnosisStep& step, const DecisionRules& rules) : step_(step), rules_(rules) {
    add_fitted();
    if (!hypotheses_.empty()) add_imitators();
    hypotheses_.push_back({.family = nothing,
                           .place = "",
                           .log_weight = rules.exponent * (step.log_evidence_without +
                                                           std::log(rules.odds_of_nothing))});
    add_discrepancy();
    normalise();
  }

  Decision decision() const {
    Decision decision;
    decision.nothing = probability_of(nothing);
    decision.unexplained = probability_of(unexplained);
    decision.depends_on = step_.free_form.depends_on;
    std::vector<Answer> all = answers();
    decision.is_none_needed =
        decision.nothing >= rules_.lead_of_nothing * most_probable(all, decision.unexplained);
    double sum = 0;
    bool only_answers = true;
    for (Answer& answer : all) {
      if (sum >= rules_.level) break;
      sum += answer.probability;
      only_answers &= !answer.laws.empty();
      if (!answer.laws.empty()) decision.answers.push_back(std::move(answer));
    }
    decision.is_identified = only_answers && decision.answers.size() == 1;
    decision.is_narrowed_down = !decision.is_identified && !decision.is_none_needed &&
                                !decision.answers.empty() &&
                                decision.answers.size() <= rules_.most_answers;
    return decision;
  }

 private:
  void add_fitted() {
    for (std::size_t c = 0; c < step_.ranking.size(); ++c) {
      const RankedCandidate& ranked = step_.ranking[c];
      if (!ranked.fit) continue;
      hypotheses_.push_back({.family = family_of(*ranked.candidate.effect.kind),
                             .place = ranked.candidate.effect.at,
                             .log_weight = rules_.exponent * ranked.fit->log_evidence,
                             .ranked = &ranked,
                             .candidate = c});
    }
  }

  // They explain what the best does, but for what their signatures cannot.
  void add_imitators() {
    const Hypothesis best = hypotheses_.front();
    for (std::size_t c = 0; c < step_.ranking.size(); ++c) {
      const RankedCandidate& ranked = step_.ranking[c];
      if (ranked.fit || !ranked.falls_short) continue;
      hypotheses_.push_back(
          {.family = family_of(*ranked.candidate.effect.kind),
           .place = ranked.candidate.effect.at,
           .log_weight = best.log_weight - rules_.exponent * *ranked.falls_short / 2,
           .ranked = &ranked,
           .candidate = c});
    }
  }

  // Each part of it where it belongs.
  void add_discrepancy() {
    std::vector<Hypothesis> parts;
    for (const FreeFormEvidence::Part& part : step_.free_form.parts())
      if (part.share > 0) parts.push_back(discrepancy(part));
    hypotheses_.insert(hypotheses_.end(), parts.begin(), parts.end());
  }

  Hypothesis discrepancy(const FreeFormEvidence::Part& part) const {
    const double log_weight =
        rules_.exponent * (step_.log_evidence_without + step_.free_form.log) + std::log(part.share);
    Hypothesis own{.family = unexplained, .place = "", .log_weight = log_weight};
    if (!part.drive.empty()) {
      own.family = "load-deflection curve";
      own.place = part.drive;
      for (const Hypothesis& h : hypotheses_)
        if (h.family == own.family && ends_with_name(part.drive, h.place)) own.place = h.place;
    } else {
      const bool is_memory = part.over == SmoothOver::earlier_loads;
      if (part.over == SmoothOver::temperature)
        own.family = to_string(vjm::EffectClass::temperature);
      if (is_memory || part.over == SmoothOver::time)
        own.family = to_string(vjm::EffectClass::time);
      for (const Hypothesis& h : hypotheses_)
        if (h.family == own.family && h.ranked &&
            (!is_memory || h.ranked->candidate.effect.kind->history > 0)) {
          own.place = h.place;
          break;
        }
    }
    // A law there that explains something by itself.
    const bool has_place = std::any_of(hypotheses_.begin(), hypotheses_.end(), [&](const auto& h) {
      return h.family == own.family && h.place == own.place && h.ranked &&
             (!h.ranked->fit || h.ranked->fit->log_evidence > step_.log_evidence_without);
    });
    if (!has_place) own = {.family = unexplained, .place = "", .log_weight = log_weight};
    return own;
  }

  void normalise() {
    double most = -std::numeric_limits<double>::infinity(), sum = 0;
    for (const Hypothesis& h : hypotheses_) most = std::max(most, h.log_weight);
    for (Hypothesis& h : hypotheses_) sum += h.probability = std::exp(h.log_weight - most);
    for (Hypothesis& h : hypotheses_) h.probability /= sum;
  }

  // Of what may be missing, `unexplained` included.
  static double most_probable(const std::vector<Answer>& all, double unexplained_probability) {
    double most = unexplained_probability;
    for (const Answer& answer : all)
      if (!answer.laws.empty()) most = std::max(most, answer.probability);
    return most;
  }

  double probability_of(const char* family) const {
    double sum = 0;
    for (const Hypothesis& h : hypotheses_)
      if (h.family == family) sum += h.probability;
    return sum;
  }

  // Does the place of `h` predict what the best of all does?
  bool is_place_of_best(const Hypothesis& h, const Hypothesis& best) const {
    if (!h.ranked || h.family != best.family) return false;
    return h.place == best.place || !h.ranked->fit ||
           h.ranked->fit->discriminability < rules_.same_place;
  }

  // Is it of another class than the best, and moves the platform as that does?
  bool moves_like_best(const Hypothesis& h, const Hypothesis& best) const {
    return h.ranked && h.family != best.family &&
           shown_class(*h.ranked->candidate.effect.kind) ==
               shown_class(*best.ranked->candidate.effect.kind) &&
           (!h.ranked->fit || h.ranked->fit->discriminability < rules_.same_place);
  }

  // It moves the platform as the best does, with no more values and no worse: only priors speak
  // against it.
  bool is_as_good(const Hypothesis& h, const Hypothesis& best) const {
    if (!best.ranked || !best.ranked->fit || !h.ranked || !h.ranked->fit) return false;
    const CandidateFit &own = *h.ranked->fit, &its = *best.ranked->fit;
    return moves_like_best(h, best) && own.degrees_of_freedom >= its.degrees_of_freedom &&
           own.squared_error - its.squared_error < discriminable_from * discriminable_from;
  }

  // Groups of hypotheses, the most probable first; those without laws are no answers.
  std::vector<Answer> answers() const {
    std::map<std::pair<std::string, std::string>, std::vector<const Hypothesis*>> groups;
    const Hypothesis* best = nullptr;
    // Where two are the same but for rounding, the first: it is that which others are distinguished
    // from.
    constexpr double rounding = 1e-5;
    for (const Hypothesis& h : hypotheses_)
      if (h.ranked && h.ranked->fit && (!best || h.log_weight > best->log_weight + rounding))
        best = &h;
    std::vector<std::string> places_of_best;
    for (const Hypothesis& h : hypotheses_)
      if (best && is_place_of_best(h, *best)) places_of_best.push_back(h.place);
    for (const Hypothesis& h : hypotheses_) {
      const bool with_best =
          best && h.family == best->family &&
          std::find(places_of_best.begin(), places_of_best.end(), h.place) != places_of_best.end();
      if (with_best || (best && moves_like_best(h, *best)))
        groups[{best->family, best->place}].push_back(&h);
      else
        groups[{h.family, h.place}].push_back(&h);
    }
    std::vector<Answer> all;
    all.reserve(groups.size());
    for (const auto& [key, members] : groups) all.push_back(answer_of(members));
    std::stable_sort(all.begin(), all.end(), [](const Answer& a, const Answer& b) {
      return a.probability > b.probability;
    });
    return all;
  }

  Answer answer_of(std::vector<const Hypothesis*> members) const {
    std::stable_sort(members.begin(), members.end(),
                     [](const auto* a, const auto* b) { return a->log_weight > b->log_weight; });
    Answer answer;
    std::map<std::string, double> of_class;
    double of_laws = 0;
    // Beside the smooth error of their place all laws may be most improbable.
    const auto first_law = std::find_if(members.begin(), members.end(),
                                        [](const Hypothesis* h) { return h->ranked != nullptr; });
    for (const Hypothesis* h : members) {
      answer.probability += h->probability;
      if (!h->ranked) continue;
      const double weight = std::exp(h->log_weight - (*first_law)->log_weight);
      of_laws += weight;
      const std::string limit = class_at_limit(*h, members);
      of_class[limit.empty() ? class_of(*h->ranked->candidate.effect.kind) : limit] += weight;
      if (std::find(answer.places.begin(), answer.places.end(), h->place) == answer.places.end())
        answer.places.push_back(h->place);
      answer.laws.push_back({.candidate = h->candidate,
                             .effect = h->ranked->candidate.effect.kind->name,
                             .at = h->place,
                             .share = weight,
                             .is_at_limit = !limit.empty()});
    }
    for (LawShare& law : answer.laws) law.share /= of_laws;
    std::vector<std::string> classes = classes_that_hold(of_class, of_laws);
    for (const Hypothesis* h : members)
      if (is_as_good(*h, *members.front()))
        if (std::string own = class_of(*h->ranked->candidate.effect.kind);
            std::find(classes.begin(), classes.end(), own) == classes.end())
          classes.push_back(std::move(own));
    answer.effect_class = fmt::format("{}", fmt::join(classes, ", or "));
    answer.is_inseparable = classes.size() > 1 && members.front()->ranked &&
                            std::any_of(members.begin(), members.end(), [&](const auto* h) {
                              return moves_like_best(*h, *members.front());
                            });
    return answer;
  }

  // That of the law that another one ends at, among those of its answer, the most probable first;
  // else empty.
  static std::string class_at_limit(const Hypothesis& h,
                                    const std::vector<const Hypothesis*>& members) {
    if (!is_at_limit(*h.ranked)) return {};
    const std::string own = class_of(*h.ranked->candidate.effect.kind);
    for (const Hypothesis* other : members) {
      if (!other->ranked || !other->ranked->fit || is_at_limit(*other->ranked)) continue;
      if (std::string its = class_of(*other->ranked->candidate.effect.kind); its != own) return its;
    }
    return {};
  }

  // The class that holds the level within its answer, or all of them, the most probable first.
  std::vector<std::string> classes_that_hold(const std::map<std::string, double>& of_class,
                                             double sum) const {
    std::vector<std::pair<double, std::string>> order;
    order.reserve(of_class.size());
    for (const auto& [name, probability] : of_class) order.emplace_back(-probability, name);
    std::sort(order.begin(), order.end());
    std::vector<std::string> classes;
    double held = 0;
    for (const auto& [probability, name] : order) {
      if (held >= rules_.level * sum) break;
      held -= probability;
      classes.push_back(name);
    }
    return classes;
  }

  const DiagnosisStep& step_;
  const DecisionRules& rules_;
  std::vector<Hypothesis> hypotheses_;
};

}  // namespace

std::vector<DescribedRule> described(const DecisionRules& rules) {
  return {
      {"level", rules.level, "probability", "convention",
       "fewer or more answers are called identified"},
      {"exponent", rules.exponent, "1", "largest log score over the hidden effects",
       "0.3 to 1 moves 3 of 102 verdicts of the trial"},
      {"odds of nothing", rules.odds_of_nothing, "1", "as many as there are kinds",
       "moves the threshold by 0.7 of log evidence"},
      {"same place", rules.same_place, "d'", "two standard deviations",
       "1 to 4 moves 3 of 102 verdicts of the trial"},
      {"longest list", static_cast<double>(rules.most_answers), "answers", "what one can act on",
       "more or fewer lists are called inconclusive"},
      {"lead of nothing", rules.lead_of_nothing, "1", "the most probable answer is named",
       "0.5 loses 3 of 29 effects of d' 5, 2 keeps most false alarms"},
  };
}

std::string family_of(const vjm::EffectKind& kind) {
  switch (kind.effect_class) {
    case vjm::EffectClass::backlash:
    case vjm::EffectClass::stiffening:
      return "load-deflection curve";
    case vjm::EffectClass::other:
      return kind.name;
    default:
      return to_string(kind.effect_class);
  }
}

Decision decide(const DiagnosisStep& step, const DecisionRules& rules) {
  if (step.ranking.empty() || !step.ranking.front().fit) return {};
  return Posterior(step, rules).decision();
}

}  // namespace kinetostat::calibration

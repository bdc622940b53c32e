#include "kinetostat/calibration/design/plan_question.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/calibration/diagnosis/diagnosis_result.h"
#include "kinetostat/common/error.h"

namespace kinetostat::calibration {
namespace {

constexpr std::size_t most_open = 10;
constexpr double visible = 4;       // d' from which readings show an effect
constexpr double ruled_out = 1e-6;  // probability below which there is nothing to distinguish

// In the words of ranking.h, or in those of a diagnosis that was written before.
bool says_confounded(const std::string& reason) {
  return reason == confounded_with_fit ||
         reason == "what it does, the refitted parameters do just as well in these readings";
}

class Questioner {
 public:
  Questioner(const vjm::Robot& robot, const DiagnosisRecord& diagnosis)
      : diagnosis_(diagnosis), all_(candidates(robot, {})) {
    for (const RecordedStep& step : diagnosis.steps)
      for (const RecordedCandidate& entry : step.ranking) take_priors(entry.effect);
  }

  PlanQuestion ask(const std::vector<std::string>& show) const {
    PlanQuestion question;
    question.verdict = to_string(diagnosis_.verdict);
    const auto is = [&](Verdict verdict) { return diagnosis_.verdict == verdict; };
    for (const RecordedFinding& found : diagnosis_.found)
      question.present.push_back(with_values(find(found.effect.name()), found.effect.values));
    if (!show.empty()) {
      add_shown(show, question);
    } else if (is(Verdict::narrowed_down) ||
               (is(Verdict::inconclusive) && !diagnosis_.ambiguous.empty())) {
      if (!question.present.empty()) question.present.pop_back();  // it is one of the candidates
      for (const std::string& name : diagnosis_.ambiguous)
        question.open.push_back(with_probability_of_answer(open(name, question)));
      if (!diagnosis_.found.empty()) question.nothing = diagnosis_.found.back().nothing;
      question.perhaps_nothing = question.open.size() == 1;
      if (question.perhaps_nothing && !diagnosis_.found.empty()) {
        // All laws of the answer count, against all that it is not.
        question.open.front().probability = diagnosis_.found.back().probability;
        question.nothing = 1 - question.open.front().probability;
      }
    } else if (is(Verdict::none_needed) && diagnosis_.doubted) {
      add_doubted(*diagnosis_.doubted, question);
    } else if (is(Verdict::unexplained)) {
      if (!question.present.empty()) question.present.pop_back();
      add_nearest(question);
    } else if (is(Verdict::inconclusive)) {
      if (diagnosis_.instead_of_refit)
        add_shown({diagnosis_.instead_of_refit->name()}, question);
      else
        add_unseen(question);
    }
    if (question.open.size() > most_open) question.open.resize(most_open);
    return question;
  }

 private:
  // Usual sizes are those of the diagnosis, which its readings have set.
  void take_priors(const RecordedEffect& entry) {
    for (Candidate& candidate : all_) {
      if (candidate.name() != entry.name() ||
          entry.parameters.size() != candidate.deviations.size())
        continue;
      for (std::size_t k = 0; k < entry.parameters.size(); ++k)
        candidate.deviations[k] = entry.parameters[k].prior_sd;
      candidate = at_size(candidate, 1, 1);
    }
  }

  Candidate find(const std::string& name) const {
    for (const Candidate& candidate : all_)
      if (candidate.name() == name) return candidate;
    throw common::InputError({.file = diagnosis_.file,
                              .key = "found",
                              .what = fmt::format("this robot cannot have '{}'", name),
                              .cure = "Run 'kinetostat diagnose' again on this robot file"});
  }

  static Candidate with_values(Candidate candidate, const std::vector<double>& values) {
    for (std::size_t k = 0; k < values.size() && k < candidate.deviations.size(); ++k)
      if (!std::isnan(values[k])) candidate.effect.values[static_cast<Eigen::Index>(k)] = values[k];
    return candidate;
  }

  // Of the round that looked for what comes beside all that is present.
  const std::vector<RecordedCandidate>& ranking(const PlanQuestion& question) const {
    static const std::vector<RecordedCandidate> none;
    std::vector<std::string> present;
    for (const Candidate& candidate : question.present) present.push_back(candidate.name());
    const std::vector<RecordedStep>& steps = diagnosis_.steps;
    for (auto step = steps.rbegin(); step != steps.rend(); ++step)
      if (std::is_permutation(step->beside.begin(), step->beside.end(), present.begin(),
                              present.end()))
        return step->ranking;
    return steps.empty() ? none : steps.back().ranking;
  }

  OpenCandidate open_candidate_of(const RecordedCandidate& entry) const {
    OpenCandidate open{.candidate = find(entry.effect.name()), .log_evidence = {}};
    if (!entry.is_fitted) return open;
    open.candidate = with_values(open.candidate, entry.effect.values);
    open.is_fitted = true;
    open.probability = entry.probability;
    open.log_evidence = entry.log_evidence;
    return open;
  }

  // As it was fitted in that round; else in the last one where it was.
  OpenCandidate open(const std::string& name, const PlanQuestion& question) const {
    std::vector<const std::vector<RecordedCandidate>*> rankings{&ranking(question)};
    for (auto step = diagnosis_.steps.rbegin(); step != diagnosis_.steps.rend(); ++step)
      rankings.push_back(&step->ranking);
    for (const auto* entries : rankings)
      for (const RecordedCandidate& entry : *entries)
        if (entry.effect.name() == name && entry.is_fitted) return open_candidate_of(entry);
    return {.candidate = find(name), .log_evidence = {}};
  }

  // All laws of an answer count for the one that stands for it, whatever the round thought of that
  // one alone; one that has an answer was fitted then.
  OpenCandidate with_probability_of_answer(OpenCandidate open) const {
    for (const RecordedFinding& found : diagnosis_.found)
      for (const RecordedAnswer& answer : found.answers)
        if (std::find(answer.laws.begin(), answer.laws.end(), open.candidate.name()) !=
            answer.laws.end()) {
          open.probability = answer.probability;
          open.is_fitted = true;
        }
    return open;
  }

  // What may be missing all the same, and nothing.
  void add_doubted(const RecordedFinding& doubted, PlanQuestion& question) const {
    question.open.push_back(open(doubted.effect.name(), question));
    for (const std::string& name : doubted.instead) question.open.push_back(open(name, question));
    for (OpenCandidate& candidate : question.open) candidate.probability *= 1 - doubted.nothing;
    question.perhaps_nothing = true;
    question.nothing = doubted.nothing;
  }

  // Those that came nearest, though they do not explain the readings.
  void add_nearest(PlanQuestion& question) const {
    question.in_catalogue = 0;
    for (const RecordedCandidate& entry : ranking(question)) {
      if (!entry.is_fitted) continue;
      question.in_catalogue += entry.probability;
      if (question.open.size() < 4 && entry.probability > ruled_out)
        question.open.push_back(open_candidate_of(entry));
    }
  }

  // The best place of every kind that was not observable.
  void add_unseen(PlanQuestion& question) const {
    question.perhaps_nothing = true;
    std::map<std::string, const RecordedCandidate*> best;
    std::vector<std::string> order;
    for (const RecordedCandidate& entry : ranking(question)) {
      const auto [found, fresh] = best.emplace(entry.effect.effect, &entry);
      if (fresh) order.push_back(entry.effect.effect);
      if (entry.detectability > found->second->detectability) found->second = &entry;
    }
    for (const std::string& kind : order)
      if (best[kind]->detectability < visible)
        question.open.push_back(open_candidate_of(*best[kind]));
  }

  void add_shown(const std::vector<std::string>& show, PlanQuestion& question) const {
    question.perhaps_nothing = true;
    for (const std::string& wanted : show) {
      const std::size_t before = question.open.size();
      for (const Candidate& candidate : all_)
        if ((candidate.name() == wanted || candidate.effect.kind->name == wanted) &&
            question.open.size() < most_open)
          question.open.push_back(open(candidate.name(), question));
      if (question.open.size() == before)
        throw std::invalid_argument(
            fmt::format("this robot has no place for '{}', or has it already", wanted));
    }
    add_unseen_beside(question);
  }

  // Effects that are confounded with fitted parameters will be so again.
  void add_unseen_beside(PlanQuestion& question) const {
    for (const RecordedCandidate& entry : ranking(question)) {
      const std::string name = entry.effect.name();
      const auto is_it = [&](const OpenCandidate& s) { return s.candidate.name() == name; };
      if (entry.most_detectability < visible && !says_confounded(entry.unobservable) &&
          std::none_of(question.open.begin(), question.open.end(), is_it))
        question.unseen.push_back(find(name));
    }
  }

  const DiagnosisRecord& diagnosis_;
  std::vector<Candidate> all_;
};

}  // namespace

PlanQuestion question_of(const vjm::Robot& robot, const DiagnosisRecord& diagnosis,
                         const std::vector<std::string>& show) {
  return Questioner(robot, diagnosis).ask(show);
}

}  // namespace kinetostat::calibration

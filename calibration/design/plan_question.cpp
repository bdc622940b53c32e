#include "kinetostat/calibration/design/plan_question.h"

#include <algorithm>
#include <set>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/calibration/diagnosis/diagnosis_result.h"
#include "kinetostat/common/error.h"

namespace kinetostat::calibration {
namespace {

using io::Json;

constexpr std::size_t most_open = 10;
constexpr double visible = 4;  // d' from which readings show an effect

// In the words of ranking.h, or in those of a diagnosis that was written before.
bool says_confounded(const std::string& reason) {
  return reason == confounded_with_fit ||
         reason == "what it does, the refitted parameters do just as well in these readings";
}

std::string name_of(const Json& entry) {
  return fmt::format("{} at {}", entry.at("effect").get<std::string>(),
                     entry.at("at").get<std::string>());
}

class Questioner {
 public:
  Questioner(const vjm::Robot& robot, const Json& diagnosis, const std::filesystem::path& file)
      : diagnosis_(diagnosis), file_(file), all_(candidates(robot, {})) {
    for (const Json& step : diagnosis.at("steps"))
      for (const Json& entry : step.at("ranking")) take_priors(entry);
  }

  PlanQuestion ask(const std::vector<std::string>& show) const {
    PlanQuestion question;
    const std::optional<Verdict> given = verdict_named(diagnosis_.at("verdict").get<std::string>());
    if (!given)
      throw common::InputError({.file = file_,
                                .key = "verdict",
                                .what = "is none that a diagnosis has",
                                .cure = "Run 'kinetostat diagnose' again"});
    question.verdict = to_string(*given);
    const auto is = [&](Verdict verdict) { return given == verdict; };
    for (const Json& found : diagnosis_.at("found"))
      question.present.push_back(with_values(find(name_of(found)), found.at("values")));
    if (!show.empty()) {
      add_shown(show, question);
    } else if (is(Verdict::narrowed_down) ||
               (is(Verdict::inconclusive) && !diagnosis_.at("ambiguous").empty())) {
      if (!question.present.empty()) question.present.pop_back();  // it is one of the candidates
      for (const Json& name : diagnosis_.at("ambiguous"))
        question.open.push_back(open(name.get<std::string>(), question));
      question.perhaps_nothing = question.open.size() == 1;
    } else if (is(Verdict::unexplained)) {
      if (!question.present.empty()) question.present.pop_back();
      add_nearest(question);
    } else if (is(Verdict::inconclusive)) {
      const Json instead = diagnosis_.value("instead_of_refit", Json());
      if (instead.is_object())
        add_shown({name_of(instead)}, question);
      else
        add_unseen(question);
    }
    if (question.open.size() > most_open) question.open.resize(most_open);
    return question;
  }

 private:
  // Usual sizes are those of the diagnosis, which its readings have set.
  void take_priors(const Json& entry) {
    const std::string name = name_of(entry);
    for (Candidate& candidate : all_) {
      const Json& parameters = entry.at("parameters");
      if (candidate.name() != name || parameters.size() != candidate.deviations.size()) continue;
      for (std::size_t k = 0; k < parameters.size(); ++k)
        candidate.deviations[k] = parameters[k].at("prior_sd").get<double>();
      candidate = at_size(candidate, 1, 1);
    }
  }

  Candidate find(const std::string& name) const {
    for (const Candidate& candidate : all_)
      if (candidate.name() == name) return candidate;
    throw common::InputError({.file = file_,
                              .key = "found",
                              .what = fmt::format("this robot cannot have '{}'", name),
                              .cure = "Run 'kinetostat diagnose' again on this robot file"});
  }

  static Candidate with_values(Candidate candidate, const Json& values) {
    for (std::size_t k = 0; k < values.size() && k < candidate.deviations.size(); ++k)
      if (values[k].is_number())
        candidate.effect.values[static_cast<Eigen::Index>(k)] = values[k].get<double>();
    return candidate;
  }

  static const Json& none() {
    static const Json empty = Json::array();
    return empty;
  }

  // Of the round that looked for what comes beside all that is present.
  const Json& ranking(const PlanQuestion& question) const {
    std::vector<std::string> present;
    for (const Candidate& candidate : question.present) present.push_back(candidate.name());
    const Json& steps = diagnosis_.at("steps");
    for (auto step = steps.rbegin(); step != steps.rend(); ++step) {
      const auto beside = step->at("beside").get<std::vector<std::string>>();
      if (std::is_permutation(beside.begin(), beside.end(), present.begin(), present.end()))
        return step->at("ranking");
    }
    return steps.empty() ? none() : steps.back().at("ranking");
  }

  OpenCandidate open_candidate_of(const Json& entry) const {
    OpenCandidate open{.candidate = find(name_of(entry)), .log_evidence = {}};
    if (!entry.contains("fit")) return open;
    const Json& fit = entry.at("fit");
    open.candidate = with_values(open.candidate, fit.at("values"));
    open.is_fitted = true;
    open.probability = fit.at("probability").get<double>();
    open.log_evidence = fit.at("log_evidence").get<double>();
    return open;
  }

  // As it was fitted in that round; else in the last one where it was.
  OpenCandidate open(const std::string& name, const PlanQuestion& question) const {
    std::vector<const Json*> rankings{&ranking(question)};
    const Json& steps = diagnosis_.at("steps");
    for (auto step = steps.rbegin(); step != steps.rend(); ++step)
      rankings.push_back(&step->at("ranking"));
    for (const Json* entries : rankings)
      for (const Json& entry : *entries)
        if (name_of(entry) == name && entry.contains("fit")) return open_candidate_of(entry);
    return {.candidate = find(name), .log_evidence = {}};
  }

  // Those that came nearest, though they do not explain the readings.
  void add_nearest(PlanQuestion& question) const {
    for (const Json& entry : ranking(question))
      if (entry.contains("fit") && question.open.size() < 4)
        question.open.push_back(open_candidate_of(entry));
  }

  // The best place of every kind that was not observable.
  void add_unseen(PlanQuestion& question) const {
    question.perhaps_nothing = true;
    std::map<std::string, const Json*> best;
    std::vector<std::string> order;
    for (const Json& entry : ranking(question)) {
      const auto kind = entry.at("effect").get<std::string>();
      const auto [found, fresh] = best.emplace(kind, &entry);
      if (fresh) order.push_back(kind);
      const auto seen = [](const Json& e) { return e.at("detectability").get<double>(); };
      if (!fresh && seen(entry) > seen(*found->second)) found->second = &entry;
    }
    for (const std::string& kind : order)
      if (best[kind]->at("detectability").get<double>() < visible)
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
    for (const Json& entry : ranking(question)) {
      const std::string name = name_of(entry);
      const auto is_it = [&](const OpenCandidate& s) { return s.candidate.name() == name; };
      if (entry.at("most_detectability").get<double>() < visible &&
          !says_confounded(entry.value("reason", "")) &&
          std::none_of(question.open.begin(), question.open.end(), is_it))
        question.unseen.push_back(find(name));
    }
  }

  const Json& diagnosis_;
  const std::filesystem::path& file_;
  std::vector<Candidate> all_;
};

}  // namespace

PlanQuestion question_of(const vjm::Robot& robot, const Json& diagnosis,
                         const std::filesystem::path& file, const std::vector<std::string>& show) {
  try {
    return Questioner(robot, diagnosis, file).ask(show);
  } catch (const Json::exception& error) {
    throw common::InputError({.file = file,
                              .what = fmt::format("this is no diagnosis: {}", error.what()),
                              .cure = "Give the file that 'kinetostat diagnose -o' wrote"});
  }
}

}  // namespace kinetostat::calibration

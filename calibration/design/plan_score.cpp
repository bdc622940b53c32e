#include "kinetostat/calibration/design/plan_score.h"

#include <cmath>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/diagnosis/diagnosis_result.h"
#include "kinetostat/calibration/regression/wrench_noise.h"
#include "kinetostat/common/error.h"

namespace kinetostat::calibration {
namespace {

using io::Json;

// The fit of a candidate in the last round that has one.
const CandidateFit* fit_of(const Diagnosis& diagnosis, const std::string& name) {
  for (auto step = diagnosis.steps.rbegin(); step != diagnosis.steps.rend(); ++step)
    for (const RankedCandidate& ranked : step->ranking)
      if (ranked.fit && ranked.candidate.name() == name) return &*ranked.fit;
  return nullptr;
}

// Evidence for one of them so far, then with the readings of the plan.
SplitScore score_split(const Json& split, const Diagnosis& diagnosis) {
  SplitScore score{.a = split.at("a").get<std::string>(),
                   .b = split.at("b").get<std::string>(),
                   .expected = split.at("nats").get<double>(),
                   .realised = {},
                   .why_not = {}};
  const Json& so_far = split.at("log_evidence_difference_so_far");
  const CandidateFit *a = fit_of(diagnosis, score.a), *b = fit_of(diagnosis, score.b);
  if (a == nullptr || b == nullptr)
    score.why_not = fmt::format("'{}' has no fit now", a == nullptr ? score.a : score.b);
  else if (so_far.is_null())
    score.why_not = "there was no evidence before";
  else
    score.realised = std::abs(a->log_evidence - b->log_evidence - so_far.get<double>());
  return score;
}

// Deviations of the base fit with what was found, by the names that plans use.
std::vector<std::pair<std::string, double>> deviations_now(const vjm::Robot& robot,
                                                           const Campaign& campaign,
                                                           const Diagnosis& diagnosis, int threads,
                                                           common::Progress& progress) {
  std::vector<Candidate> present;
  for (const FoundEffect& found : diagnosis.found) present.push_back(found.candidate);
  const Noise noise = noise_of(robot, campaign, threads, progress);
  const BaseFit fit =
      CandidateFitter(robot, campaign, noise, threads, progress).fit(present, nullptr, progress);
  std::vector<std::pair<std::string, double>> result;
  for (const ParameterEstimate& estimate : fit.parameters)
    result.emplace_back(estimate.parameter.phrase(), estimate.standard_error);
  return result;
}

}  // namespace

PlanScore score_plan(const Json& plan, const std::filesystem::path& file, const vjm::Robot& robot,
                     const Campaign& campaign, const Diagnosis& diagnosis, int threads,
                     common::Progress& progress) {
  PlanScore score;
  try {
    for (const Json& split : plan.at("splits"))
      score.splits.push_back(score_split(split, diagnosis));
    if (plan.at("sharpened").empty()) return score;
    const auto now = deviations_now(robot, campaign, diagnosis, threads, progress);
    for (const Json& entry : plan.at("sharpened")) {
      score.sharpened.push_back({.name = entry.at("name").get<std::string>(),
                                 .before = entry.at("deviation_now").get<double>(),
                                 .expected = entry.at("deviation_expected").get<double>(),
                                 .realised = {}});
      for (const auto& [name, deviation] : now)
        if (name == score.sharpened.back().name) score.sharpened.back().realised = deviation;
    }
  } catch (const Json::exception& error) {
    throw common::InputError({.file = file,
                              .what = fmt::format("this is no plan: {}", error.what()),
                              .cure = "Give the file that 'kinetostat plan --json' wrote"});
  }
  return score;
}

}  // namespace kinetostat::calibration

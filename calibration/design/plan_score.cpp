#include "kinetostat/calibration/design/plan_score.h"

#include <cmath>

#include <fmt/format.h>

#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/diagnosis/diagnosis_result.h"
#include "kinetostat/calibration/regression/campaign_noise.h"

namespace kinetostat::calibration {
namespace {

// The fit of a candidate in the last round that has one.
const CandidateFit* fit_of(const Diagnosis& diagnosis, const std::string& name) {
  for (auto step = diagnosis.steps.rbegin(); step != diagnosis.steps.rend(); ++step)
    for (const RankedCandidate& ranked : step->ranking)
      if (ranked.fit && ranked.candidate.name() == name) return &*ranked.fit;
  return nullptr;
}

// Evidence for one of them so far, then with the readings of the plan.
SplitScore score_split(const PlannedSplit& split, const Diagnosis& diagnosis) {
  SplitScore score{
      .a = split.a, .b = split.b, .expected = split.nats, .realised = {}, .why_not = {}};
  const CandidateFit *a = fit_of(diagnosis, score.a), *b = fit_of(diagnosis, score.b);
  if (a == nullptr || b == nullptr)
    score.why_not = fmt::format("'{}' has no fit now", a == nullptr ? score.a : score.b);
  else if (!split.so_far)
    score.why_not = "there was no evidence before";
  else
    score.realised = std::abs(a->log_evidence - b->log_evidence - *split.so_far);
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

PlanScore score_plan(const PlanPromise& promise, const vjm::Robot& robot, const Campaign& campaign,
                     const Diagnosis& diagnosis, int threads, common::Progress& progress) {
  PlanScore score;
  for (const PlannedSplit& split : promise.splits)
    score.splits.push_back(score_split(split, diagnosis));
  if (promise.sharpened.empty()) return score;
  const auto now = deviations_now(robot, campaign, diagnosis, threads, progress);
  for (const PlannedSharpening& s : promise.sharpened) {
    score.sharpened.push_back(
        {.name = s.name, .before = s.before, .expected = s.after, .realised = {}});
    for (const auto& [name, deviation] : now)
      if (name == s.name) score.sharpened.back().realised = deviation;
  }
  return score;
}

}  // namespace kinetostat::calibration

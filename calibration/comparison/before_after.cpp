#include "kinetostat/calibration/comparison/before_after.h"

#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/regression/campaign_noise.h"

namespace kinetostat::calibration {
namespace {

double confirmed_by(const Assessment& assessment) {
  for (const HeldOutReadings& part : assessment.held_out)
    if (part.role == Role::confirm && part.failure.empty())
      return std::sqrt(part.squared_error / static_cast<double>(part.values));
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

BeforeAfter compare_before_after(const vjm::Robot& before, const vjm::Robot& after,
                                 const Campaign& campaign, int threads, common::Progress& progress,
                                 Loss loss) {
  BeforeAfter result;
  const CompareOptions options{.loss = loss, .keep_equations = true};
  result.before = compare(before, campaign, threads, progress, options);
  result.after = compare(after, campaign, threads, progress, options);
  const Noise noise = noise_of(before, campaign, threads, progress);
  if (noise.source == NoiseSource::unknown) return result;
  const std::vector<Value> values = values_in_use(only(campaign, {Role::fit}));
  const HeldOutGroups groups = held_out_groups(campaign, values);
  result.held_out = groups.what;
  const auto add = [&](const std::string& name, const Assessment& assessment) {
    result.stages.push_back(
        waterfall_stage(name, assessment.fit, campaign, values, noise, groups, 1));
    result.stages.back().confirmed = confirmed_by(assessment);
  };
  for (const auto& [name, comparison] :
       {std::pair("before", &result.before), std::pair("after", &result.after)}) {
    add(std::string(name) + ", as designed", comparison->nominal);
    if (comparison->fitted) add(std::string(name) + ", refitted", *comparison->fitted);
  }
  result.stages.push_back(noise_floor(campaign, values, noise));
  return result;
}

}  // namespace kinetostat::calibration

#include "kinetostat/calibration/regression/campaign_noise.h"

#include "kinetostat/calibration/regression/datum_noise.h"
#include "kinetostat/calibration/regression/undetermined.h"
#include "kinetostat/calibration/regression/wrench_noise.h"

namespace kinetostat::calibration {

Noise noise_of(const vjm::Robot& robot, const Campaign& campaign, int threads,
               common::Progress& progress) {
  Noise stated = with_datums_seen(noise_of(campaign, replicate_groups(campaign)), robot, campaign,
                                  threads, progress);
  if (campaign.wrench_covariance.empty()) return stated;
  std::vector<Parameter> parameters = uncertain_parameters(robot);
  const Predictor predictor(robot.without_effects(), robot.effects, campaign, threads, progress);
  keep_undetermined(predictor, campaign, stated, parameters, progress);
  const Noise first =
      with_wrench_noise(stated, campaign, predictor, parameters, starts_of(parameters), progress);
  const auto with = [&](const std::vector<Parameter>& unknowns) {
    return fit_base(predictor, campaign, first, unknowns, progress);
  };
  const BaseFit fit =
      fit_near_design(parameters, with, [&] { return first.source != NoiseSource::unknown; });
  return with_wrench_noise(stated, campaign, predictor, parameters, values_of(fit), progress, &fit);
}

}  // namespace kinetostat::calibration

// Fits of candidates to the shipped load cell, which lacks an effect.
#include "kinetostat/calibration/search/candidate_fitter.h"

#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/regression/evidence.h"

namespace kinetostat::calibration::candidate_fitter_test {
namespace {

// A first look may stop anywhere; what is finished is where the whole fit ends.
TEST(CandidateFitter, FinishedFromAFirstLookItIsTheWholeFit) {
  const std::string source = KINETOSTAT_SOURCE_DIR;
  const vjm::Robot robot = vjm::read_robot(source + "/data/robots/bench.yaml");
  const Campaign campaign =
      read_campaign(source + "/data/measurements/nist_load_cell/campaign.yaml", robot.manipulator);
  const Noise noise = noise_of(campaign, {});
  common::Progress silent;
  const CandidateFitter fitter(robot, campaign, noise, 1, silent);
  const BaseFit base = fitter.fit({}, nullptr, silent);
  int stopped_early = 0;
  for (const Candidate& candidate :
       candidates(robot, {"hardening", "load_hardening", "friction", "clearance"})) {
    SCOPED_TRACE(candidate.name());
    const BaseFit whole = fitter.fit({candidate}, &base, silent);
    const BaseFit rough = fitter.fit_on_one_thread({candidate}, base, 1e4, silent);
    std::vector<Candidate> found = {candidate};
    found[0].effect.values = fitted_values(rough, found).front().values;
    const BaseFit finished = fitter.finished(found, rough, silent);
    EXPECT_LE(rough.iterations, whole.iterations);
    stopped_early += rough.iterations < whole.iterations;
    EXPECT_LE(penalised_error(finished), penalised_error(rough) * (1 + 1e-12));
    EXPECT_NEAR(penalised_error(finished), penalised_error(whole), 1e-6 * penalised_error(whole));
  }
  EXPECT_GE(stopped_early, 1);
}

}  // namespace
}  // namespace kinetostat::calibration::candidate_fitter_test

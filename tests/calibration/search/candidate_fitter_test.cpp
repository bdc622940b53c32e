// Fits of candidates to shipped readings.
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
    const BaseFit rough = fitter.fit_on_one_thread({candidate}, base, {}, 1e4, silent);
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

// Of an arm with all joints uncertain, the drive with the law among them: a serial chain carries
// the same forces whatever its stiffnesses, so that the rough cost is what the model's own bends
// leave.
TEST(CandidateFitter, CondensedFitsEndWhereFitsDo) {
  const std::string folder = KINETOSTAT_SOURCE_DIR "/data/measurements/six_axis_balancer/";
  const vjm::Robot robot = vjm::read_robot(folder + "robot.yaml");
  const Campaign campaign = read_campaign(folder + "campaign.yaml", robot.manipulator);
  const Noise noise = noise_of(campaign, {});
  common::Progress silent;
  const CandidateFitter fitter(robot, campaign, noise, 1, silent);
  const BaseFit base = fitter.fit({}, nullptr, silent);
  const std::vector<Candidate> all =
      candidates(robot, {"hardening", "directional_stiffness", "friction", "clearance"});
  const FittedModel beside = fitter.beside({}, base, all);
  int ended = 0, evaluations = 0, of_whole_fits = 0;
  for (const Candidate& candidate : all) {
    if (!candidate.effect.kind->acts_on_joint_alone) continue;
    SCOPED_TRACE(candidate.name());
    const auto rough = fitter.fit_condensed({candidate}, beside, silent);
    ASSERT_TRUE(rough);
    const BaseFit whole = fitter.fit({candidate}, &base, silent);
    const BaseFit from_there = fitter.fit_on_one_thread({candidate}, base, rough, 0, silent);
    const double gained = penalised_error(base) - penalised_error(from_there);
    EXPECT_LE(penalised_error(from_there), penalised_error(whole) + 1e-3 * gained + 1);
    EXPECT_NEAR(rough->cost, penalised_error(from_there), 0.02 * gained + 1);
    of_whole_fits += whole.iterations;
    evaluations += from_there.iterations;
    ++ended;
  }
  EXPECT_GE(ended, 12);
  EXPECT_LT(evaluations, of_whole_fits);
}

}  // namespace
}  // namespace kinetostat::calibration::candidate_fitter_test

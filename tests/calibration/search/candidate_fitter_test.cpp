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

// In differences, so that no frame is fitted.
class SignaturesOfAnArm : public testing::Test {
 protected:
  // Of the readings, where one more effect acts beside the fitted model and all else stays.
  Eigen::VectorXd change_with(const Candidate& candidate) {
    return fitter_.as_fitted({candidate}, base_, silent_).at.residual - base_.at.residual;
  }

  const std::string folder_ = KINETOSTAT_SOURCE_DIR "/data/measurements/arm_hysteresis/";
  const vjm::Robot robot_ = vjm::read_robot(folder_ + "robot.yaml");
  const Campaign campaign_ = read_campaign(folder_ + "campaign.yaml", robot_.manipulator);
  const Noise noise_ = noise_of(campaign_, {});
  common::Progress silent_;
  const CandidateFitter fitter_{robot_, campaign_, noise_, 1, silent_};
  const BaseFit base_ = fitter_.fit({}, nullptr, silent_);
};

TEST_F(SignaturesOfAnArm, AreTheChangesOfTheReadings) {
  int grown = 0, all = 0;
  for (const Candidate& candidate :
       candidates(robot_, {"geometric_error", "bearing_compliance", "clearance", "wrench_gain"})) {
    SCOPED_TRACE(candidate.name());
    const auto signatures = fitter_.signatures_of(candidate, {}, base_, silent_);
    for (std::size_t i = 0; i < signatures.all.size(); ++i) {
      const Signature& signature = signatures.all[i];
      const Eigen::VectorXd change = change_with(signatures.starts[i]);
      const bool is_grown = signature.growth[0] > 1;
      EXPECT_LE((signature.columns.col(0) - change).norm(),
                (is_grown ? 0.02 : 1e-6) * change.norm() + 1e-9);
      grown += is_grown ? 1 : 0;
      ++all;
    }
  }
  EXPECT_GE(grown, 3);
  EXPECT_GT(all, 2 * grown);
}

// Smaller and smaller ones are left out where they would be the same again.
TEST_F(SignaturesOfAnArm, LeaveOutWhatIsAlike) {
  int left_out = 0;
  for (const Candidate& candidate : candidates(robot_, {"clearance", "friction", "hardening"})) {
    SCOPED_TRACE(candidate.name());
    const auto signatures = fitter_.signatures_of(candidate, {}, base_, silent_);
    if (signatures.all.empty() || signatures.all[0].columns.col(0).norm() < least_visible) continue;
    const Candidate smallest = at_size(candidate, 0.008, 1);
    const Eigen::VectorXd direction = change_with(smallest).normalized();
    double nearest = 2;
    bool is_there = false;
    for (std::size_t i = 0; i < signatures.all.size(); ++i) {
      nearest =
          std::min(nearest, (signatures.all[i].columns.col(0).normalized() - direction).norm());
      is_there |= signatures.starts[i].effect.values == smallest.effect.values;
    }
    EXPECT_LT(nearest, 0.03);
    left_out += is_there ? 0 : 1;
  }
  EXPECT_GE(left_out, 3);
}

}  // namespace
}  // namespace kinetostat::calibration::candidate_fitter_test

// Datums are as exact as the readings show, and never noisier than usual.
#include "kinetostat/calibration/regression/datum_noise.h"

#include <cmath>
#include <map>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/datum.h"
#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/campaign/replicates.h"
#include "kinetostat/calibration/statistics/normal.h"

#include "calibration/laboratory.h"

namespace kinetostat::calibration::datum_noise_test {
namespace {

using test::Laboratory;

const std::string slide =
    "kinetostat: 1\nname: slide\nunits: {length: mm, force: N, angle: deg}\nchain_types:\n  cell:\n"
    "    - actuator: {name: q, axis: Tz, stiffness: 1000}\n"
    "manipulator: {chain: cell}\nuncertain:\n  - {stiffness: q}\n";

// Loads of six levels in each cycle, a minute a reading.
std::string cycles(int count) {
  std::string plan = "id,cycle,step,time,fz\n";
  for (int n = 0; n < 6 * count; ++n)
    plan += fmt::format("a{0},{1},{0},{2},{3}\n", n, n / 6, 60 * n, 100 * (1 + n % 6));
  return plan;
}

// Whose unloaded readings are exact, but not said to be.
Campaign measured(int count, Laboratory& laboratory) {
  Campaign campaign = laboratory.measure(cycles(count));
  campaign.datum_noise.setConstant(std::nan(""));
  return campaign;
}

// Moves all readings of a cycle by an error of their unloaded state, `factor` times their noise.
void add_datums(double factor, std::uint64_t seed, Campaign& campaign) {
  Normal normal(seed);
  std::map<std::string, double> datum;
  for (Reading& reading : campaign.readings) {
    const auto [found, fresh] = datum.try_emplace(reading.cycle, 0);
    if (fresh) found->second = factor * reading.sigma[2] * normal();
    reading.displacement[2] += found->second;
  }
}

// Variance of the datums that are seen, in units of a reading's.
double seen(const Laboratory& laboratory, const Campaign& campaign) {
  common::Progress silent;
  const Noise noise = with_datums_seen(noise_of(campaign, replicate_groups(campaign)),
                                       laboratory.robot(), campaign, 1, silent);
  return std::pow(noise.datums.at(0).sigma[2] / noise.sigma[0][2], 2);
}

TEST(DatumNoise, IsLessWhereTheUnloadedReadingsWereExact) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Laboratory laboratory(slide);
    laboratory.options().seed = seed;
    EXPECT_LE(seen(laboratory, measured(100, laboratory)), 1.01 * usual_datum_variance / 4);
  }
}

TEST(DatumNoise, StaysAsUsualWhereItIs) {
  int kept = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Laboratory laboratory(slide);
    laboratory.options().seed = seed;
    Campaign campaign = measured(40, laboratory);
    add_datums(std::sqrt(usual_datum_variance), seed, campaign);
    const double variance = seen(laboratory, campaign);
    EXPECT_GT(variance, 0.49 * usual_datum_variance);
    kept += variance > 0.99 * usual_datum_variance;
  }
  EXPECT_GE(kept, 18);
}

TEST(DatumNoise, IsNeverMoreThanUsual) {
  Laboratory laboratory(slide);
  Campaign campaign = measured(40, laboratory);
  add_datums(3, 1, campaign);
  EXPECT_DOUBLE_EQ(seen(laboratory, campaign), usual_datum_variance);
}

TEST(DatumNoise, StaysAsUsualWhereFewCyclesSayNothing) {
  Laboratory laboratory(slide);
  EXPECT_DOUBLE_EQ(seen(laboratory, measured(3, laboratory)), usual_datum_variance);
}

TEST(DatumNoise, StaysAsItIsStated) {
  Laboratory laboratory(slide);
  Campaign campaign = measured(40, laboratory);
  campaign.datum_noise.setConstant(1e-6);
  EXPECT_NEAR(seen(laboratory, campaign), 4, 1e-9);
}

// A drift that lasts makes cycles differ, and is no noise of their datums.
TEST(DatumNoise, IsNotWhatADriftDoes) {
  Laboratory laboratory(slide);
  laboratory.hide("session_drift", "sensor", "z=4e-5 um/s");
  EXPECT_LE(seen(laboratory, measured(100, laboratory)), 1.01 * usual_datum_variance / 4);
}

// What a model lacks is no noise of single readings, beside which datums would look exact.
TEST(DatumNoise, StaysAsUsualWhereMuchIsMissing) {
  Laboratory laboratory(slide);
  laboratory.hide("hardening", "q", "k3=1e13 N/m^3");
  Campaign campaign = measured(100, laboratory);
  add_datums(std::sqrt(usual_datum_variance), 1, campaign);
  EXPECT_DOUBLE_EQ(seen(laboratory, campaign), usual_datum_variance);
}

// Estimated from replicates, over their true noise: that of `count` cycles with datums of `factor`
// times it, said to be `said` times it (NaN: not said).
double estimated(int count, double factor, double said, std::uint64_t seed) {
  Laboratory laboratory(slide);
  laboratory.options().seed = seed;
  Campaign campaign = measured(count, laboratory);
  add_datums(factor, seed, campaign);
  const double sigma = campaign.readings[0].sigma[2];
  campaign.datum_noise.setConstant(said * sigma);
  campaign.noise_stated = false;
  common::Progress silent;
  const Noise noise = with_datums_seen(noise_of(campaign, replicate_groups(campaign)),
                                       laboratory.robot(), campaign, 1, silent);
  return noise.sigma[0][2] / sigma;
}

TEST(ReplicateNoise, IsThatOfReadingsWhateverTheirDatumsHave) {
  const double usual = std::sqrt(usual_datum_variance), unsaid = std::nan("");
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    EXPECT_NEAR(estimated(100, 0, unsaid, seed), 1, 0.1);
    EXPECT_NEAR(estimated(100, usual, unsaid, seed), 1, 0.1);
    EXPECT_NEAR(estimated(100, 0, 0, seed), 1, 0.1);
    EXPECT_NEAR(estimated(100, 4, 4, seed), 1, 0.1);
  }
}

}  // namespace
}  // namespace kinetostat::calibration::datum_noise_test

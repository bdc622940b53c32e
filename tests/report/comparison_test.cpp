#include "kinetostat/report/comparison.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetostat::report {
namespace {

using calibration::Campaign;
using calibration::Comparison;
using testing::HasSubstr;
using testing::Not;

// Two differences of one posture along x, counted from one unloaded reading.
Campaign differences() {
  Campaign campaign;
  campaign.displacement = calibration::DisplacementKind::difference;
  campaign.noise_stated = true;
  campaign.sessions = {""};
  campaign.configurations.resize(1);
  for (const double force : {100.0, 200.0}) {
    calibration::Reading reading;
    reading.load.force.x() = force;
    reading.displacement.setConstant(std::numeric_limits<double>::quiet_NaN());
    reading.sigma = reading.displacement;
    reading.displacement[0] = 1e-8 * force;
    reading.sigma[0] = 1e-6;
    campaign.readings.push_back(reading);
  }
  return campaign;
}

std::string finding_of(const Campaign& campaign, double statistic) {
  Comparison comparison;
  comparison.nominal.chi_square = calibration::chi_square_test(statistic, 100);
  const std::vector<std::string> all = findings(campaign, comparison);
  return all.empty() ? "" : all.front();
}

// Readings that agree better than noise allows: the assumed noise of the datum may be why.
TEST(ComparisonText, NamesTheDatumWhereNoiseSeemsOverstated) {
  Campaign campaign = differences();
  EXPECT_THAT(finding_of(campaign, 60), HasSubstr("'datum_noise: {translation: 0 um}'"));
  EXPECT_THAT(finding_of(campaign, 100), Not(HasSubstr("datum_noise")));
  campaign.datum_noise.setZero();
  EXPECT_THAT(finding_of(campaign, 60), HasSubstr("overstated"));
  EXPECT_THAT(finding_of(campaign, 60), Not(HasSubstr("datum_noise")));
}

TEST(ComparisonText, NamesNoDatumWhereNoneIsShared) {
  Campaign campaign = differences();
  campaign.displacement = calibration::DisplacementKind::absolute;
  EXPECT_THAT(finding_of(campaign, 60), Not(HasSubstr("datum_noise")));
}

}  // namespace
}  // namespace kinetostat::report

#include "kinetostat/report/comparison.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/regression/datum_noise.h"

namespace kinetostat::report {
namespace {

using calibration::Campaign;
using calibration::Comparison;
using testing::HasSubstr;
using testing::Not;

// Differences of one posture along x, counted from one unloaded reading; so many that their noise
// is not sought.
Campaign differences() {
  Campaign campaign;
  campaign.displacement = calibration::DisplacementKind::difference;
  campaign.noise_stated = true;
  campaign.sessions = {""};
  campaign.configurations.resize(1);
  for (std::size_t i = 0; i <= calibration::most_for_datums; ++i) {
    calibration::Reading reading;
    const double force = i % 2 == 0 ? 100 : 200;
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
  Campaign shorter = campaign;
  shorter.readings.pop_back();
  EXPECT_THAT(finding_of(shorter, 60), Not(HasSubstr("datum_noise")));
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

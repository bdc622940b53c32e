#include "kinetostat/calibration/comparison/unit_error.h"

#include <cmath>
#include <random>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/comparison/compare.h"
#include "kinetostat/report/comparison.h"
#include "kinetostat/report/screen/diagnosis.h"
#include "kinetostat/spatial/rotation.h"

#include "calibration/laboratory.h"

namespace kinetostat::calibration::unit_error_test {
namespace {

using spatial::Vector6;
using testing::HasSubstr;
using testing::IsEmpty;

// Absolute positions in the frame of a tracker, deflections of a millimetre in them.
Campaign tracked(const spatial::Pose& tracker, std::vector<Eigen::VectorXd>& predicted) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  Campaign campaign;
  campaign.displacement = DisplacementKind::absolute;
  campaign.sessions = {""};
  for (int i = 0; i < 12; ++i) {
    const spatial::Vector3 at(normal(random), normal(random), normal(random));
    Vector6 y = Vector6::Zero();
    y.head<3>() = at;
    predicted.emplace_back(y);
    Reading& reading = campaign.readings.emplace_back();
    reading.displacement.setConstant(NAN);
    reading.displacement.head<3>() =
        tracker.inverse() * (at + 1e-3 * spatial::Vector3(normal(random), 0, normal(random)));
  }
  return campaign;
}

TEST(UnitError, AnInstrumentThatStandsElsewhereIsNamed) {
  std::vector<Eigen::VectorXd> predicted;
  const Campaign elsewhere =
      tracked({spatial::exp_rotation(spatial::Vector3(0.1, 0.4, -1)), {2, 1, 0.3}}, predicted);
  EXPECT_THAT(unit_error(elsewhere, predicted), HasSubstr("Say 'session_frame: estimate'"));
  Campaign mirrored = elsewhere;
  for (Reading& reading : mirrored.readings) reading.displacement[1] *= -1;
  EXPECT_THAT(unit_error(mirrored, predicted), HasSubstr("left-handed axes"));
  predicted.clear();
  const Campaign at_base = tracked({}, predicted);
  EXPECT_THAT(unit_error(at_base, predicted), IsEmpty());
}

// Displacements that are `factor` times the predicted ones, with a zero offset of their own and
// some noise.
struct Scaled {
  Campaign campaign;
  std::vector<Eigen::VectorXd> predicted;

  Scaled(double factor, std::vector<Eigen::Index> components, double noise = 0.02) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    campaign.sessions = {"monday", "tuesday"};
    for (std::size_t i = 0; i < 24; ++i) {
      Vector6 y = Vector6::Constant(NAN);
      Reading reading;
      reading.session = i % 2;
      reading.displacement = y;
      for (const Eigen::Index k : components) {
        y[k] = 1e-4 * normal(random);
        reading.displacement[k] = factor * (y[k] + noise * 1e-4 * normal(random)) +
                                  5 * static_cast<double>(reading.session) * factor * 1e-4;
      }
      predicted.push_back(y);
      campaign.readings.push_back(reading);
    }
  }
  std::string slip() const { return unit_error(campaign, predicted); }
};

TEST(UnitError, IsSeenByItsFactorAndSign) {
  EXPECT_THAT(Scaled(1000, {0, 1, 2}).slip(), HasSubstr("as of um taken for mm"));
  EXPECT_THAT(Scaled(1e-3, {2}).slip(), HasSubstr("as of mm taken for um"));
  EXPECT_THAT(Scaled(25.4, {0}).slip(), HasSubstr("as of mm taken for inch"));
  EXPECT_THAT(Scaled(180 / M_PI, {3, 4, 5}).slip(), HasSubstr("as of deg taken for rad"));
  EXPECT_THAT(Scaled(9.8, {0, 1, 2}).slip(), HasSubstr("as of wrenches in kgf for N"));
  EXPECT_THAT(Scaled(-1, {0, 1, 2}).slip(), HasSubstr("against the predicted ones"));
  EXPECT_THAT(Scaled(100, {0, 1, 2}).slip(),
              HasSubstr("times the predicted ones, in the same pattern"));
  EXPECT_THAT(Scaled(100, {0, 1, 2}).slip(), testing::Not(HasSubstr("as of")));
}

// What is read too small drowns in noise, of which it is known how much there is.
TEST(UnitError, IsSeenThroughTheNoise) {
  Scaled drowned(1 / 25.4, {0, 1, 2}, 0.65);
  EXPECT_THAT(drowned.slip(), IsEmpty());
  drowned.campaign.noise_stated = true;
  for (Reading& reading : drowned.campaign.readings)
    reading.sigma = Vector6::Constant(0.65e-4 / 25.4);
  EXPECT_THAT(drowned.slip(), HasSubstr("as of inch taken for mm"));
}

TEST(UnitError, IsNoWrongStiffnessAndNoNoise) {
  EXPECT_THAT(Scaled(1, {0, 1, 2, 3, 4, 5}).slip(), IsEmpty());
  EXPECT_THAT(Scaled(5, {0, 1, 2}).slip(), IsEmpty());
  EXPECT_THAT(Scaled(0.2, {0, 1, 2}).slip(), IsEmpty());
  EXPECT_THAT(Scaled(1000, {0, 1, 2}, 10).slip(), IsEmpty());
}

// Of rotations alone: translations say that the stiffness is right.
TEST(UnitError, OfAFewTimesIsSeenInRotationsBesideTranslations) {
  const auto slip = [](double translations, double rotations) {
    Scaled both(translations, {0, 1, 2, 3, 4, 5});
    for (Reading& reading : both.campaign.readings)
      reading.displacement.tail<3>() *= rotations / translations;
    EXPECT_THAT(both.slip(), IsEmpty());
    return rotation_unit_error(both.campaign, both.predicted);
  };
  EXPECT_THAT(slip(1.1, 1.1 / 4.848), HasSubstr("as of arcsec taken for urad"));
  EXPECT_THAT(slip(0.9, 0.9 * 4.848), HasSubstr("as of urad taken for arcsec"));
  EXPECT_THAT(slip(1, 4), IsEmpty());  // a wrist that yields
  EXPECT_THAT(slip(1.6, 1.6 * 4.848), IsEmpty());
}

// A load cell in kN whose readings were written down as N: said first, before what follows of it.
TEST(UnitError, IsTheFirstFinding) {
  test::Laboratory laboratory(
      "kinetostat: 1\nname: slide\nunits: {length: mm, force: N, angle: deg}\nchain_types:\n"
      "  cell:\n    - actuator: {name: q, axis: Tz, stiffness: 1000}\n"
      "manipulator: {chain: cell}\n");
  Campaign campaign = laboratory.measure(
      "id,cycle,step,fz\na,1,1,0\nb,1,2,300\nc,1,3,600\nd,1,4,0\ne,1,5,-300\nf,1,6,-600\n");
  common::Progress silent;
  EXPECT_THAT(compare(laboratory.robot(), campaign, 1, silent).unit_error, IsEmpty());
  for (Reading& reading : campaign.readings) reading.load = reading.load.scaled(1e-3);
  EXPECT_THAT(report::findings(campaign, compare(laboratory.robot(), campaign, 1, silent)).at(0),
              HasSubstr("wrenches in kN for N"));
  const Diagnosis d = laboratory.diagnose(campaign, {"friction"});
  EXPECT_THAT(report::text(laboratory.robot(), campaign, d), HasSubstr("wrenches in kN for N"));
}

// A spring that is 25 times as stiff makes up for it: nothing else is missing, and still it is
// that.
TEST(UnitError, HeadsADiagnosisThatFindsNothingElse) {
  test::Laboratory laboratory(
      "kinetostat: 1\nname: slide\nunits: {length: mm, force: N, angle: deg}\nchain_types:\n"
      "  cell:\n    - actuator: {name: q, axis: Tz, stiffness: 1000}\n"
      "manipulator: {chain: cell}\nuncertain:\n  - {stiffness: q}\n");
  laboratory.options().components = {false, false, true, false, false, false};
  laboratory.options().translation_noise = 2e-6;
  std::string plan = "id,cycle,step,fz\n";
  for (int r = 0; r < 36; ++r)
    plan += fmt::format("r{},c{},{},{}\n", r, r / 6, r % 6, (r * 37 % 11 - 5) * 120);
  Campaign campaign = laboratory.measure(plan);
  for (Reading& reading : campaign.readings) {
    reading.displacement /= 25.4;
    reading.sigma /= 25.4;
  }
  const Diagnosis d = laboratory.diagnose(campaign, {});
  EXPECT_EQ(d.verdict, Verdict::none_needed);
  EXPECT_THAT(report::headline(laboratory.robot(), campaign, d), HasSubstr("inch taken for mm"));
}

}  // namespace
}  // namespace kinetostat::calibration::unit_error_test

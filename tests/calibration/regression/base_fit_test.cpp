#include "kinetostat/calibration/regression/base_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/regression/session_frame.h"
#include "kinetostat/calibration/statistics/identifiability.h"
#include "kinetostat/common/error.h"
#include "kinetostat/report/base_fit.h"
#include "kinetostat/vjm/chain/chain_builder.h"

#include "calibration/synthetic.h"
#include "vjm/effect_catalogue.h"

namespace kinetostat::calibration::base_fit_test {
namespace {

using testing::HasSubstr;

std::filesystem::path bench_campaign(const std::string& csv, const std::string& more = "") {
  return test::write_campaign(
      "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N, angle: rad}\n"
      "displacement: difference\nreadings: readings.csv\n" +
          more,
      csv);
}

double factor(const Comparison& comparison, std::size_t parameter) {
  return std::exp(comparison.fitted.value().fit.parameters.at(parameter).value);
}

class Recovery : public testing::TestWithParam<std::vector<double>> {};

TEST_P(Recovery, FindsKnownStiffnessesWithoutNoise) {
  const vjm::Robot nominal = test::orthoglide();
  std::vector<test::Planned> plan = test::orthoglide_plan(4, 3, 1);
  test::measure(test::scaled(nominal, GetParam()).manipulator, plan);
  const auto file = test::write(plan, {.more = "noise: {translation: 10 um, rotation: 20 urad}\n"});
  const Comparison c = test::compare_files(nominal, file);
  for (std::size_t i = 0; i < GetParam().size(); ++i)
    EXPECT_NEAR(factor(c, i) / GetParam()[i], 1, 1e-8);
}

INSTANTIATE_TEST_SUITE_P(Factors, Recovery,
                         testing::Values(std::vector<double>{1, 1}, std::vector<double>{0.7, 1.6},
                                         std::vector<double>{3, 0.3},
                                         std::vector<double>{0.5, 0.02}));

TEST(BaseFit, FindsStiffnessesFarFromTheNominalOnes) {
  for (const double true_factor : {0.01, 100.0}) {
    const auto file =
        bench_campaign(fmt::format("fz,dz\n1000,{}\n2000,{}\n", 1 / true_factor, 2 / true_factor));
    EXPECT_NEAR(factor(test::compare_files(test::bench(), file), 0), true_factor,
                1e-8 * true_factor);
  }
}

// Readings F/k + zero offset of the session, with deviations known in closed form.
TEST(BaseFit, EstimatesOneZeroOffsetPerSession) {
  const auto file = bench_campaign("session,fz,dz\na,1000,3\na,2000,4\nb,1000,-4\nb,3000,-2\n",
                                   "zero: estimate\n");
  const Comparison c = test::compare_files(test::bench(2e6), file);
  const BaseFit& fit = c.fitted->fit;
  EXPECT_NEAR(factor(c, 0), 0.5, 1e-10);
  ASSERT_EQ(fit.zeros.size(), 2u);
  EXPECT_NEAR(fit.zeros[0].value, 2e-3, 1e-12);
  EXPECT_NEAR(fit.zeros[1].value, -5e-3, 1e-12);
  EXPECT_EQ(fit.degrees_of_freedom(), 1);
}

TEST(BaseFit, StandardErrorsFollowFromTheStatedNoise) {
  const auto file =
      bench_campaign("fz,dz\n1000,1.001\n2000,1.999\n-1000,-1\n",
                     "noise: {translation: 2 um}\ndatum_noise: {translation: 0 um}\n");
  const BaseFit fit = test::compare_files(test::bench(), file).fitted->fit;
  // dz = F/k: sd(1/k) = sigma / |F|, and d(1/k)/(1/k) = -d(log k).
  const double f = std::sqrt(6e6), k = 1e6 * std::exp(fit.parameters[0].value);
  EXPECT_NEAR(fit.parameters[0].standard_error, 2e-6 * k / f, 1e-9 * 2e-6 * k / f);
}

TEST(BaseFit, PreciseReadingsCountMore) {
  const auto file = bench_campaign("fz,dz,sigma\n1000,1.0,0.001\n1000,1.1,0.1\n");
  const Comparison c = test::compare_files(test::bench(), file);
  const double expected = (1.0 * 1e6 + 1.1 * 1e2) / (1e6 + 1e2);
  EXPECT_NEAR(1 / factor(c, 0), expected, 1e-10);
}

template <class Error>
std::string message(const vjm::Robot& robot, const std::filesystem::path& file) {
  try {
    const Comparison comparison = test::compare_files(robot, file);
    if (!comparison.refit_failure.empty()) return comparison.refit_failure;
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(BaseFit, SaysWhichStiffnessNoReadingDependsOn) {
  const auto file = bench_campaign("fz,dz\n0,0.1\n0,0.2\n");
  EXPECT_THAT(message<common::NotIdentifiable>(test::bench(), file),
              HasSubstr("no reading depends on the stiffness of 'spring'"));
}

// Two springs in series: one of them is fitted, and the other stays where it is.
TEST(BaseFit, KeepsWhatTheReadingsDoNotDistinguishAtItsNominalValue) {
  vjm::Robot robot = test::bench();
  vjm::ChainBuilder chain("cell");
  chain.actuator("spring", vjm::Motion::tz, 1e6).actuator("screw", vjm::Motion::tz, 2e6);
  robot.manipulator = vjm::Manipulator("bench", {chain.build()});
  robot.uncertain.push_back({"screw", {{0, "screw"}}});
  for (const char* noise : {"", "noise: {translation: 1 um}\n"}) {
    const Comparison c =
        test::compare_files(robot, bench_campaign("fz,dz\n1000,1\n2000,2\n3000,3\n", noise));
    ASSERT_TRUE(c.fitted) << c.refit_failure;
    EXPECT_NEAR(factor(c, 0), 2, 1e-9);  // 1 mm/kN is 0.5 and 0.5
    EXPECT_EQ(factor(c, 1), 1);
    EXPECT_THAT(c.notes, testing::Contains(HasSubstr("the stiffness of 'screw' stays at its "
                                                     "nominal value: it is confounded")));
  }
}

// A stiffness and a zero offset under one load: design distinguishes them.
TEST(BaseFit, HoldsAStiffnessNearItsDesignWhereAZeroOffsetDoesTheSame) {
  const Comparison c = test::compare_files(
      test::bench(), bench_campaign("fz,dz\n1000,1\n1000,2\n1000,3\n", "zero: estimate\n"));
  ASSERT_TRUE(c.fitted) << c.refit_failure;
  EXPECT_THAT(c.notes, testing::Contains(HasSubstr("known by design to a factor of 2.7")));
}

// A slide along x that carries a spring along z, both uncertain.
vjm::Robot slide_and_spring() {
  vjm::Robot robot = test::bench();
  vjm::ChainBuilder chain("cell");
  chain.actuator("slide", vjm::Motion::tx, 1e6).actuator("spring", vjm::Motion::tz, 1e6);
  robot.manipulator = vjm::Manipulator("bench", {chain.build()});
  robot.uncertain = {{"slide", {{0, "slide"}}}, {"spring", {{0, "spring"}}}};
  return robot;
}

TEST(BaseFit, KeepsAStiffnessThatNoReadingTurnsAtItsNominalValue) {
  const Comparison c = test::compare_files(
      slide_and_spring(),
      bench_campaign("fz,dz\n1000,0.5\n2000,1\n3000,1.5\n", "noise: {translation: 1 um}\n"));
  ASSERT_TRUE(c.fitted) << c.refit_failure;
  EXPECT_EQ(factor(c, 0), 1);
  EXPECT_NEAR(factor(c, 1), 2, 1e-9);
  EXPECT_EQ(c.fitted->fit.estimated, 1);
  EXPECT_EQ(c.best().adequacy, Adequacy::adequate);
  EXPECT_THAT(c.notes, testing::Contains(HasSubstr(
                           "the stiffness of 'slide' stays at its nominal value: no reading")));
}

// Readings that hardly load a spring know it less well than its design does.
TEST(BaseFit, AWeaklySeenStiffnessIsHeldNearItsDesign) {
  // 1 N on the slide is 1 um; the readings of x have an error of 2 um that would make it infinite.
  const Comparison c = test::compare_files(
      slide_and_spring(),
      bench_campaign("fx,fz,dx,dz\n1,1000,-0.002,1\n1,2000,0.001,2\n1,3000,-0.003,3\n",
                     "noise: {translation: 2 um}\n"));
  ASSERT_TRUE(c.fitted) << c.refit_failure;
  EXPECT_GT(factor(c, 0), 1 / std::exp(3.0));
  EXPECT_LT(factor(c, 0), std::exp(3.0));
  EXPECT_NEAR(factor(c, 1), 1, 2e-3);
  EXPECT_THAT(c.notes, testing::Contains(HasSubstr("known by design to a factor of 2.7")));
}

TEST(BaseFit, DoubtsAStiffnessFarFromItsDesign) {
  const Comparison c = test::compare_files(
      test::bench(),
      bench_campaign("fz,dz\n1000,4\n2000,8\n3000,12\n", "noise: {translation: 1 um}\n"));
  ASSERT_TRUE(c.fitted) << c.refit_failure;
  EXPECT_NEAR(factor(c, 0), 0.25, 1e-9);
  EXPECT_THAT(c.notes, testing::Contains(HasSubstr("is fitted to 0.25 times its nominal value")));
}

TEST(BaseFit, SaysWhenThereAreTooFewValues) {
  EXPECT_THAT(message<common::NotIdentifiable>(test::bench(), bench_campaign("fz,dz\n1000,1\n")),
              HasSubstr("1 measured values for 1 unknowns"));
}

TEST(BaseFit, SaysWhenTheReadingsContradictAnySpring) {
  const auto file = bench_campaign("fz,dz\n1000,-1\n2000,-2\n");
  EXPECT_THAT(
      message<common::NotIdentifiable>(test::bench(), file),
      HasSubstr("the stiffness of 'spring' cannot be determined, its best value is infinite"));
}

// Squares of squares of them would be infinite, and so would tests and evidences.
TEST(BaseFit, ErrorsBeyondComputingAreNamed) {
  for (const char* table :
       {"fz,dz\n1000,0.5\n2000,1e90\n", "fz,dz,sigma\n1000,0.5,1\n2000,1,1e-300\n",
        "fz,dz,sigma\n1000,0.5,1\n2000,1,1e-318\n"}) {
    const auto file = bench_campaign(table, "noise: {translation: 1 um}\n");
    try {
      (void)test::compare_files(test::bench(), file);
      ADD_FAILURE() << table;
    } catch (const common::InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("readings.csv:3: dz: the error of reading '2'"));
      EXPECT_THAT(error.what(), HasSubstr("too large to compute with"));
    }
  }
}

TEST(BaseFit, DoesNotMixMillimetresWithRadians) {
  vjm::Robot robot = test::bench();
  vjm::ChainBuilder chain("cell");
  chain.actuator("spring", vjm::Motion::tz, 1e6).actuator("twist", vjm::Motion::rz, 1e3);
  robot.manipulator = vjm::Manipulator("bench", {chain.build()});
  const std::string csv = "fz,mz,dz,rz\n1000,1000,1,1e-3\n2000,2000,2,2e-3\n";
  EXPECT_THAT(message<common::InputError>(robot, bench_campaign(csv, "wrench_point: reference\n")),
              HasSubstr("noise: translations and rotations cannot be fitted together"));
  const auto stated = bench_campaign(
      csv, "wrench_point: reference\nnoise: {translation: 1 um, rotation: 1 urad}\n");
  EXPECT_NEAR(factor(test::compare_files(robot, stated), 0), 1, 1e-9);
}

TEST(BaseFit, StopsAtBoundsThatTheUserStatesAndSaysSo) {
  vjm::Robot robot = test::bench();
  robot.uncertain[0].between = {0.9, 1.5};
  const auto file = bench_campaign("fz,dz\n1000,1.25\n2000,2.5\n3000,3.75\n");
  const Comparison c = test::compare_files(robot, file);
  const ParameterEstimate& spring = c.fitted->fit.parameters.at(0);
  EXPECT_DOUBLE_EQ(factor(c, 0), 0.9);  // 0.8 without the bound
  EXPECT_EQ(spring.hit, BoundHit::lower);
  EXPECT_EQ(c.fitted->fit.degrees_of_freedom(), 3);
  const Campaign campaign = read_campaign(file, robot.manipulator);
  EXPECT_THAT(report::text(campaign, c.fitted->fit),
              HasSubstr("the stiffness of 'spring' ends at its lower bound"));
}

TEST(BaseFit, SaysInWordsWhichCombinationIsWeak) {
  const std::vector<UnknownName> names = {{"the stiffness of 'leg'", true, true, {}},
                                          {"the stiffness of 'foot'", true, true, {}}};
  Eigen::MatrixXd jacobian(3, 2);
  jacobian << -100, -100, -200, -201, -300, -299;
  const auto sentences = weak_sentences(names, weak_combinations(jacobian, {0, 1}), 1);
  ASSERT_EQ(sentences.size(), 1u);
  EXPECT_THAT(sentences[0],
              HasSubstr("Of the stiffness of 'leg' and the stiffness of 'foot' these data know "
                        "well only their product: the stiffness of 'leg'"));
}

TEST(BaseFit, RobustLossKeepsAGrossErrorOutOfTheStiffness) {
  std::string csv = "id,fz,dz\n";
  for (int i = 1; i <= 20; ++i)
    csv += fmt::format("r{},{},{}\n", i, 100 * i, 0.1 * i + 0.001 * ((i * 7) % 5 - 2));
  const auto file = bench_campaign(csv + "bad,2000,9\n", "noise: {translation: 2 um}\n");
  const vjm::Robot robot = test::bench();
  const Campaign campaign = read_campaign(file, robot.manipulator);
  common::Progress silent;
  const auto fitted = [&](Loss loss) {
    const Comparison c = compare(robot, campaign, 1, silent, {.loss = loss});
    return factor(c, 0);
  };
  EXPECT_GT(std::abs(fitted(Loss::squares) - 1), 0.2);
  EXPECT_NEAR(fitted(Loss::huber), 1, 2e-3);
  EXPECT_NEAR(fitted(Loss::cauchy), 1, 2e-4);
  const Comparison c = compare(robot, campaign, 1, silent, {.loss = Loss::cauchy});
  EXPECT_THAT(report::text(campaign, c.fitted->fit),
              HasSubstr("1 readings counted less than half: bad"));
  EXPECT_NEAR(c.fitted->fit.parameters[0].standard_error, 2e-6 / std::sqrt(28.7e6) * 1e6, 2e-4);
}

TEST(BaseFit, RobustLossNeedsANoiseToMeasureBy) {
  const vjm::Robot robot = test::bench();
  const Campaign campaign =
      read_campaign(bench_campaign("fz,dz\n1000,1\n2000,2.1\n3000,3\n"), robot.manipulator);
  common::Progress silent;
  EXPECT_THROW(compare(robot, campaign, 1, silent, {.loss = Loss::huber}), common::InputError);
}

// Poses measured by two set-ups of a tracker that stands anywhere.
class Frames : public testing::TestWithParam<bool> {
 protected:
  // Writes what a tracker reads whose frame sees the base at `frame`, session by session.
  std::filesystem::path measured(const vjm::Manipulator& manipulator,
                                 const std::vector<spatial::Pose>& frames) const {
    const bool absolute = GetParam();
    std::string csv = "session,x,y,z,fx,fy,fz,dx,dy,dz,rx,ry,rz\n";
    for (std::size_t s = 0; s < frames.size(); ++s) {
      std::vector<test::Planned> plan = test::orthoglide_plan(5, 2, 20 + static_cast<unsigned>(s));
      for (test::Planned& r : plan) r.load.moment.setZero(), r.load.point_on_platform.setZero();
      test::measure(manipulator, plan);
      for (const test::Planned& r : plan) csv += row(r, s, frames[s], absolute);
    }
    return test::write_campaign(
        fmt::format("kinetostat: 1\ncampaign: c\nunits: {{length: m, force: N, angle: rad}}\n"
                    "displacement: {}\nsession_frame: estimate\nreadings: readings.csv\n"
                    "noise: {{translation: 10 um, rotation: 20 urad}}\n",
                    absolute ? "absolute" : "difference"),
        csv);
  }

  static std::string row(const test::Planned& r, std::size_t session, const spatial::Pose& frame,
                         bool absolute) {
    spatial::Vector6 seen;
    if (absolute) {
      const spatial::Pose pose =
          frame * spatial::displaced(spatial::Pose::translation(r.position), r.displacement);
      seen = spatial::pose_difference(spatial::Pose(), pose);
    } else {
      seen << frame.rotation() * r.displacement.head<3>(),
          frame.rotation() * r.displacement.tail<3>();
    }
    std::string text = fmt::format("s{}", session);
    for (const double v : r.position) text += fmt::format(",{}", v);
    for (const double v : r.load.force) text += fmt::format(",{}", v);
    for (const double v : seen) text += fmt::format(",{}", v);
    return text + "\n";
  }
};

TEST_P(Frames, OfEverySessionAreFoundTogetherWithTheStiffnesses) {
  const vjm::Robot nominal = test::orthoglide();
  const vjm::Manipulator truth = test::scaled(nominal, {0.8, 1.3}).manipulator;
  // The second tracker stands anywhere; small turns only where nothing says where to start.
  const spatial::Vector3 turn =
      GetParam() ? spatial::Vector3(0.4, -1.1, 2.0) : spatial::Vector3(0.02, -0.05, 0.08);
  const std::vector<spatial::Pose> frames = {
      spatial::Pose(spatial::exp_rotation({0.01, -0.02, 0.03}), {1e-3, -2e-3, 5e-4}),
      spatial::Pose(spatial::exp_rotation(turn), {1.5, -0.3, 0.8})};
  const Comparison c = test::compare_files(nominal, measured(truth, frames));
  ASSERT_TRUE(c.fitted) << c.refit_failure;
  const BaseFit& fit = c.fitted->fit;
  EXPECT_NEAR(factor(c, 0), 0.8, 1e-6);
  EXPECT_NEAR(factor(c, 1), 1.3, 1e-6);
  ASSERT_EQ(fit.frames.size(), 2u);
  for (std::size_t s = 0; s < 2; ++s) {
    const spatial::Vector6& found = fit.frames[s].value;
    EXPECT_LT((spatial::exp_rotation(found.tail<3>()) - frames[s].rotation()).norm(), 1e-6);
    if (GetParam())
      EXPECT_LT((found.head<3>() - frames[s].position()).norm(), 1e-8);
    else
      EXPECT_TRUE(found.head<3>().array().isNaN().all());  // cancels in differences
  }
  EXPECT_LT(fit.squared_error, 1e-6);
  EXPECT_EQ(fit.estimated, 2 + (GetParam() ? 12 : 6));
}

// Frames are placed before anything is fitted, which needs the model as well.
TEST_P(Frames, AModelThatCannotBeHasNoFit) {
  const vjm::Robot robot = test::orthoglide();
  const vjm::Manipulator& m = robot.manipulator;
  const Campaign campaign =
      read_campaign(measured(m, {spatial::Pose::translation({1.5, -0.3, 0.8})}), m);
  const std::vector<vjm::Effect> corners_in_the_wrong_order = {
      vjm::test::effect(m, "piecewise_stiffness", "x.rho", {2, 3, 100, 50})};
  const std::vector<Parameter> unknown = {effect_parameter(corners_in_the_wrong_order, 0, 0, m)};
  common::Progress silent;
  const Predictor predictor =
      Predictor(m, campaign, 1, silent).with_effects(corners_in_the_wrong_order);
  EXPECT_THROW((void)fit_base(predictor, campaign, noise_of(campaign, {}), unknown, silent),
               common::NoConvergence);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Frames, testing::Bool(), [](const auto& absolute) {
  return absolute.param ? "Absolute" : "Difference";
});

// Turns about axes in a plane are not observable in motions in that plane.
TEST(SessionFrame, CoordinatesThatNoReadingDeterminesStayAsStated) {
  vjm::Robot robot = test::bench();
  vjm::ChainBuilder chain("cell");
  chain.actuator("u", vjm::Motion::tx, 1e6).actuator("w", vjm::Motion::tz, 1e6);
  robot.manipulator = vjm::Manipulator("bench", {chain.build()});
  robot.uncertain = {{"u", {{0, "u"}}}, {"w", {{0, "w"}}}};
  constexpr double turn = 0.01, yields_x = 1.25e-6, yields_z = 0.8e-6;
  std::string csv = "u,w,fx,fz,dx,dz\n";
  for (const double x : {0.0, 0.5, 1.0})
    for (const double z : {0.0, 0.4})
      for (const double load : {-1000, 0, 1000}) {
        const double px = x + yields_x * load, pz = z - yields_z * load;
        csv += fmt::format("{},{},{},{},{},{}\n", x, z, load, -load,
                           2e-3 + std::cos(turn) * px + std::sin(turn) * pz,
                           -1e-3 - std::sin(turn) * px + std::cos(turn) * pz);
      }
  const Comparison c = test::compare_files(
      robot, test::write_campaign("kinetostat: 1\ncampaign: c\n"
                                  "units: {length: m, force: N, angle: rad}\n"
                                  "displacement: absolute\nsession_frame: estimate\n"
                                  "readings: readings.csv\nnoise: {translation: 1 um}\n",
                                  csv));
  ASSERT_TRUE(c.fitted) << c.refit_failure;
  EXPECT_NEAR(factor(c, 0), 1 / (1e6 * yields_x), 1e-6);
  EXPECT_NEAR(factor(c, 1), 1 / (1e6 * yields_z), 1e-6);
  EXPECT_EQ(c.fitted->fit.estimated, 5);
  const FrameEstimate& frame = c.fitted->fit.frames.at(0);
  EXPECT_NEAR(frame.value[0], 2e-3, 1e-9);
  EXPECT_NEAR(frame.value[2], -1e-3, 1e-9);
  EXPECT_NEAR(frame.value[4], turn, 1e-9);
  for (const int k : {1, 3, 5}) {
    EXPECT_EQ(frame.value[k], 0) << k;
    EXPECT_TRUE(std::isnan(frame.standard_error[k])) << k;
  }
}

// The derivatives of what a frame shows, against central differences.
TEST(SessionFrame, DerivativesAreExact) {
  kinetostat::test::Random random(31);
  for (const DisplacementKind kind : {DisplacementKind::absolute, DisplacementKind::difference}) {
    spatial::Vector6 frame, displacement;
    frame << random.vector(1), random.vector(1.2);
    displacement << random.vector(1), random.vector(0.9);
    const spatial::Vector6 measured =
        seen_from(frame, displacement, kind, displacement).displacement;
    const SeenFromFrame seen = seen_from(frame, displacement, kind, measured);
    for (Eigen::Index k = 0; k < 6; ++k) {
      const spatial::Vector6 step = 1e-6 * spatial::Vector6::Unit(k);
      const auto slope = [&](const spatial::Vector6& f, const spatial::Vector6& d) {
        return ((seen_from(frame + f, displacement + d, kind, measured).displacement -
                 seen_from(frame - f, displacement - d, kind, measured).displacement) /
                2e-6)
            .eval();
      };
      const spatial::Vector6 none = spatial::Vector6::Zero();
      EXPECT_LT((slope(step, none) - seen.by_frame.col(k)).norm(), 1e-8);
      EXPECT_LT((slope(none, step) - seen.by_displacement.col(k)).norm(), 1e-8);
    }
  }
}

}  // namespace
}  // namespace kinetostat::calibration::base_fit_test

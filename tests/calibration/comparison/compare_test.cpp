#include "kinetostat/calibration/comparison/compare.h"

#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/io/csv.h"
#include "kinetostat/report/comparison.h"

#include "calibration/laboratory.h"
#include "calibration/synthetic.h"

namespace kinetostat::calibration::compare_test {
namespace {

// Every figure of a comparison that must not depend on how the campaign is written down.
std::vector<double> figures(const Comparison& c) {
  std::vector<double> result;
  std::vector<const Assessment*> assessments = {&c.nominal};
  if (c.fitted) assessments.push_back(&*c.fitted);
  for (const Assessment* a : assessments) {
    result.insert(result.end(),
                  {a->fit.squared_error, a->chi_square->statistic, a->chi_square->p_value});
    if (a->lack_of_fit) result.insert(result.end(), {a->lack_of_fit->f, a->lack_of_fit->p_value});
    for (const ParameterEstimate& p : a->fit.parameters)
      result.insert(result.end(), {std::exp(p.value), p.standard_error});  // not its logarithm
    for (const ResidualStatistics& s : a->by_component)
      result.insert(result.end(), {s.rms, s.max, s.bias, s.share});
    for (const Pattern& pattern : a->patterns.factors) {
      for (const auto* test : {&pattern.bias, &pattern.size})
        if (*test) result.insert(result.end(), {(*test)->f, (*test)->holm_p_value});
      for (const PatternGroup& g : pattern.groups)
        result.insert(result.end(), {g.share, g.share_of_values, 1 + g.mean});  // in sigmas
    }
    if (const auto& reversal = a->patterns.reversal)
      result.insert(result.end(), {double(reversal->pairs), reversal->odd_share, reversal->test.f});
    for (const Loop& loop : a->patterns.loops.each)
      result.insert(result.end(), {loop.measured / *loop.noise, loop.predicted / *loop.noise,
                                   (*loop.return_to_zero).norm()});
    for (const auto* test : {&a->patterns.loops.area, &a->patterns.loops.return_to_zero})
      if (*test) result.insert(result.end(), {(*test)->statistic, (*test)->holm_p_value});
  }
  return result;
}

void expect_same_figures(const Comparison& a, const Comparison& b) {
  const std::vector<double> x = figures(a), y = figures(b);
  ASSERT_EQ(x.size(), y.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    // p-values amplify the statistic they come from; biases are differences of large numbers.
    const double scale = std::max({std::abs(x[i]), 1e-5});
    EXPECT_NEAR(x[i], y[i], 1e-10 * scale) << "figure " << i;
  }
}

// A campaign in which nothing is perfect: wrong stiffness, noise, repeated readings.
class Invariance : public testing::Test {
 protected:
  void SetUp() override {
    plan_ = test::orthoglide_plan(3, 3, 7);
    const std::size_t distinct = plan_.size();
    for (std::size_t i = 0; i < distinct; ++i) plan_.push_back(plan_[i]);
    test::measure(test::scaled(robot_, {0.8, 1.1}).manipulator, plan_);
    kinetostat::test::Random random(9);
    for (test::Planned& reading : plan_) {
      reading.displacement.head<3>() += random.vector(2e-5);
      reading.displacement.tail<3>() += random.vector(3e-5);
    }
  }
  Comparison compare(test::Writing writing, int threads = 1) const {
    writing.more = "noise: {translation: 10 um, rotation: 20 urad}\n";
    return test::compare_files(robot_, test::write(plan_, writing), threads);
  }

  vjm::Robot robot_ = test::orthoglide();
  std::vector<test::Planned> plan_;
};

TEST_F(Invariance, MillimetresOrMetresDegreesOrRadians) {
  const Comparison reference = compare({});
  expect_same_figures(reference, compare({.length = "m", .force = "kN", .angle = "rad"}));
}

TEST_F(Invariance, OrderOfTheRows) {
  const Comparison reference = compare({});
  test::Writing shuffled;
  shuffled.order.resize(plan_.size());
  std::iota(shuffled.order.begin(), shuffled.order.end(), 0);
  std::shuffle(shuffled.order.begin(), shuffled.order.end(), std::mt19937(5));
  expect_same_figures(reference, compare(shuffled));
}

// Closed cycles at the Orthoglide, forces up to `size` [N] at one point of the platform.
std::vector<test::Planned> cycles_at(const spatial::Vector3& point, double size) {
  std::vector<test::Planned> plan;
  kinetostat::test::Random random(21);
  for (int cycle = 0; cycle < 6; ++cycle) {
    const spatial::Vector3 position = random.vector(0.05), force = random.vector(size);
    const spatial::Vector3 moment = random.vector(size / 40);
    for (const double level : {0.0, 0.5, 1.0, 0.5, 0.0, -0.5, -1.0, -0.5, 0.0})
      plan.push_back({.position = position, .load = {level * force, level * moment, point}});
  }
  return plan;
}

void add_noise(std::vector<test::Planned>& plan) {
  kinetostat::test::Random random(22);
  for (test::Planned& reading : plan) {
    reading.displacement.head<3>() += random.vector(2e-5);
    reading.displacement.tail<3>() += random.vector(3e-5);
  }
}

const std::string noise = "noise: {translation: 10 um, rotation: 20 urad}\n";

// The point of the wrench in columns, in the campaign file, or as the origin of a frame.
TEST_F(Invariance, WhereThePointOfTheWrenchIsWritten) {
  plan_ = cycles_at({0.03, -0.02, 0.05}, 300);
  test::measure(test::scaled(robot_, {0.8, 1.1}).manipulator, plan_);
  add_noise(plan_);
  const auto compared = [this](bool columns, const std::string& more) {
    return test::compare_files(
        robot_, test::write(plan_, {.more = noise + more, .cycle = 9, .with_point = columns}));
  };
  const Comparison reference = compared(true, "");
  ASSERT_TRUE(reference.fitted);
  EXPECT_EQ(reference.fitted->patterns.loops.each.size(), 6u);
  EXPECT_EQ(reference.fitted->patterns.reversal->pairs, 18);
  expect_same_figures(reference, compared(false, "wrench_point: [30, -20, 50]\n"));
  expect_same_figures(reference, compared(true, "wrench_point: reference\n"));
  expect_same_figures(reference, compared(false,
                                          "frames: {cell: {on: platform, pose: {point: [30, "
                                          "-20, 50]}}}\nwrench_frame: cell\n"));
}

// A wrench that is taken about another point of the loaded platform is the same load: every figure
// of the comparison is the same, patterns and loops included. A dead moment does not turn with the
// platform, so that this is exact for the model that moves as the robot did.
TEST_F(Invariance, PointAboutWhichTheWrenchIsTaken) {
  const vjm::Manipulator truth = test::scaled(robot_, {0.8, 1.1}).manipulator;
  plan_ = cycles_at({0, 0, 0}, 100);
  test::measure(truth, plan_);
  std::vector<test::Planned> moved = plan_;
  for (test::Planned& reading : moved) {
    const spatial::Vector3 point(0.03, -0.02, 0.05);
    const spatial::Vector3 arm = spatial::exp_rotation(reading.displacement.tail<3>()) *
                                 (reading.load.point_on_platform - point);
    reading.load.moment += arm.cross(reading.load.force);
    reading.load.point_on_platform = point;
  }
  add_noise(plan_);
  add_noise(moved);
  vjm::Robot known = robot_;
  known.manipulator = truth;
  known.uncertain.clear();
  const auto compared = [&known](const std::vector<test::Planned>& plan) {
    return test::compare_files(known, test::write(plan, {.more = noise, .cycle = 9}));
  };
  const Comparison a = compared(plan_), b = compared(moved);
  EXPECT_EQ(a.nominal.patterns.reversal->pairs, 18);
  expect_same_figures(a, b);
}

TEST_F(Invariance, NumberOfThreads) {
  const std::vector<double> one = figures(compare({}, 1)), many = figures(compare({}, 5));
  EXPECT_EQ(one, many);
}

// Readings of the bench robot, k = 1e6 N/m: `runs` runs of loads 1 to 10 kN, with a deviation from
// the straight line and with Gaussian noise [mm].
struct Bench {
  int runs = 1;
  double noise = 0;
  double bend = 0;                    // of the deflection at 10 kN, relative
  std::optional<double> stated = {};  // noise in the campaign file [mm]
  unsigned seed = 1;

  std::string csv() const {
    std::mt19937 engine(seed);
    std::normal_distribution<double> scatter(0, 1);
    std::string text = "replicate,fz,dz\n";
    for (int run = 1; run <= runs; ++run)
      for (int load = 1; load <= 10; ++load)
        text += fmt::format("{},{},{}\n", run, 1000 * load,
                            load * (1 + bend * load / 10) + noise * scatter(engine));
    return text;
  }
  Comparison compare(const vjm::Robot& robot = test::bench()) const {
    std::string yaml =
        "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N}\ndisplacement: difference\n"
        "readings: readings.csv\n";
    if (stated) yaml += fmt::format("noise: {{translation: {} mm}}\n", *stated);
    return test::compare_files(robot, test::write_campaign(yaml, csv()));
  }
};

// The first trap: a noise estimated from the residual of a wrong model finds that model adequate.
// The model bends by 20 %, a hundred times the noise; whatever the noise is taken from, it must
// not be that.
TEST(Adequacy, NoiseIsNeverTakenFromTheResidual) {
  const Bench wrong{.runs = 1, .noise = 0.01, .bend = 0.2};
  const Comparison silent = wrong.compare();
  EXPECT_EQ(silent.noise.source, NoiseSource::unknown);
  for (const Assessment* a : {&silent.nominal, &*silent.fitted}) {
    EXPECT_EQ(a->adequacy, Adequacy::not_evaluated);
    EXPECT_FALSE(a->chi_square);
    EXPECT_FALSE(a->lack_of_fit);
  }
  Bench stated = wrong;
  stated.stated = 0.01;
  const Assessment against_stated = *stated.compare().fitted;
  EXPECT_GT(against_stated.chi_square->reduced(), 100);
  EXPECT_EQ(against_stated.adequacy, Adequacy::inadequate);

  Bench repeated = wrong;
  repeated.runs = 3;
  const Assessment against_replicates = *repeated.compare().fitted;
  EXPECT_GT(against_replicates.lack_of_fit->f, 100);
  EXPECT_EQ(against_replicates.adequacy, Adequacy::inadequate);
}

TEST(Adequacy, ASoundModelPassesBothTests) {
  const Comparison c = Bench{.runs = 3, .noise = 0.01, .stated = 0.01, .seed = 2}.compare();
  EXPECT_EQ(c.fitted->adequacy, Adequacy::adequate);
  EXPECT_EQ(c.fitted->chi_square->degrees_of_freedom, 29);
  EXPECT_EQ(c.fitted->lack_of_fit->degrees_of_freedom_lack, 9);
  EXPECT_EQ(c.fitted->lack_of_fit->degrees_of_freedom_pure, 20);
  EXPECT_EQ(c.nominal.lack_of_fit->degrees_of_freedom_lack, 10);
}

// The third trap: the replicates contradict the stated noise, and the report says so first.
TEST(Adequacy, AMisstatedNoiseIsNoticed) {
  const Bench misstated{.runs = 6, .noise = 0.016, .stated = 0.01};
  const Comparison c = misstated.compare();
  EXPECT_LT(c.noise_check->p_value, 1e-3);
  const auto file = test::write_campaign(
      "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N}\ndisplacement: difference\n"
      "readings: readings.csv\nnoise: {translation: 0.01 mm}\n",
      misstated.csv());
  const auto sentences = report::findings(read_campaign(file, test::bench().manipulator), c);
  EXPECT_TRUE(sentences.at(0).starts_with("Repeated readings scatter 1."));
}

TEST(Adequacy, IdenticalReplicatesAreNotANoise) {
  const Comparison c = Bench{.runs = 2, .noise = 0, .bend = 0.1}.compare();
  EXPECT_EQ(c.fitted->adequacy, Adequacy::not_evaluated);
}

// Over many campaigns of a sound model the verdicts are wrong as often as they say. Bounds are
// four binomial standard deviations.
TEST(Adequacy, VerdictsAreWrongAsOftenAsTheySay) {
  constexpr int campaigns = 400;
  int chi_square_inside = 0, lack_of_fit_inside = 0, false_alarms = 0, covered = 0;
  for (int i = 0; i < campaigns; ++i) {
    const Comparison c =
        Bench{.runs = 2, .noise = 0.01, .stated = 0.01, .seed = 100u + static_cast<unsigned>(i)}
            .compare(test::bench(1.1e6));
    const Assessment& a = *c.fitted;
    chi_square_inside += a.chi_square->p_value > 0.025 && a.chi_square->lower_p_value > 0.025;
    lack_of_fit_inside += a.lack_of_fit->p_value > 0.05;
    false_alarms += a.adequacy == Adequacy::inadequate;
    const ParameterEstimate& p = a.fit.parameters[0];
    const double error = p.value - std::log(1 / 1.1);
    covered += std::abs(error) < 1.959964 * p.standard_error;
  }
  const double bound = 4 * std::sqrt(campaigns * 0.05 * 0.95);
  EXPECT_NEAR(chi_square_inside, 0.95 * campaigns, bound);
  EXPECT_NEAR(lack_of_fit_inside, 0.95 * campaigns, bound);
  EXPECT_NEAR(covered, 0.95 * campaigns, bound);
  EXPECT_LT(false_alarms, 0.05 * campaigns + bound);
}

TEST(Statistics, AreThoseOfTheResiduals) {
  const auto file = test::write_campaign(
      "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N}\ndisplacement: difference\n"
      "readings: readings.csv\nnoise: {translation: 0.1 mm}\ndatum_noise: {translation: 0 mm}\n",
      "id,session,fz,dz,mask,mask_reason\n"
      "a,s,1000,1.3,,\nb,s,2000,2.1,,\nc,t,3000,2.6,,\nd,t,3000,99,1,slipped\n");
  vjm::Robot robot = test::bench();
  robot.uncertain.clear();
  const Assessment a = test::compare_files(robot, file).nominal;
  // Residuals 0.3, 0.1, -0.4 mm.
  ASSERT_EQ(a.by_component.size(), 1u);
  const ResidualStatistics& s = a.by_component[0];
  EXPECT_EQ(s.component, 2);
  EXPECT_EQ(s.count, 3);
  EXPECT_NEAR(s.rms, 1e-3 * std::sqrt(0.26 / 3), 1e-12);
  EXPECT_NEAR(s.max, 0.4e-3, 1e-12);
  EXPECT_EQ(s.worst_reading, 2u);
  EXPECT_NEAR(s.bias, 0, 1e-12);
  EXPECT_NEAR(s.share, 1, 1e-12);
  ASSERT_EQ(a.by_session.size(), 2u);
  EXPECT_NEAR(a.by_session[0].bias, 0.2e-3, 1e-12);
  EXPECT_NEAR(a.by_session[1].share, 0.16 / 0.26, 1e-9);
  EXPECT_NEAR(a.chi_square->statistic, 26, 1e-9);
  EXPECT_EQ(a.chi_square->degrees_of_freedom, 3);
  EXPECT_NEAR(a.residual[3][2], 96e-3, 1e-12);  // masked readings are shown, not counted
}

// Two springs in series that act in nearly one direction: the readings know their sum, and put one
// of them at its bound, which says nothing of the other.
TEST(Compare, ASpringAtItsBoundLeavesTheOtherUnsure) {
  int beyond = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    test::Laboratory laboratory(
        "kinetostat: 1\nname: slides\nunits: {length: mm, force: N, angle: deg}\nchain_types:\n"
        "  arm:\n    - actuator: {name: a, axis: Tz, stiffness: 1000}\n"
        "    - offset: {rpy: [0.3, 0, 0]}\n"
        "    - actuator: {name: b, axis: Tz, stiffness: 4000}\nmanipulator: {chain: arm}\n"
        "uncertain:\n  - {stiffness: a, between: [0.3, 3]}\n"
        "  - {stiffness: b, between: [0.3, 3]}\n");
    laboratory.options().translation_noise = 2e-6;
    laboratory.options().seed = seed;
    const Campaign campaign =
        laboratory.measure("id,fz\na,300\nb,600\nc,-300\nd,-600\ne,450\nf,-450\n");
    common::Progress silent;
    const Comparison both = compare(laboratory.robot(), campaign, 1, silent);
    ASSERT_TRUE(both.fitted) << both.refit_failure;
    for (const ParameterEstimate& e : both.fitted->fit.parameters)
      beyond += std::abs(e.value) > 3 * e.standard_error ? 1 : 0;
  }
  EXPECT_EQ(beyond, 0);  // the truth is what the file says: the logarithm of 1
}

TEST(ResidualTable, HasOneRowPerReadingInTheUnitsOfTheCampaign) {
  const auto file = test::write_campaign(
      "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N}\ndisplacement: difference\n"
      "readings: readings.csv\n",
      "id,fz,dz,mask,mask_reason\n\"a,b\",1000,1.25,,\nc,2000,,1,\"fell, off\"\n");
  vjm::Robot robot = test::bench();
  robot.uncertain.clear();
  common::Progress silent;
  const Campaign campaign = read_campaign(file, robot.manipulator);
  const io::CsvTable table(report::residual_table(campaign, compare(robot, campaign, 1, silent)),
                           "residuals.csv");
  ASSERT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.cell(0, *table.find("id")), "a,b");
  EXPECT_DOUBLE_EQ(table.number(0, *table.find("dz")), 1.25);
  EXPECT_NEAR(table.number(0, *table.find("predicted_dz_designed")), 1, 1e-10);
  EXPECT_NEAR(table.number(0, *table.find("residual_dz_designed")), 0.25, 1e-10);
  EXPECT_EQ(table.cell(1, *table.find("mask_reason")), "fell, off");
  EXPECT_TRUE(table.empty(1, *table.find("dz")));
}

}  // namespace
}  // namespace kinetostat::calibration::compare_test

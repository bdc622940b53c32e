// The error of the unloaded reading that differences are counted from.
#include "kinetostat/calibration/campaign/datum.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/campaign/pure_error.h"
#include "kinetostat/calibration/comparison/compare.h"
#include "kinetostat/common/error.h"

#include "calibration/laboratory.h"
#include "calibration/random_matrix.h"
#include "calibration/synthetic.h"

namespace kinetostat::calibration::datum_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Vector6;
using test::random_matrix;

constexpr std::size_t cycles = 3, length = 4;

// Differences in x and z, with noise that differs between readings and components.
Campaign differences() {
  Campaign campaign;
  campaign.sessions = {"monday"};
  campaign.configurations.resize(1);
  campaign.noise_stated = true;
  for (std::size_t i = 0; i < cycles * length; ++i) {
    Reading reading;
    reading.id = fmt::format("r{:02}", i);
    reading.cycle = std::to_string(i / length);
    reading.step = static_cast<double>(i % length);
    reading.load.force.z() = 100.0 * static_cast<double>(i % length);
    reading.displacement.setConstant(std::nan(""));
    reading.displacement[0] = 1e-6;
    if (i != 5) reading.displacement[2] = 2e-6;
    reading.sigma = Vector6::Constant(1e-6 * (1 + static_cast<double>(i % 3)));
    reading.sigma[2] *= 2;
    campaign.readings.push_back(reading);
  }
  return campaign;
}

// Of the numbers themselves: each reading's own noise, and that of the datum that they share.
MatrixXd covariance_of(const Campaign& campaign, const Noise& noise,
                       const std::vector<Value>& values) {
  const auto n = static_cast<Index>(values.size());
  MatrixXd c = MatrixXd::Zero(n, n);
  for (Index a = 0; a < n; ++a)
    for (Index b = 0; b < n; ++b) {
      const Value &v = values[static_cast<std::size_t>(a)],
                  &w = values[static_cast<std::size_t>(b)];
      const double own = noise.sigma[v.reading][v.component] * noise.sigma[w.reading][w.component];
      if (v.reading == w.reading)
        c(a, b) += noise.correlation.empty()
                       ? (v.component == w.component ? own : 0)
                       : own * (*noise.correlation[v.reading])(v.component, w.component);
      if (campaign.readings[v.reading].cycle == campaign.readings[w.reading].cycle &&
          v.component == w.component)
        c(a, b) += std::pow(campaign.datum_noise[v.component], 2);
    }
  return c;
}

MatrixXd whitened(const Noise& noise, const std::vector<Value>& values, MatrixXd rows) {
  for (std::size_t first = 0, next = 0; first < values.size(); first = next) {
    std::vector<Index> used;
    for (next = first; next < values.size() && values[next].reading == values[first].reading;)
      used.push_back(values[next++].component);
    noise.whiten(values[first].reading, used,
                 rows.middleRows(static_cast<Index>(first), static_cast<Index>(used.size())));
  }
  SharedNoise(noise, values).whiten(rows);
  return rows;
}

TEST(Datum, ItsNoiseIsWhitenedWithThatOfTheReadings) {
  Campaign campaign = differences();
  campaign.datum_noise.head<3>() << 3e-6, 1e-6, 2e-6;
  const std::vector<Value> values = values_in_use(campaign);
  Noise noise = noise_of(campaign, {});
  ASSERT_EQ(noise.datums.size(), cycles);
  for (const bool correlated : {false, true}) {
    if (correlated) {
      spatial::Matrix6 correlation = spatial::Matrix6::Identity();
      correlation(0, 2) = correlation(2, 0) = 0.6;
      noise.correlation.assign(campaign.readings.size(),
                               std::make_shared<const Eigen::MatrixXd>(correlation));
    }
    const MatrixXd half = whitened(noise, values, covariance_of(campaign, noise, values));
    const MatrixXd whole = whitened(noise, values, half.transpose());
    EXPECT_LT((whole - MatrixXd::Identity(whole.rows(), whole.cols())).cwiseAbs().maxCoeff(),
              1e-12);
    const SharedNoise shared(noise, values);
    const MatrixXd before = random_matrix(static_cast<Index>(values.size()), 2, 1);
    MatrixXd after = before;
    shared.whiten(after);
    EXPECT_GT((after - before).norm(), 0.1);
    shared.restore(after);
    EXPECT_LT((after - before).cwiseAbs().maxCoeff(), 1e-12);
    MatrixXd root = MatrixXd::Identity(whole.rows(), whole.cols());
    shared.restore(root);
    EXPECT_LT((shared.deviations(root.rows()) - root.rowwise().norm()).cwiseAbs().maxCoeff(),
              1e-12);
  }
}

TEST(Datum, HasHalfOfTheBestReadingsVarianceWhereNothingIsStated) {
  const Campaign campaign = differences();
  for (const Datum& datum : datums_of(campaign, noise_of(campaign, {}).sigma)) {
    EXPECT_DOUBLE_EQ(std::pow(datum.sigma[0], 2), 0.5 * 1e-12);
    EXPECT_DOUBLE_EQ(std::pow(datum.sigma[2], 2), 0.5 * 4e-12);
  }
}

TEST(Datum, IsSharedOnlyByReadingsThatAreCountedFromIt) {
  Campaign campaign = differences();
  const auto count = [&] { return noise_of(campaign, {}).datums.size(); };
  campaign.readings[0].displacement.setZero();  // without load: the datum itself
  EXPECT_EQ(noise_of(campaign, {}).datums[0].readings, (std::vector<std::size_t>{1, 2, 3}));
  for (const std::size_t i : {5, 6, 7}) campaign.readings[i].masked = true;
  EXPECT_EQ(count(), cycles - 1);
  for (Reading& reading : campaign.readings) reading.cycle.clear();
  EXPECT_EQ(count(), 1u);
  campaign.zero = ZeroReading::estimated;
  EXPECT_EQ(count(), 0u);
  campaign.zero = ZeroReading::known;
  campaign.displacement = DisplacementKind::absolute;
  EXPECT_EQ(count(), 0u);
}

// The scatter about group means, by generalised least squares with the whole covariance.
// One load in each posture: what is stated of the unloaded reading counts, what is usual is part of
// the reading's own noise.
TEST(Datum, CountsForOneReadingWhereItIsStated) {
  Campaign campaign = differences();
  for (std::size_t i = 0; i < campaign.readings.size(); ++i)
    campaign.readings[i].cycle = std::to_string(i);
  EXPECT_TRUE(noise_of(campaign, {}).datums.empty());
  campaign.datum_noise.setConstant(7e-6);
  const Noise noise = noise_of(campaign, {});
  ASSERT_EQ(noise.datums.size(), campaign.readings.size());
  EXPECT_DOUBLE_EQ(noise.datums[0].sigma[0], 7e-6);
  const std::vector<Value> values = {{3, 0}, {3, 2}};
  const SharedNoise shared(noise, values);
  MatrixXd rows = MatrixXd::Identity(2, 2);
  shared.restore(rows);
  const Vector6& own = campaign.readings[3].sigma;
  for (const int k : {0, 1}) EXPECT_NEAR(rows(k, k), std::hypot(1, 7e-6 / own[2 * k]), 1e-12);
}

TEST(Datum, IsNoScatterOfRepeatedReadings) {
  Campaign campaign = differences();
  campaign.datum_noise.setConstant(3e-6);
  const std::vector<Value> values = values_in_use(campaign);
  const Noise noise = noise_of(campaign, {});
  std::vector<ReplicateGroup> groups;
  for (const Index component : {0, 2})
    for (std::size_t step = 0; step < length; ++step) {
      ReplicateGroup& group = groups.emplace_back(ReplicateGroup{component, {}});
      for (std::size_t i = step; i < campaign.readings.size(); i += length)
        if (campaign.readings[i].uses(component)) group.readings.push_back(i);
    }
  const auto n = static_cast<Index>(values.size());
  const VectorXd y = 1e-6 * random_matrix(n, 1, 7);
  MatrixXd means = MatrixXd::Zero(n, static_cast<Index>(groups.size()));
  for (Index v = 0; v < n; ++v) {
    const auto [reading, component] = values[static_cast<std::size_t>(v)];
    campaign.readings[reading].displacement[component] = y[v];
    means(v, (component == 0 ? 0 : Index{length}) + static_cast<Index>(reading % length)) = 1;
  }
  const Eigen::LLT<MatrixXd> factor(covariance_of(campaign, noise, values));
  const MatrixXd x = factor.matrixL().solve(means);
  const VectorXd r = factor.matrixL().solve(y);
  const double expected =
      (r - x * (x.transpose() * x).llt().solve(x.transpose() * r)).squaredNorm();
  const PureError scatter = pure_error(campaign, groups, noise);
  EXPECT_NEAR(scatter.sum, expected, 1e-9 * expected);
  EXPECT_EQ(scatter.degrees_of_freedom, n - std::ssize(groups));
}

// Where no unloaded reading is, or the others' noise is not known, it has no noise to state.
TEST(Datum, IsRefusedWhereItMeansNothing) {
  const auto read = [](const std::string& more) {
    return read_campaign(
        test::write_campaign("kinetostat: 1\ncampaign: c\nunits: {length: mm, force: "
                             "N}\nreadings: readings.csv\n" +
                                 more,
                             "fz,dz\n1000,1\n2000,2\n"),
        test::bench().manipulator);
  };
  const std::string difference = "displacement: difference\n",
                    noise = "noise: {translation: 2 um}\n",
                    stated = "datum_noise: {translation: 3 um}\n";
  EXPECT_EQ(read(difference + noise + stated).datum_noise[2], 3e-6);
  EXPECT_EQ(read(difference + "datum_noise: {translation: 0 um}\n").datum_noise[2], 0);
  for (const std::string& bad :
       {difference + stated, difference + noise + stated + "zero: estimate\n",
        "displacement: absolute\n" + noise + stated,
        difference + noise + "datum_noise: {translation: -3 um}\n",
        difference + noise + "datum_noise: {translation: 3}\n"})
    EXPECT_THROW((void)read(bad), common::InputError) << bad;
  const std::string poses = "displacement: absolute\n",
                    stops = "repeatability: {translation: 3 um}\n";
  EXPECT_EQ(read(poses + noise + stops).datum_noise[2], 3e-6);
  for (const std::string& bad :
       {poses + stops, difference + noise + stops, poses + noise + "repeatability: 3 um\n",
        poses + noise + "repeatability: {translation: -3 um}\n",
        poses + noise + "repeatability: {translation: 3}\n"})
    EXPECT_THROW((void)read(bad), common::InputError) << bad;
}

// Those that follow each other in one posture share where the drives stopped, read again or not.
TEST(Datum, OfPosesIsWhereTheDrivesStopped) {
  Campaign campaign;
  campaign.displacement = DisplacementKind::absolute;
  campaign.sessions = {"monday"};
  for (const std::size_t configuration : {0, 0, 1, 0, 0, 2, 2}) {
    Reading& reading = campaign.readings.emplace_back();
    reading.configuration = configuration;
    reading.displacement.setZero();
  }
  campaign.readings[6].cycle = "next";
  campaign.readings[1].masked = true;
  EXPECT_EQ(approaches_of(campaign), (std::vector<std::size_t>{1, 1, 2, 3, 3, 4, 0}));
  // A table that is sorted by load.
  Campaign sorted = campaign;
  for (std::size_t i = 0; i < sorted.readings.size(); ++i) {
    sorted.readings[i].cycle = "one";
    sorted.readings[i].configuration = i % 2;
    sorted.readings[i].step = i % 2 * 10.0 + i;
  }
  EXPECT_EQ(approaches_of(sorted), (std::vector<std::size_t>{0, 1, 0, 1, 0, 1, 0}));
  const std::vector<Eigen::VectorXd> sigma(7, Eigen::VectorXd::Constant(6, 1e-6));
  EXPECT_TRUE(datums_of(campaign, sigma).empty());
  campaign.datum_noise.head<3>().setConstant(5e-6);
  const std::vector<Datum> stops = datums_of(campaign, sigma);
  ASSERT_EQ(stops.size(), 5u);
  EXPECT_EQ(stops[1].readings, std::vector<std::size_t>{0});
  EXPECT_EQ(stops[3].readings, (std::vector<std::size_t>{3, 4}));
  EXPECT_TRUE((stops[3].sigma.head<3>().array() == 5e-6).all());
  EXPECT_TRUE(stops[3].sigma.tail<3>().isZero(0));
}

const std::string slide =
    "kinetostat: 1\nname: slide\nunits: {length: mm, force: N, angle: deg}\nchain_types:\n  cell:\n"
    "    - actuator: {name: q, axis: Tz, stiffness: 1000}\n"
    "manipulator: {chain: cell}\nuncertain:\n  - {stiffness: q}\n";

// Load cycles of the slide, nothing hidden, each counted from an unloaded reading as noisy as half
// of one of the others; `share`: of the variance, as the campaign has it.
Comparison compared(std::uint64_t seed, double share) {
  test::Laboratory laboratory(slide);
  laboratory.options().seed = 1000 * seed;
  std::string plan = "id,cycle,step,fz\n";
  for (int i = 0; i < 60; ++i)
    plan += fmt::format("a{0},{1},{2},{3}\n", i, i / 10, i % 10,
                        (i / 10 % 2 == 0 ? 90 : -90) * (1 + i % 10));
  constexpr double noise = 2e-6;
  laboratory.options().translation_noise = noise;
  Campaign campaign = laboratory.measure(plan);
  campaign.datum_noise.setConstant(std::sqrt(share) * noise);
  const VectorXd datums = std::sqrt(0.5) * random_matrix(6, 1, seed);
  for (std::size_t i = 0; i < campaign.readings.size(); ++i)
    campaign.readings[i].displacement[2] -= noise * datums[static_cast<Index>(i / 10)];
  common::Progress silent;
  return compare(laboratory.robot(), campaign, 1, silent);
}

// p-values of the fit, and its standard errors, are those of noise.
TEST(Datum, MakesTestsOfSoundReadingsHonest) {
  constexpr int campaigns = 60;
  int refuted = 0, refuted_as_independent = 0;
  double squares = 0, squares_as_independent = 0;
  for (int seed = 1; seed <= campaigns; ++seed) {
    const Comparison with = compared(static_cast<std::uint64_t>(seed), 0.5);
    const Comparison without = compared(static_cast<std::uint64_t>(seed), 0);
    ASSERT_TRUE(with.fitted && without.fitted);
    refuted += with.fitted->chi_square->p_value < 0.05 ? 1 : 0;
    refuted_as_independent += without.fitted->chi_square->p_value < 0.05 ? 1 : 0;
    const auto normalised = [](const Comparison& c) {
      const ParameterEstimate& k = c.fitted->fit.parameters.at(0);
      return k.value / k.standard_error;
    };
    squares += std::pow(normalised(with), 2) / campaigns;
    squares_as_independent += std::pow(normalised(without), 2) / campaigns;
  }
  EXPECT_LE(refuted, 8);  // 3 expected; 99 % of 60 with 5 % each
  EXPECT_GT(refuted_as_independent, 12);
  EXPECT_LT(squares, 1.5);
  EXPECT_GT(squares_as_independent, 2);
}

}  // namespace
}  // namespace kinetostat::calibration::datum_test

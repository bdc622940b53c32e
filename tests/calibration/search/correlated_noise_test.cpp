// Noise that readings share is neither independent noise nor an effect.
#include "kinetostat/calibration/search/correlated_noise.h"

#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/laboratory.h"
#include "calibration/random_matrix.h"

namespace kinetostat::calibration::correlated_noise_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::Laboratory;
using test::random_matrix;
using testing::HasSubstr;

constexpr Index cycles = 5, length = 8, count = cycles * length;

// Differences in z, a reading every minute, cycle after cycle.
Campaign differences() {
  Campaign campaign;
  campaign.displacement = DisplacementKind::difference;
  campaign.sessions = {"monday"};
  for (Index i = 0; i < count; ++i) {
    Reading reading;
    reading.id = fmt::format("r{:02}", i);
    reading.cycle = std::to_string(i / length);
    reading.step = static_cast<double>(i % length);
    reading.time = 60.0 * static_cast<double>(i);
    reading.displacement.setConstant(std::nan(""));
    reading.displacement[2] = 0;
    campaign.readings.push_back(reading);
  }
  return campaign;
}

// The first half of each cycle is twice as noisy.
Noise noise_of_each() {
  Noise noise;
  for (Index i = 0; i < count; ++i)
    noise.sigma.push_back(spatial::Vector6::Constant(i % length < length / 2 ? 2e-6 : 1e-6));
  return noise;
}

CorrelatedNoise ways() {
  const Campaign campaign = differences();
  return {campaign, values_in_use(campaign), noise_of_each()};
}

// Of whitened values; the ways in the order in which they are tried.
MatrixXd covariance(std::size_t way) {
  const Noise noise = noise_of_each();
  const auto sigma = [&](Index i) { return noise.sigma[static_cast<std::size_t>(i)][2]; };
  MatrixXd c = MatrixXd::Identity(count, count);
  for (Index i = 0; i < count; ++i)
    for (Index j = 0; j < count; ++j) {
      if (way > 0)
        c(i, j) = std::pow(std::vector{0.3, 0.6, 0.85}.at(way - 1), std::abs(i - j));
      else if (i / length == j / length)  // the zero is as good as the best reading
        c(i, j) += 1e-12 / (sigma(i) * sigma(j));
    }
  return c;
}

MatrixXd something_fitted() {
  MatrixXd x(count, 3);
  for (Index i = 0; i < count; ++i)
    x.row(i) << 1, std::sin(0.7 * static_cast<double>(i)), i % length < length / 2 ? 1 : -1;
  return x;
}

BaseFit fit_of(const VectorXd& y) {
  BaseFit fit;
  const MatrixXd x = something_fitted();
  fit.at = {x * x.householderQr().solve(y) - y, x};
  return fit;
}

TEST(CorrelatedNoise, ItsRootMakesItIndependent) {
  const CorrelatedNoise noise = ways();
  ASSERT_EQ(noise.size(), 4u);
  for (std::size_t way = 0; way < noise.size(); ++way) {
    const MatrixXd half = noise.decorrelated(way, covariance(way));
    const MatrixXd whole = noise.decorrelated(way, half.transpose());
    EXPECT_LT((whole - MatrixXd::Identity(count, count)).cwiseAbs().maxCoeff(), 1e-12) << way;
  }
}

// The density of what the fit cannot produce, computed where that is, on an orthonormal basis, and
// integrated over the scale of the noise, whose logarithm may be anything.
TEST(CorrelatedNoise, EvidenceIsTheRestrictedLikelihood) {
  const CorrelatedNoise noise = ways();
  const MatrixXd x = something_fitted();
  const MatrixXd q = x.householderQr().householderQ() * MatrixXd::Identity(count, count);
  const MatrixXd rest = q.rightCols(count - x.cols());
  const VectorXd y = 1.5 * random_matrix(count, 1, 3);
  const VectorXd left = rest.transpose() * y;
  for (std::size_t way = 0; way < noise.size(); ++way) {
    const Eigen::LLT<MatrixXd> factor(rest.transpose() * covariance(way) * rest);
    const double log_root = MatrixXd(factor.matrixL()).diagonal().array().log().sum();
    const auto freedom = static_cast<double>(left.size());
    const double expected =
        -log_root - freedom / 2 * std::log(left.dot(factor.solve(left)) / left.squaredNorm());
    EXPECT_NEAR(noise.log_evidences(fit_of(y))[way], expected, 1e-9) << way;
    EXPECT_NEAR(noise.log_evidences(fit_of(0.3 * y))[way], expected, 1e-9) << way;
  }
}

// It would move with the residual if it could: noise that is not independent would seem more
// probable beside an effect of no size at all.
TEST(CorrelatedNoise, WhatABoundHoldsExplainsNothing) {
  const CorrelatedNoise noise = ways();
  const VectorXd y = 3 * random_matrix(count, 1, 8);
  const BaseFit plain = fit_of(y);
  BaseFit held = plain;
  held.at.jacobian = MatrixXd(count, plain.at.jacobian.cols() + 1);
  held.at.jacobian << y + 0.1 * random_matrix(count, 1, 9), plain.at.jacobian;
  held.parameters.resize(1);
  EXPECT_GT((VectorXd::Map(noise.log_evidences(held).data(), 3) -
             VectorXd::Map(noise.log_evidences(plain).data(), 3))
                .norm(),
            0.1);
  held.parameters[0].hit = BoundHit::lower;
  for (std::size_t way = 0; way < noise.size(); ++way)
    EXPECT_NEAR(noise.log_evidences(held)[way], noise.log_evidences(plain)[way], 1e-9) << way;
}

TEST(CorrelatedNoise, PrevailsWhereItIsThereAndNotElsewhere) {
  const CorrelatedNoise noise = ways();
  int wrong = 0, seen = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const VectorXd independent = random_matrix(count, 1, 100 * seed);
    const BaseFit plain = fit_of(independent);
    wrong += noise.prevailing(plain) ? 1 : 0;
    EXPECT_LT(noise.gain(plain), 3) << seed;
    const MatrixXd root = covariance(3).llt().matrixL();
    const auto way = noise.prevailing(fit_of(root * independent));
    seen += way && noise.what(*way).starts_with("the error of a reading") ? 1 : 0;
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GE(seen, 38);
}

// Poses that are approached one after the other, and each read a few times.
Campaign poses() {
  Campaign campaign = differences();
  campaign.displacement = DisplacementKind::absolute;
  for (Index i = 0; i < count; ++i)
    campaign.readings[static_cast<std::size_t>(i)].configuration = static_cast<std::size_t>(i / 4);
  return campaign;
}

// The first readings of a cycle, and the last, are of one approach each.
MatrixXd covariance_of_approaches(double times) {
  const Noise noise = noise_of_each();
  const auto sigma = [&](Index i) { return noise.sigma[static_cast<std::size_t>(i)][2]; };
  MatrixXd c = MatrixXd::Identity(count, count);
  for (Index i = 0; i < count; ++i)
    for (Index j = 0; j < count; ++j)
      if (i / 4 == j / 4) {
        const double stop = times * (i % length < length / 2 ? 2e-6 : 1e-6);
        c(i, j) += stop * stop / (sigma(i) * sigma(j));
      }
  return c;
}

TEST(CorrelatedNoise, OfApproachesIsMadeIndependent) {
  const Campaign campaign = poses();
  const CorrelatedNoise noise(campaign, values_in_use(campaign), noise_of_each());
  ASSERT_EQ(noise.size(), 7u);
  std::size_t way = 0;
  for (const double times : {0.5, 1.0, 2.0, 4.0}) {
    const MatrixXd half = noise.decorrelated(way, covariance_of_approaches(times));
    const MatrixXd whole = noise.decorrelated(way, half.transpose());
    EXPECT_LT((whole - MatrixXd::Identity(count, count)).cwiseAbs().maxCoeff(), 1e-12) << times;
    EXPECT_THAT(noise.what(way++), HasSubstr("one approach to a posture"));
  }
}

TEST(CorrelatedNoise, OfApproachesPrevailsWhereItIsThere) {
  const Campaign campaign = poses();
  const CorrelatedNoise noise(campaign, values_in_use(campaign), noise_of_each());
  int wrong = 0, seen = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const VectorXd independent = random_matrix(count, 1, 100 * seed);
    wrong += noise.prevailing(fit_of(independent)) ? 1 : 0;
    const MatrixXd root = covariance_of_approaches(3).llt().matrixL();
    const auto way = noise.prevailing(fit_of(root * independent));
    seen += way && noise.what(*way).starts_with("readings of one approach") ? 1 : 0;
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GE(seen, 30);  // ten approaches are few
}

// Poses have no zero, those that are read once share no stop of the drives, and readings of unknown
// time have no order.
TEST(CorrelatedNoise, IsOnlySoughtWhereItCanBe) {
  Campaign campaign = poses();
  for (Index i = 0; i < count; ++i)
    campaign.readings[static_cast<std::size_t>(i)].configuration = static_cast<std::size_t>(i);
  EXPECT_EQ(CorrelatedNoise(campaign, values_in_use(campaign), noise_of_each()).size(), 3u);
  campaign.readings[7].time.reset();
  const CorrelatedNoise none(campaign, values_in_use(campaign), noise_of_each());
  EXPECT_EQ(none.size(), 0u);
  EXPECT_EQ(none.gain(fit_of(random_matrix(count, 1, 1))), 0);
  EXPECT_FALSE(none.prevailing(fit_of(random_matrix(count, 1, 1))));
}

const std::string slide =
    "kinetostat: 1\nname: slide\nunits: {length: mm, force: N, angle: deg}\nchain_types:\n  cell:\n"
    "    - actuator: {name: q, axis: Tz, stiffness: 1000}\n"
    "manipulator: {chain: cell}\nuncertain:\n  - {stiffness: q}\n";

// Load cycles that are each counted from a reading of the unloaded slide, as noisy as the others.
Campaign from_noisy_zeros(Laboratory& laboratory, std::uint64_t seed) {
  std::string plan = "id,cycle,step,time,fz\n";
  int n = 0, time = 0;
  for (int run = 1; run <= 12; ++run)
    for (const int load : {300, 600, 900, 600, 300, 0, -300, -600, -900, -600, -300, 0}) {
      time += 30 + 7 * n % 11;
      plan += fmt::format("a{0},{1},{0},{2},{3}\n", ++n, run, time, load);
    }
  constexpr double noise = 2e-6;
  laboratory.options().translation_noise = noise;
  Campaign campaign = laboratory.measure(plan);
  const VectorXd zeros = random_matrix(12, 1, seed);
  for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
    campaign.readings[i].displacement[2] -= noise * zeros[static_cast<Index>(i / 12)];
    campaign.readings[i].sigma[2] *= std::numbers::sqrt2;
  }
  return campaign;
}

const std::vector<std::string> kinds = {
    "friction", "creep",         "hardening",           "clearance",        "preload",
    "payload",  "session_drift", "piecewise_stiffness", "thermal_expansion"};

const std::string arm =
    "kinetostat: 1\nname: arm\nunits: {length: mm, force: N, angle: deg}\nchain_types:\n  arm:\n"
    "    - offset: [0, 0, 400]\n"
    "    - actuator: {name: q1, axis: Ry, stiffness: 2e5 N m/rad}\n"
    "    - offset: [600, 0, 0]\n"
    "    - actuator: {name: q2, axis: Ry, stiffness: 1e5 N m/rad}\n"
    "    - offset: [500, 0, 0]\n"
    "manipulator: {chain: arm}\nuncertain:\n  - {stiffness: q1}\n  - {stiffness: q2}\n";

// Poses under three loads each, where the drives have stopped a little elsewhere each time.
Campaign of_drives_that_stop_elsewhere(Laboratory& laboratory, std::uint64_t seed) {
  std::string plan = "id,cycle,step,time,q1,q2,fx,fz\n";
  int n = 0;
  for (int posture = 1; posture <= 40; ++posture)
    for (const int load : {0, 400, -400}) {
      ++n;
      plan += fmt::format("a{0},{1},{0},{2},{3},{4},{5},{6}\n", n, posture, 40 * n,
                          posture * 37 % 91 - 45, posture * 53 % 101 - 20, load / 2, load);
    }
  constexpr double noise = 5e-6;
  laboratory.options().translation_noise = noise;
  laboratory.options().displacement = DisplacementKind::absolute;
  laboratory.options().components = {true, true, true, false, false, false};
  Campaign campaign = laboratory.measure(plan);
  const MatrixXd stops = random_matrix(40, 3, seed);
  for (std::size_t i = 0; i < campaign.readings.size(); ++i)
    for (Index k = 0; k < 3; ++k)
      campaign.readings[i].displacement[k] += 2 * noise * stops(static_cast<Index>(i / 3), k);
  return campaign;
}

TEST(Verdict, WhereDrivesStopIsNoEffect) {
  for (const std::uint64_t seed : {11, 22, 33}) {
    Laboratory laboratory(arm);
    Campaign campaign = of_drives_that_stop_elsewhere(laboratory, seed);
    const Diagnosis d = laboratory.diagnose(campaign, {});
    EXPECT_EQ(d.verdict, Verdict::none_needed) << seed;
    EXPECT_THAT(d.correlated_noise, HasSubstr("readings of one approach to a posture")) << seed;
    EXPECT_TRUE(d.shares_noise()) << seed;
    EXPECT_GT(d.after->reduced(), 3) << seed;
    campaign.datum_noise.head<3>().setConstant(1e-5);
    const Diagnosis stated = laboratory.diagnose(campaign, {});
    EXPECT_EQ(stated.verdict, Verdict::none_needed) << seed;
    EXPECT_EQ(stated.correlated_noise, "") << seed;
    EXPECT_NEAR(stated.after->reduced(), 1, 0.25) << seed;
    EXPECT_EQ(stated.set_aside.size() + stated.far_values, 0u) << seed;
  }
}

TEST(Verdict, DatumsThatCyclesShareAreNoEffect) {
  for (const std::uint64_t seed : {11, 22, 33}) {
    Laboratory laboratory(slide);
    const Campaign campaign = from_noisy_zeros(laboratory, seed);
    const Diagnosis d = laboratory.diagnose(campaign, kinds);
    EXPECT_EQ(d.verdict, Verdict::none_needed) << seed;
    EXPECT_THAT(d.correlated_noise, HasSubstr("readings of one cycle are off together")) << seed;
    EXPECT_THAT(report::text(laboratory.robot(), campaign, d),
                HasSubstr("The noise is not independent"));
  }
}

// Errors that last, in three long load cycles.
Campaign with_lasting_errors(Laboratory& laboratory, std::uint64_t seed) {
  std::string plan = "id,cycle,step,time,fz\n";
  int n = 0, time = 0;
  for (int run = 1; run <= 3; ++run)
    for (int k = 0; k < 40; ++k) {
      time += 30;
      plan += fmt::format("a{0},{1},{0},{2},{3}\n", ++n, run, time, k < 20 ? 300 : 900);
    }
  constexpr double noise = 2e-6, lasting = 0.6;
  laboratory.options().translation_noise = 1e-9;
  Campaign campaign = laboratory.measure(plan);
  const VectorXd fresh = random_matrix(n, 1, seed);
  double error = fresh[0];
  for (Index i = 0; i < n; ++i) {
    Reading& reading = campaign.readings[static_cast<std::size_t>(i)];
    if (i > 0) error = lasting * error + std::sqrt(1 - lasting * lasting) * fresh[i];
    reading.displacement[2] += noise * error;
    reading.sigma[2] = noise;
  }
  return campaign;
}

// What is left of a creep beside a drift is no lasting noise that would speak for the drift.
TEST(Verdict, LastingErrorsGiveTheWrongEffectNoName) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Laboratory laboratory(slide);
    laboratory.hide("creep", "q", "c=3e-8 m/N,tau=300 s");
    const Diagnosis d = laboratory.diagnose(with_lasting_errors(laboratory, seed),
                                            {"session_drift", "hardening", "clearance"});
    ASSERT_EQ(d.found.size(), 1u) << seed;
    EXPECT_EQ(d.found[0].candidate.effect.kind->name, "session_drift") << seed;
    EXPECT_THAT(d.correlated_noise, HasSubstr("the one before it")) << seed;
    EXPECT_EQ(d.verdict, Verdict::unexplained) << seed;
  }
}

TEST(Verdict, AnEffectIsFoundBesideDatumsThatCyclesShare) {
  Laboratory laboratory(slide);
  laboratory.hide("friction", "q", "force=10 N,presliding=2 um");
  const Diagnosis d = laboratory.diagnose(from_noisy_zeros(laboratory, 44), kinds);
  ASSERT_EQ(d.found.size(), 1u);
  EXPECT_EQ(d.found[0].candidate.effect.kind->name, "friction");
  EXPECT_NEAR(d.found[0].candidate.effect.values[0], 10, 1.5);
  EXPECT_THAT(d.correlated_noise, HasSubstr("readings of one cycle are off together"));
}

}  // namespace
}  // namespace kinetostat::calibration::correlated_noise_test

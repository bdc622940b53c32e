// The statistics behind a diagnosis, on linear problems whose answers are known.
#include <cmath>

#include <Eigen/QR>
#include <gtest/gtest.h>

#include "kinetostat/calibration/comparison/waterfall.h"
#include "kinetostat/calibration/regression/held_out.h"
#include "kinetostat/calibration/search/free_form.h"
#include "kinetostat/calibration/search/max_score_test.h"

#include "calibration/random_matrix.h"

namespace kinetostat::calibration::candidate_fit_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::random_matrix;

// Eighteen candidates, some of several values, some nearly alike.
std::vector<Signature> signatures(Index rows) {
  std::vector<Signature> result;
  for (std::uint64_t s = 0; s < 18; ++s) {
    MatrixXd columns = random_matrix(rows, s % 3 == 2 ? 4 : 1, 100 + s);
    if (s % 5 == 4) columns.col(0) = result.back().columns.col(0) + 0.3 * columns.col(0);
    result.push_back({columns});
  }
  return result;
}

TEST(ResidualSpace, KeepsWhatIsNotConfoundedWithTheFit) {
  MatrixXd fitted(30, 4);
  fitted.leftCols(3) = random_matrix(30, 3, 1);
  fitted.col(3) = 1e9 * (fitted.col(0) - 2 * fitted.col(1));  // redundant, in another unit
  const ResidualSpace space(random_matrix(30, 1, 2), fitted);
  EXPECT_EQ(space.dimension(), 27);
  EXPECT_LT((fitted.transpose() * space.residual()).cwiseAbs().maxCoeff(), 1e-4);
  const MatrixXd column = random_matrix(30, 1, 3);
  const VectorXd by_least_squares =
      column - fitted.leftCols(3) * fitted.leftCols(3).colPivHouseholderQr().solve(column);
  EXPECT_LT((space.left_of(column) - by_least_squares).norm(), 1e-10);
}

constexpr double single = 1e-6;  // precision in which spans are kept

TEST(Screen, DetectabilityIsTheLengthThatIsLeftAndConfusionItsCosine) {
  MatrixXd fitted = MatrixXd::Zero(5, 1);
  fitted(0, 0) = 3;
  MatrixXd a = MatrixXd::Zero(5, 1), b = a, c = a;
  a.col(0) << 7, 3, 4, 0, 0;
  b.col(0) << 1, 4, -3, 0, 0;
  c.col(0) << 2, 0, 0, 0, 0;
  const ResidualSpace space(VectorXd::Unit(5, 1), fitted);
  const Screen screen(space, {{a}, {b}, {c}, {a + b}});
  EXPECT_NEAR(screen.detectability(0), 5, 1e-12);
  EXPECT_NEAR(screen.confusion(0, 1), 0, 1e-12);
  EXPECT_NEAR(screen.confusion(0, 3), std::sqrt(0.5), single);
  // The third is nothing but what is fitted anyway.
  EXPECT_EQ(screen.score(2, space.residual()).dimension, 0);
  EXPECT_NEAR(screen.score(0, space.residual()).explained, 0.36, single);
}

TEST(Screen, FindsTheLargestSignificanceOfManyResidualsAtOnce) {
  const ResidualSpace space(random_matrix(40, 1, 1), random_matrix(40, 3, 2));
  const Screen screen(space, signatures(40));
  const MatrixXd residuals = space.left_of(random_matrix(40, 9, 3));
  const auto largest = screen.largest_significance(residuals);
  ASSERT_EQ(std::ssize(largest), residuals.cols());
  for (Index column = 0; column < residuals.cols(); ++column) {
    const VectorXd residual = residuals.col(column);
    const auto [most, where] = largest[static_cast<std::size_t>(column)];
    for (std::size_t i = 0; i < screen.size(); ++i)
      EXPECT_LE(screen.significance(screen.score(i, residual), residual), most + 10 * single) << i;
    EXPECT_NEAR(screen.significance(screen.score(where, residual), residual), most, 10 * single);
  }
}

TEST(Screen, OfWhatIsSeenOtherwiseIsThatOfTheSignaturesTurned) {
  const MatrixXd turn = random_matrix(40, 40, 7);
  const ResidualSpace space(turn * random_matrix(40, 1, 1), turn * random_matrix(40, 3, 2));
  std::vector<Signature> turned = signatures(40);
  for (Signature& s : turned) s.columns = turn * s.columns;
  const Screen expected(space, turned);
  const Screen screen(space, signatures(40),
                      [&](const MatrixXd& columns) -> MatrixXd { return turn * columns; });
  ASSERT_EQ(screen.size(), expected.size());
  for (std::size_t i = 0; i < screen.size(); ++i) {
    EXPECT_EQ(screen.detectability(i), expected.detectability(i));
    EXPECT_EQ(Eigen::MatrixXf(screen.span(i)), Eigen::MatrixXf(expected.span(i)));
  }
}

// Family-wise: one campaign in twenty with nothing missing exceeds the detection threshold, though
// many candidates are tried. Without the maximum over all of them it would be about half of them.
TEST(MaxScoreTest, HoldsItsLevelOverManyCandidates) {
  constexpr Index n = 60;
  constexpr int campaigns = 250;
  const MatrixXd fitted = random_matrix(n, 5, 7);
  const std::vector<Signature> tried = signatures(n);
  int passed = 0, passed_uncorrected = 0;
  for (int c = 0; c < campaigns; ++c) {
    const ResidualSpace space(random_matrix(n, 1, 10'000 + static_cast<std::uint64_t>(c)), fitted);
    const Screen screen(space, tried);
    const MaxScoreTest result = max_score_test(screen, space, 0.05, 99, 500'000, 2);
    passed += result.p_value <= 0.05 ? 1 : 0;
    passed_uncorrected += result.largest >= -std::log(0.05) ? 1 : 0;
  }
  // Four standard deviations of a binomial count.
  EXPECT_NEAR(passed, 0.05 * campaigns, 4 * std::sqrt(campaigns * 0.05 * 0.95));
  EXPECT_GT(passed_uncorrected, 0.3 * campaigns);
}

// Noise that is 1.6 times as large as stated must not pass for an effect.
TEST(MaxScoreTest, IsNotFooledByNoiseThatIsLargerThanStated) {
  constexpr Index n = 60;
  constexpr int campaigns = 150;
  const MatrixXd fitted = random_matrix(n, 5, 7);
  const std::vector<Signature> tried = signatures(n);
  int passed = 0;
  for (int c = 0; c < campaigns; ++c) {
    const ResidualSpace space(1.6 * random_matrix(n, 1, 20'000 + static_cast<std::uint64_t>(c)),
                              fitted);
    passed +=
        max_score_test(Screen(space, tried), space, 0.05, 99, 500'000, 2).p_value <= 0.05 ? 1 : 0;
  }
  EXPECT_LT(passed, 0.05 * campaigns + 4 * std::sqrt(campaigns * 0.05 * 0.95));
}

TEST(MaxScoreTest, FindsWhatIsThere) {
  constexpr Index n = 60;
  const MatrixXd fitted = random_matrix(n, 5, 7);
  const std::vector<Signature> tried = signatures(n);
  const VectorXd signature =
      ResidualSpace(VectorXd::Zero(n), fitted).left_of(tried[6].columns).col(0);
  int found = 0;
  for (std::uint64_t c = 0; c < 100; ++c) {
    const VectorXd residual = random_matrix(n, 1, 30'000 + c) + 8 * signature / signature.norm();
    const ResidualSpace space(residual, fitted);
    const MaxScoreTest result = max_score_test(Screen(space, tried), space, 0.05, 99, 500'000, 2);
    found += result.p_value <= 0.05 && result.where == 6 ? 1 : 0;
  }
  EXPECT_GE(found, 95);
}

TEST(MaxScoreTest, DoesNotDependOnTheNumberOfThreads) {
  const ResidualSpace space(random_matrix(40, 1, 3), random_matrix(40, 2, 4));
  const Screen screen(space, signatures(40));
  const MaxScoreTest one = max_score_test(screen, space, 0.05, 200, 9, 1),
                     two = max_score_test(screen, space, 0.05, 200, 9, 2);
  EXPECT_EQ(one.p_value, two.p_value);
  EXPECT_EQ(one.critical, two.critical);
}

// Leaving groups out by the closed form is leaving them out by fitting anew.
TEST(HeldOut, EqualsFittingWithoutTheGroup) {
  constexpr Index n = 24, p = 4;
  const MatrixXd x = random_matrix(n, p, 11);
  const VectorXd y = random_matrix(n, 1, 12);
  VectorXd information = VectorXd::Zero(p);
  information[3] = 2;
  MatrixXd rows(n + 1, p);
  rows << x, std::sqrt(2.0) * VectorXd::Unit(p, 3).transpose();
  VectorXd right = VectorXd::Zero(n + 1);
  right.head(n) = y;
  const VectorXd all = rows.colPivHouseholderQr().solve(right);
  HeldOutGroups groups;
  for (Index g = 0; g < 6; ++g) groups.members.push_back({g, g + 6, g + 12, g + 18});
  const HeldOut result = held_out({x * all - y, x}, information, groups, 1);
  double total = 0;
  for (const auto& group : groups.members) {
    MatrixXd rest = rows;
    VectorXd rest_right = right;
    for (const Index i : group) {
      rest.row(i).setZero();
      rest_right[i] = 0;
    }
    const VectorXd without = rest.colPivHouseholderQr().solve(rest_right);
    const VectorXd error = y(group) - x(group, Eigen::all) * without;
    EXPECT_LT((result.error(group) - error).norm(), 1e-9);
    const MatrixXd covariance = MatrixXd::Identity(4, 4) + x(group, Eigen::all) *
                                                               (rest.transpose() * rest).inverse() *
                                                               x(group, Eigen::all).transpose();
    total += -0.5 * error.dot(covariance.inverse() * error) -
             0.5 * std::log(covariance.determinant()) - 2 * std::log(2 * M_PI);
  }
  EXPECT_NEAR(result.total(), total, 1e-8);
}

// Readings along a line of loads in two postures.
Campaign along_loads(int count) {
  Campaign campaign;
  campaign.configurations.resize(1);
  campaign.sessions = {""};
  for (int i = 0; i < count; ++i) {
    Reading reading;
    reading.displacement = spatial::Vector6::Constant(std::nan(""));
    reading.displacement[0] = 0;
    reading.load.force.x() = -1 + 2.0 * i / (count - 1);
    campaign.readings.push_back(reading);
  }
  return campaign;
}

// What a bound holds stays there when readings are left out: as if it were no unknown.
TEST(HeldOut, WhatABoundHoldsDoesNotMove) {
  constexpr Index n = 24;
  BaseFit fit;
  fit.at = {random_matrix(n, 1, 11), random_matrix(n, 2, 12)};
  fit.parameters.resize(2);
  fit.parameters[1].hit = BoundHit::lower;
  fit.parameters[1].parameter.prior = {0, 10};
  HeldOutGroups groups;
  for (Index g = 0; g < 6; ++g) groups.members.push_back({4 * g, 4 * g + 1, 4 * g + 2, 4 * g + 3});
  const HeldOut held = held_out(fit.at, prior_information(fit), groups, 1);
  const VectorXd range = VectorXd::Constant(1, 12 / (20.0 * 20.0));  // of what is free
  const HeldOut without = held_out({fit.at.residual, fit.at.jacobian.col(0)}, range, groups, 1);
  EXPECT_NEAR((held.error - without.error).norm(), 0, 1e-8);
  EXPECT_NEAR(held.total(), without.total(), 1e-8);
}

// An unknown that no reading tells, such as how an effect acts that is not there.
TEST(HeldOut, AnUndeterminedUnknownChangesNothing) {
  constexpr Index n = 24;
  const MatrixXd x = random_matrix(n, 2, 12);
  MatrixXd more(n, 3);
  more << VectorXd::Zero(n), x;
  const VectorXd residual = random_matrix(n, 1, 11);
  HeldOutGroups groups;
  for (Index g = 0; g < 6; ++g) groups.members.push_back({4 * g, 4 * g + 1, 4 * g + 2, 4 * g + 3});
  const HeldOut held = held_out({residual, more}, VectorXd::Zero(3), groups, 1);
  const HeldOut without = held_out({residual, x}, VectorXd::Zero(2), groups, 1);
  EXPECT_EQ(held.error, without.error);
  EXPECT_EQ(held.total(), without.total());
}

// A value that only the readings of one group determine is predicted for that group from its range,
// not from what chance makes of it in the others; without any range it is not predicted at all, and
// what the group itself makes of it is no error of thousands.
TEST(HeldOut, StaysWithinTheRangeWhereTheRestDeterminesNothing) {
  constexpr Index n = 24;
  BaseFit fit;
  MatrixXd x(n, 2);
  x << VectorXd::Ones(n), 1e-4 * random_matrix(n, 1, 22);
  x.col(1).tail(4).setConstant(50);
  const VectorXd y = random_matrix(n, 1, 21);
  fit.at = {x * x.householderQr().solve(y) - y, x};
  fit.parameters.resize(2);
  for (ParameterEstimate& e : fit.parameters) e.parameter.lower = -1, e.parameter.upper = 1;
  HeldOutGroups groups;
  for (Index g = 0; g < 6; ++g) groups.members.push_back({4 * g, 4 * g + 1, 4 * g + 2, 4 * g + 3});
  const HeldOut held = held_out(fit.at, prior_information(fit), groups, 1);
  const HeldOut free = held_out(fit.at, VectorXd::Zero(2), groups, 1);
  EXPECT_LT(held.error.tail(4).cwiseAbs().maxCoeff(), 50);
  EXPECT_GT(held.error.tail(4).cwiseAbs().maxCoeff(), free.error.tail(4).cwiseAbs().maxCoeff());
  EXPECT_LT(free.error.tail(4).cwiseAbs().maxCoeff(), 5);
}

TEST(FreeForm, SeesACurveAndNotNoise) {
  const Campaign campaign = along_loads(60);
  MatrixXd fitted(60, 2);
  VectorXd curve(60);
  for (Index i = 0; i < 60; ++i) {
    const double f = campaign.readings[static_cast<std::size_t>(i)].load.force.x();
    fitted.row(i) << 1, f;
    curve[i] = f * f * f;
  }
  const FreeForm free_form(campaign, values_in_use(campaign),
                           {.force = {}, .uncertain = fitted, .drives = {}});
  int false_alarms = 0, seen = 0;
  constexpr int campaigns = 400;
  for (std::uint64_t c = 0; c < campaigns; ++c) {
    const VectorXd noise = random_matrix(60, 1, 40'000 + c);
    const FreeFormEvidence nothing = free_form.evidence({noise, fitted}, 1);
    false_alarms += nothing.p_value() <= 0.05 ? 1 : 0;
    // Noise of 1.6 times what is stated counts for as much less.
    const FreeFormEvidence bent =
        free_form.evidence({1.6 * noise + 12 * curve, fitted}, 1 / (1.6 * 1.6));
    seen += bent.p_value() <= 0.05 && bent.depends_on.starts_with("load") ? 1 : 0;
  }
  EXPECT_LE(false_alarms, campaigns * 0.05);
  EXPECT_GE(seen, campaigns * 9 / 10);
}

TEST(FreeForm, WhatTheFitCanProduceIsNoEvidence) {
  const Campaign campaign = along_loads(12);
  const MatrixXd force = random_matrix(12, 3, 7), fitted = random_matrix(12, 2, 8);
  const FreeForm free_form(campaign, values_in_use(campaign),
                           {.force = force, .uncertain = fitted, .drives = {}});
  const VectorXd y = 3 * random_matrix(12, 1, 3);
  const double log = free_form.evidence({y, fitted}, 1).log;
  EXPECT_NEAR(log, free_form.evidence({y + fitted * random_matrix(2, 1, 4), fitted}, 1).log, 1e-9);
  EXPECT_LT(free_form.evidence({0 * y, fitted}, 1).log, 0);  // Occam's razor
}

TEST(FreeForm, WhatItRemembersIsWhatItWouldFind) {
  const Campaign campaign = along_loads(12);
  const MatrixXd fitted = random_matrix(12, 2, 8);
  const FreeFormWays ways{.force = random_matrix(12, 3, 7), .uncertain = fitted, .drives = {}};
  const FreeForm free_form(campaign, values_in_use(campaign), ways);
  for (const double exponent : {1.0, 0.5})
    for (std::uint64_t residual = 0; residual < 6; ++residual) {
      const ResidualSpace space(random_matrix(12, 1, residual), fitted);
      EXPECT_EQ(free_form.evidence(space, exponent).log,
                FreeForm(campaign, values_in_use(campaign), ways).evidence(space, exponent).log);
    }
}

// Which channel it goes through shows where the channels differ.
TEST(FreeForm, SaysWhatTheErrorActsLike) {
  Campaign campaign = along_loads(60);
  MatrixXd force = random_matrix(60, 3, 11);
  const MatrixXd fitted = random_matrix(60, 1, 12);
  const FreeForm free_form(campaign, values_in_use(campaign),
                           {.force = force, .uncertain = fitted, .drives = {}});
  VectorXd push(60);
  for (Index i = 0; i < 60; ++i)
    push[i] = std::sin(2 * campaign.readings[static_cast<std::size_t>(i)].load.force.x());
  const VectorXd y = 8 * force.col(1).cwiseProduct(push) + random_matrix(60, 1, 13);
  const FreeFormEvidence seen = free_form.evidence({y, fitted}, 1);
  EXPECT_LT(seen.p_value(), 1e-6);
  EXPECT_EQ(seen.depends_on, "load, as a force on the platform does");
}

// A drive whose compliance falls with its load acts like a law of that drive, though the whole load
// would do, too.
TEST(FreeForm, KnowsALawOfADrive) {
  const Campaign campaign = along_loads(60);
  VectorXd one(60), other(60);
  for (Index i = 0; i < 60; ++i) {
    one[i] = campaign.readings[static_cast<std::size_t>(i)].load.force.x();
    other[i] = std::sin(7 * one[i]);  // in other postures, say
  }
  MatrixXd fitted(60, 2);
  fitted << one, other;
  const FreeForm free_form(
      campaign, values_in_use(campaign),
      {.force = {}, .uncertain = fitted, .drives = {{"x.rho", one, one}, {"y.rho", other, other}}});
  const VectorXd law = 40 * other.array() / (1 + 6 * other.array().square());
  const FreeFormEvidence seen = free_form.evidence({law + random_matrix(60, 1, 21), fitted}, 1);
  EXPECT_EQ(seen.drive, "y.rho");
  EXPECT_EQ(seen.depends_on, "the load of y.rho, as a law of that drive does");
  EXPECT_LT(seen.p_value(), 1e-6);
}

// What yields slowly remembers the loads before.
TEST(FreeForm, KnowsAMemoryOfEarlierLoads) {
  Campaign campaign = along_loads(60);
  campaign.displacement = DisplacementKind::difference;
  VectorXd load(60), lag(60);
  double time = 0, before = 0;
  const VectorXd intervals = random_matrix(60, 1, 31).cwiseAbs(), loads = random_matrix(60, 1, 32);
  for (Index i = 0; i < 60; ++i) {
    Reading& reading = campaign.readings[static_cast<std::size_t>(i)];
    const double interval = i == 0 ? 0 : 20 + 40 * intervals[i];
    time += interval;
    reading.time = time;
    reading.cycle = "a";
    reading.step = static_cast<int>(i);
    reading.load.force.x() = load[i] = loads[i];
    lag[i] = std::exp(-interval / 60) * ((i == 0 ? 0 : lag[i - 1]) + load[i] - before);
    before = load[i];
  }
  const FreeForm free_form(campaign, values_in_use(campaign),
                           {.force = {}, .uncertain = load, .drives = {}});
  const FreeFormEvidence seen = free_form.evidence({8 * lag + random_matrix(60, 1, 33), load}, 1);
  EXPECT_EQ(seen.depends_on, "earlier loads, as a change of what is uncertain does");
  EXPECT_EQ(seen.over, SmoothOver::earlier_loads);
  EXPECT_LT(seen.p_value(), 1e-6);
}

// Three hours after a step of the load nothing of a memory of seconds is left to compute with.
TEST(FreeForm, MemoriesThatHaveFadedAreNoEvidence) {
  Campaign campaign = along_loads(12);
  for (std::size_t i = 0; i < 12; ++i) {
    campaign.readings[i].time = 10800.0 * static_cast<double>(i);
    campaign.readings[i].cycle = "a";
  }
  VectorXd load = VectorXd::LinSpaced(12, 0, 1);
  const FreeForm free_form(campaign, values_in_use(campaign),
                           {.force = {}, .uncertain = load, .drives = {}});
  const double log = free_form.evidence({random_matrix(12, 1, 33), load}, 1).log;
  EXPECT_TRUE(std::isfinite(log));
  EXPECT_LT(log, std::log(20));
}

TEST(Waterfall, IntervalHoldsTheErrorAndTheFloorIsTheNoise) {
  const Campaign campaign = along_loads(60);
  const std::vector<Value> values = values_in_use(campaign);
  Noise noise;
  noise.source = NoiseSource::stated;
  noise.sigma.assign(60, spatial::Vector6::Constant(2e-6));
  HeldOutGroups groups;
  for (Index i = 0; i < 60; i += 3) groups.members.push_back({i, i + 1, i + 2});
  const VectorXd error = 3 * random_matrix(60, 1, 5);
  const WaterfallStage stage = waterfall_stage("x", error, campaign, values, noise, groups, 1);
  EXPECT_NEAR(stage.whitened, std::sqrt(error.squaredNorm() / 60), 1e-12);
  EXPECT_LT(stage.lower, stage.whitened);
  EXPECT_GT(stage.upper, stage.whitened);
  EXPECT_NEAR(stage.translation, 2e-6 * stage.whitened, 1e-18);
  EXPECT_TRUE(std::isnan(stage.rotation));
  EXPECT_NEAR(noise_floor(campaign, values, noise).translation, 2e-6, 1e-18);
}

}  // namespace
}  // namespace kinetostat::calibration::candidate_fit_test

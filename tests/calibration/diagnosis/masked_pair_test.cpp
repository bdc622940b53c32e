// Effects that hide one another.
#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/search/max_score_test.h"
#include "kinetostat/calibration/search/pair_screen.h"

#include "calibration/laboratory.h"
#include "calibration/random_matrix.h"
#include "support/two_arms.h"

namespace kinetostat::calibration::masked_pair_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::Laboratory;
using test::random_matrix;

// Twelve candidates; the last is nearly the first.
std::vector<Signature> signatures(Index rows) {
  std::vector<Signature> result;
  for (std::uint64_t k = 0; k < 12; ++k)
    result.push_back({random_matrix(rows, k % 3 == 0 ? 2 : 1, 100 + k)});
  result.push_back({result[1].columns + 0.1 * random_matrix(rows, 1, 200)});
  return result;
}

std::vector<std::size_t> all_of(const Screen& screen) {
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < screen.size(); ++i) all.push_back(i);
  return all;
}

TEST(PairScreen, ExplainsWhatBothSpansTogetherExplain) {
  constexpr Index n = 40;
  const ResidualSpace space(random_matrix(n, 1, 1), random_matrix(n, 3, 2));
  const Screen screen(space, signatures(n));
  const PairScreen pairs(screen, all_of(screen));
  ASSERT_EQ(pairs.pairs().size(), 13u * 12 / 2);
  const VectorXd significances = pairs.significances(space.residual());
  for (std::size_t p = 0; p < pairs.pairs().size(); ++p) {
    const auto [a, b] = pairs.pairs()[p];
    MatrixXd both(n, screen.span(a).cols() + screen.span(b).cols());
    both << screen.span(a).cast<double>(), screen.span(b).cast<double>();
    const VectorXd fitted = both * both.householderQr().solve(space.residual());
    const double k = static_cast<double>(both.cols()), rest = 37 - k;
    const double explained = fitted.squaredNorm();
    const double noise = std::max(1.0, (space.residual().squaredNorm() - explained) / rest);
    const double spread = 2 / (9 * k);
    EXPECT_NEAR(significances[static_cast<Index>(p)],
                (std::cbrt(explained / noise / k) - 1 + spread) / std::sqrt(spread), 1e-6);
  }
}

TEST(PairScreen, SeesWhatNoSingleEffectShows) {
  constexpr Index n = 60;
  const MatrixXd fitted = random_matrix(n, 3, 2);
  const std::vector<Signature> tried = signatures(n);
  const ResidualSpace none(VectorXd::Zero(n), fitted);
  const VectorXd first = none.left_of(tried[1].columns).normalized();
  const VectorXd last = none.left_of(tried[12].columns);
  const VectorXd left = (last - first * first.dot(last)).normalized();  // of the last beside it
  int alone = 0, together = 0, right = 0;
  constexpr int campaigns = 60;
  for (std::uint64_t c = 0; c < campaigns; ++c) {
    const ResidualSpace space(9 * left + random_matrix(n, 1, 1000 + c), fitted);
    const Screen screen(space, tried);
    alone += max_score_test(screen, space, 0.05, 99, 500'000, 2).p_value <= 0.05 ? 1 : 0;
    const PairScreen pairs(screen, all_of(screen));
    const auto largest = [&](const MatrixXd& r) { return pairs.largest_significance(r); };
    const MaxScoreTest both =
        max_score_test(largest, space, significance_of_pairs, 199, 500'000, 2);
    together += both.p_value <= significance_of_pairs ? 1 : 0;
    right += pairs.pairs()[both.where] == std::pair<std::size_t, std::size_t>(1, 12) ? 1 : 0;
  }
  EXPECT_LT(alone, campaigns / 4);
  EXPECT_GE(together, campaigns * 9 / 10);
  EXPECT_GE(right, campaigns * 9 / 10);
}

TEST(MaskedPair, IsFoundThoughNeitherShowsAlone) {
  Laboratory laboratory(kinetostat::test::two_arms);
  laboratory.options().translation_noise = 3e-6;
  laboratory.options().displacement = DisplacementKind::absolute;
  laboratory.hide("preload", "q1", fmt::format("force={}", kinetostat::test::torque_1));
  laboratory.hide("preload", "q2", fmt::format("force={}", kinetostat::test::torque_2));
  const Diagnosis d = laboratory.diagnose(laboratory.measure(kinetostat::test::lifts()),
                                          {"preload", "clearance", "wrench_gain"});
  EXPECT_GT(d.steps[0].max_score.p_value, 0.05);  // nothing shows alone
  EXPECT_NE(d.verdict, Verdict::unexplained);
  ASSERT_EQ(d.found.size(), 2u);
  std::vector<std::string> names = {d.found[0].candidate.name(), d.found[1].candidate.name()};
  EXPECT_THAT(names, testing::UnorderedElementsAre("preload at arm.q1", "preload at arm.q2"));
  for (const FoundEffect& found : d.found) {
    EXPECT_GT(found.probability, 0.85);
    const double truth = found.candidate.effect.at == "arm.q1" ? -1.45 : 1.8;
    EXPECT_NEAR(found.candidate.effect.values[0], truth, 4 * found.deviations[0]);
  }
}

}  // namespace
}  // namespace kinetostat::calibration::masked_pair_test

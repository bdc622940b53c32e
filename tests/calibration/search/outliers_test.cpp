#include "kinetostat/calibration/search/outliers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/search/repeated_outliers.h"

#include "calibration/random_matrix.h"

namespace kinetostat::calibration::outliers_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr Index n = 120;

// Steps at every level of a load that goes up six times: any one reading lies between two of them.
std::vector<MatrixXd> steps() {
  std::vector<MatrixXd> effects;
  for (int first = 0; first < 20; ++first) {
    MatrixXd columns(n, 20);
    for (Index i = 0; i < n; ++i)
      for (Index k = 0; k < 20; ++k) columns(i, k) = i % 20 >= (first + k) % 20 ? 300 : 0;
    effects.push_back(columns);
    effects.back().conservativeResize(Eigen::NoChange, 4);
  }
  return effects;
}

std::vector<std::size_t> outliers_beside(const VectorXd& y, const std::vector<MatrixXd>& effects) {
  return outliers(y, MatrixXd::Ones(n, 1), effects.size(),
                  [&](std::size_t e) { return effects[e]; });
}

TEST(Outliers, AreSeenBesideEffectsThatCouldMoveAnyReading) {
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u}) {
    VectorXd y = test::random_matrix(n, 1, seed).col(0);
    y[37] += 12;
    y[99] -= 9;
    EXPECT_THAT(outliers_beside(y, steps()), ElementsAre(37, 99));
  }
}

TEST(Outliers, AreNotWhatAnEffectDoes) {
  for (const double size : {3.0, 8.0, 30.0, 400.0}) {
    const std::vector<MatrixXd> effects = steps();
    const VectorXd y = test::random_matrix(n, 1, 6).col(0) + size / 300 * effects[18].col(0);
    EXPECT_THAT(outliers_beside(y, effects), IsEmpty());
    VectorXd off = y;
    off[37] += 12;
    EXPECT_THAT(outliers_beside(off, effects), ElementsAre(37));
  }
}

TEST(Outliers, AreNotWhatTwoEffectsDo) {
  const std::vector<MatrixXd> effects = {test::random_matrix(n, 2, 7), test::random_matrix(n, 3, 8),
                                         test::random_matrix(n, 1, 9)};
  const VectorXd y =
      test::random_matrix(n, 1, 10).col(0) + 20 * effects[0].col(1) - 9 * effects[2].col(0);
  EXPECT_THAT(outliers_beside(y, effects), IsEmpty());
}

// 5 deviations in 20,000 values.
TEST(Outliers, AreNoneInNoise) {
  std::size_t found = 0;
  const std::vector<MatrixXd> effects = steps();
  for (std::uint64_t seed = 0; seed < 160; ++seed)
    found += outliers(test::random_matrix(n, 1, 100 + seed).col(0), test::random_matrix(n, 5, 400),
                      effects.size(), [&](std::size_t e) { return effects[e]; })
                 .size();
  EXPECT_EQ(found, 0u);
}

// Three postures pushed along x and z, up and down: 24 readings, of which two components are read.
struct Pushes {
  Campaign campaign;
  std::vector<Value> values;
  VectorXd residual;

  Pushes() {
    for (int posture = 0; posture < 3; ++posture)
      for (const Eigen::Index axis : {0, 2})
        for (const double force : {50., 100., -50., -100.}) {
          Reading& reading = campaign.readings.emplace_back();
          reading.load.force[axis] = force;
          for (const Eigen::Index component : {0, 2})
            values.push_back({campaign.readings.size() - 1, component});
        }
    residual = VectorXd::Zero(static_cast<Index>(values.size()));
  }
  // Of the first component, under the largest loads along an axis.
  std::vector<std::size_t> at_peaks(Eigen::Index axis) const {
    std::vector<std::size_t> found;
    for (std::size_t v = 0; v < values.size(); v += 2)
      if (std::abs(campaign.readings[values[v].reading].load.force[axis]) == 100)
        found.push_back(v);
    return found;
  }
  std::vector<std::size_t> left_of(const std::vector<std::size_t>& outliers) const {
    return without_repeated(campaign, values, residual, outliers);
  }
};

TEST(Outliers, AreNoneThatComeBackUnderALoad) {
  Pushes pushes;
  std::vector<std::size_t> far = pushes.at_peaks(2);
  ASSERT_EQ(far.size(), 6u);
  for (const std::size_t v : far) pushes.residual[static_cast<Index>(v)] = 9;
  EXPECT_THAT(pushes.left_of(far), IsEmpty());
  // Another one, of the other component, stays.
  far.push_back(7);
  EXPECT_THAT(pushes.left_of(far), ElementsAre(7));
  far.pop_back();
  // Off to both sides; too few; few of those that are loaded so.
  pushes.residual[static_cast<Index>(far[0])] = -9;
  EXPECT_EQ(pushes.left_of(far), far);
  pushes.residual[static_cast<Index>(far[0])] = 9;
  far.resize(3);
  EXPECT_EQ(pushes.left_of(far), far);
  std::vector<std::size_t> anywhere = {0, 2, 8, 18};
  for (const std::size_t v : anywhere) pushes.residual[static_cast<Index>(v)] = 9;
  EXPECT_EQ(pushes.left_of(anywhere), anywhere);
}

}  // namespace
}  // namespace kinetostat::calibration::outliers_test

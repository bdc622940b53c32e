#include "kinetostat/vjm/manipulator/free_motion.h"

#include <Eigen/QR>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "vjm/random_chain.h"

namespace kinetostat::vjm::free_motion_test {
namespace {

using spatial::Matrix6;
using spatial::Vector3;
using spatial::Vector6;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Twists = Eigen::Matrix<double, 6, Eigen::Dynamic>;

Vector6 rotation_about(const Vector3& point, const Vector3& axis, double pitch = 0) {
  Vector6 t;
  t << point.cross(axis) + pitch * axis, axis;
  return t;
}

Vector6 translation_along(const Vector3& direction) {
  Vector6 t;
  t << direction, Vector3::Zero();
  return t;
}

// A stiffness whose null space is spanned by the given twists, mixed so that no basis is favoured.
std::vector<std::string> sentences(const std::vector<Vector6>& free) {
  Twists twists(6, free.size());
  for (std::size_t i = 0; i < free.size(); ++i) twists.col(static_cast<Eigen::Index>(i)) = free[i];
  const Eigen::HouseholderQR<Twists> qr(twists);
  const Matrix6 q = qr.householderQ();
  const Matrix6 rest = q.rightCols(6 - twists.cols()) * q.rightCols(6 - twists.cols()).transpose();
  const FreeMotions result = free_motions(spatial::Stiffness6(1e6 * rest), 0.5);
  EXPECT_EQ(result.rank, 6 - twists.cols());
  EXPECT_EQ(result.motions.size(), free.size());
  return result.sentences;
}

TEST(FreeMotions, NoneWhenTheStiffnessHasFullRank) {
  const FreeMotions result = free_motions(spatial::Stiffness6(Matrix6::Identity()), 1.0);
  EXPECT_EQ(result.rank, 6);
  EXPECT_TRUE(result.sentences.empty());
}

TEST(FreeMotions, OneRotationIsNamedByItsAxis) {
  EXPECT_THAT(sentences({rotation_about({0.1, 0.2, 0}, {0, 0, 1})}),
              ElementsAre("free rotation about the axis through (100, 200, 0) mm along z"));
}

TEST(FreeMotions, OneTranslationIsNamedByItsDirection) {
  EXPECT_THAT(sentences({translation_along({0, -1, 0})}), ElementsAre("free translation along y"));
}

TEST(FreeMotions, AScrewIsNamedWithItsPitch) {
  EXPECT_THAT(sentences({rotation_about({0, 0.05, 0}, {1, 0, 0}, 0.02)}),
              ElementsAre("free screw motion about the axis through (0, 50, 0) mm along x with 20 "
                          "mm of advance per radian"));
}

TEST(FreeMotions, RotationsAboutOnePointAreNamedTogether) {
  const Vector3 c(0.3, -0.1, 0.2);
  EXPECT_THAT(sentences({rotation_about(c, {1, 0, 0}), rotation_about(c, {0, 1, 1}),
                         rotation_about(c, {1, 1, 0})}),
              ElementsAre("every rotation about the point (300, -100, 200) mm is free"));
  EXPECT_THAT(
      sentences({rotation_about(c, {1, 0, 0}), rotation_about(c, {0, 1, 0})}),
      ElementsAre("every rotation about the point (300, -100, 200) mm normal to z is free"));
}

TEST(FreeMotions, PlanarMotionIsTwoTranslationsAndARotation) {
  const auto words = sentences({translation_along({1, 0, 0}), translation_along({0, 1, 0}),
                                rotation_about({0.4, 0.3, 0}, {0, 0, 1})});
  ASSERT_EQ(words.size(), 3u);
  EXPECT_THAT(words[2], HasSubstr("free rotation about the axis through (0, 0, 0) mm along z"));
}

TEST(FreeMotions, AllTranslations) {
  EXPECT_THAT(sentences({translation_along({1, 0, 0}), translation_along({0, 1, 0}),
                         translation_along({0, 0, 1})}),
              ElementsAre("every translation is free"));
}

// Random spaces: whatever is said must span the null space.
TEST(FreeMotions, TheMotionsNamedSpanTheNullSpace) {
  samples::RandomChains random(31);
  for (int trial = 0; trial < 100; ++trial) {
    Twists twists(6, 1 + trial % 5);
    for (Eigen::Index i = 0; i < twists.cols(); ++i) twists.col(i) = random.vector6(0.5, 1.0);
    const FreeMotions result = describe_twists(twists, {}, 0.5);
    ASSERT_EQ(static_cast<Eigen::Index>(result.motions.size()), twists.cols());
    Twists both(6, 2 * twists.cols());
    both.leftCols(twists.cols()) = twists;
    for (Eigen::Index i = 0; i < twists.cols(); ++i) {
      const ScrewMotion& m = result.motions[static_cast<std::size_t>(i)];
      both.col(twists.cols() + i) = m.is_translation
                                        ? translation_along(m.direction)
                                        : rotation_about(m.point, m.direction, m.pitch);
    }
    Eigen::ColPivHouseholderQR<Twists> qr;
    qr.setThreshold(1e-8);
    EXPECT_EQ(qr.compute(both).rank(), twists.cols()) << "trial " << trial;
    EXPECT_EQ(qr.compute(Twists(both.rightCols(twists.cols()))).rank(), twists.cols());
  }
}

}  // namespace
}  // namespace kinetostat::vjm::free_motion_test

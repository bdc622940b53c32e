#include "kinetostat/vjm/statics/segments.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

#include "kinetostat/vjm/chain/beam.h"
#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/continuation/path.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::vjm::segments_test {
namespace {

TEST(SegmentStudy, ExtrapolatesASquareLawExactly) {
  const SegmentStudy study = study_segments({1, 2, 4}, [](int n) { return 3 + 2.0 / (n * n); });
  EXPECT_NEAR(study.extrapolated(), 3, 1e-14);
  EXPECT_NEAR(study.error(0), 2.0 / 3, 1e-14);
  EXPECT_NEAR(*study.observed_order(), 2, 1e-12);
}

TEST(SegmentStudy, StopsWhereThereIsNoResult) {
  const SegmentStudy study =
      study_segments({1, 2, 4}, [](int n) { return n < 2 ? std::optional(1.0) : std::nullopt; });
  EXPECT_EQ(study.multiples.size(), 1U);
  EXPECT_THROW(study.extrapolated(), std::logic_error);
  EXPECT_FALSE(study.observed_order());
}

// Euler's column of three links between pins, pi^2 / 9 in E I / L^2.
TEST(SegmentStudy, OfAColumnConvergesToEulerWithOrderTwo) {
  constexpr double length = 0.3;
  Section section;
  section.area = 0.04;  // hardly compressible
  section.second_moment_y = 1e-6;
  section.second_moment_z = 1e-9;
  section.torsion_constant = 1e-8;
  const Material steel{210e9, 80e9, std::nullopt};
  const double unit = steel.young_modulus * section.second_moment_z / (length * length);
  const auto critical_force = [&](int n) -> std::optional<double> {
    ChainBuilder chain("column");
    chain.passive("pin1", Motion::rz);
    const spatial::Compliance6 piece(
        beam_compliance(length / n, section, steel, BeamTheory::euler_bernoulli).matrix());
    for (int i = 0; i < 3 * n; ++i)
      chain.link("l" + std::to_string(i), spatial::Pose::translation({length / n, 0, 0}), piece);
    chain.passive("pin2", Motion::rz);
    const Manipulator column("column", {chain.build()});
    PathTask task;
    task.displacement[0] = -3 * length * 2 * unit / (steel.young_modulus * section.area);
    PathOptions options;
    options.until_critical = true;
    options.points = 4;
    common::Progress progress;
    const Path path =
        trace(column, posture_from_joints(column, {}).posture, task, options, progress);
    if (path.critical.empty()) return std::nullopt;
    return path.critical[0].point.along->force / unit;
  };
  const double euler = std::numbers::pi * std::numbers::pi / 9;
  const SegmentStudy study = study_segments({1, 2, 4, 8, 16}, critical_force);
  ASSERT_EQ(study.values.size(), 5U);
  EXPECT_NEAR(study.values[0] / euler, 1.44, 0.01);
  EXPECT_NEAR(study.values[2] / euler, 1.023, 0.001);
  EXPECT_NEAR(*study.observed_order(), 2, 0.05);
  EXPECT_NEAR(study.extrapolated() / euler, 1, 2e-5);
  const SegmentStudy coarse{{4, 8}, {study.values[2], study.values[3]}};
  EXPECT_NEAR(coarse.extrapolated() / euler, 1, 1e-3);
}

}  // namespace
}  // namespace kinetostat::vjm::segments_test

// A load cell with a wrong zero, or near its end, and joints that do something alike.
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "kinetostat/spatial/rotation.h"

#include "calibration/two_links.h"

namespace kinetostat::calibration::load_cell_test {
namespace {

using spatial::Vector3;
using Bench = test::TwoLinks;

// Pushed and pulled along x and y at three postures.
std::string pushes() {
  std::string csv = "id,cycle,step,q1,q2,fx,fy\n";
  int row = 0, cycle = 0;
  for (const auto& [q1, q2] : {std::pair(0.2, 1.2), std::pair(-0.6, 0.7), std::pair(0.9, -1.4)})
    for (const bool along_x : {true, false}) {
      ++cycle;
      int step = 0;
      for (const double f : {0, 60, 120, 180, 120, 0, -60, -120, -180, -120, 0})
        csv += fmt::format("r{},c{},{},{},{},{},{}\n", row++, cycle, step++, q1, q2,
                           along_x ? f : 0.0, along_x ? 0.0 : f);
    }
  return csv;
}

// What a load cell says of the forces that acted, by a law of this test.
template <class Law>
Campaign read_by(Campaign campaign, const Law& law) {
  for (Reading& reading : campaign.readings)
    if (!reading.load.force.isZero(0)) reading.load.force = law(reading.load.force);
  return campaign;
}

std::string best_of(const Diagnosis& d) {
  return d.found.empty() ? "nothing" : d.found[0].candidate.effect.kind->name;
}

class LoadCell : public testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Seeds, LoadCell, testing::Values(1, 2));

void expect_zero(const Diagnosis& d, const Vector3& zero) {
  EXPECT_EQ(d.verdict, Verdict::identified);
  ASSERT_EQ(best_of(d), "wrench_zero");
  EXPECT_NEAR(d.found[0].candidate.effect.values[0], zero.x(), 1);
  EXPECT_NEAR(d.found[0].candidate.effect.values[1], zero.y(), 1);
  EXPECT_EQ(d.found.size(), 1u);
}

TEST_P(LoadCell, WithAWrongZeroIsNamed) {
  Bench bench(GetParam());
  const Vector3 zero(4, -6, 0);
  const Campaign readings =
      read_by(bench.measure(pushes()), [&](const Vector3& f) -> Vector3 { return f - zero; });
  expect_zero(bench.diagnose(readings, {}), zero);
}

// A hook that is not counted hangs on from before the first reading to the last.
TEST_P(LoadCell, WithAHookThatIsNotCountedIsNamed) {
  Bench bench(GetParam());
  bench.hide("wrench_zero", "load", "fx=4 N,fy=-6 N,always=1");
  const Campaign readings = bench.measure(pushes());
  const Diagnosis d = bench.diagnose(readings, {});
  expect_zero(d, Vector3(4, -6, 0));
  EXPECT_EQ(d.found[0].candidate.effect.values[6], 1);
}

// One on the platform, which turns with it, as has its zero.
TEST_P(LoadCell, WithAWrongZeroInAxesOfItsOwnIsNamed) {
  Bench bench(GetParam());
  const Vector3 zero(4, -6, 0);
  Campaign readings = bench.measure(pushes());
  for (Reading& reading : readings.readings) {
    if (reading.load.force.isZero(0)) continue;
    const auto& joints = readings.configurations[reading.configuration].joints;
    const double turned = joints.at("arm.q1") + joints.at("arm.q2");
    reading.load.cell = spatial::rotation_from_rpy({0, 0, turned});
    reading.load.force -= reading.load.cell * zero;
  }
  expect_zero(bench.diagnose(readings, {}), zero);
}

TEST_P(LoadCell, ThatNearsItsEndIsNamed) {
  Bench bench(GetParam());
  const double end = 260;  // [N]
  const Campaign readings = read_by(bench.measure(pushes()), [&](const Vector3& f) -> Vector3 {
    return end * std::tanh(f.norm() / end) * f.normalized();
  });
  const Diagnosis d = bench.diagnose(readings, {});
  EXPECT_EQ(d.verdict, Verdict::identified);
  EXPECT_EQ(best_of(d), "wrench_saturation");
  EXPECT_EQ(d.found.size(), 1u);
}

TEST_P(LoadCell, IsNotBlamedForWhatAJointDoes) {
  for (const char* joint : {"q1", "q2"}) {
    Bench play(GetParam());
    play.hide("clearance", joint, "gap=1e-4 rad");
    EXPECT_EQ(best_of(play.diagnose(play.measure(pushes()), {})), "clearance") << joint;
    Bench rough(GetParam());
    rough.hide("friction", joint, "force=4 N m,presliding=1e-6 rad");
    EXPECT_EQ(best_of(rough.diagnose(rough.measure(pushes()), {})), "friction") << joint;
  }
  Bench plain(GetParam());
  EXPECT_EQ(plain.diagnose(plain.measure(pushes()), {}).verdict, Verdict::none_needed);
}

// Known weights have nothing to do with a load cell.
TEST(LoadCellZero, IsNoneOfKnownWeights) {
  Bench bench(3);
  const Vector3 zero(4, -6, 0);
  Campaign readings =
      read_by(bench.measure(pushes()), [&](const Vector3& f) -> Vector3 { return f - zero; });
  for (Reading& reading : readings.readings) reading.known_load = true;
  EXPECT_NE(best_of(bench.diagnose(readings, {})), "wrench_zero");
}

}  // namespace
}  // namespace kinetostat::calibration::load_cell_test

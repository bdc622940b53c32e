// What several chains stand on together, and what the platform holds the tool with.
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "kinetostat/report/screen/diagnosis.h"

#include "calibration/laboratory.h"

namespace kinetostat::calibration::shared_mounts_test {
namespace {

const std::string hexapod =
    "kinetostat: 1\nname: six legs\nunits: {length: mm, force: N, angle: deg}\n"
    "chain_types:\n  leg:\n"
    "    - passive: {name: universal, axes: [Rx, Ry]}\n"
    "    - actuator: {name: length, axis: Tz, stiffness: 2.5e7 N/m, home: 600}\n"
    "    - passive: {name: spherical, axes: [Rx, Ry, Rz]}\n"
    "manipulator:\n  chains:\n"
    "    - {name: a, type: leg, base: [440, -90, 0], platform_point: [170, -180, -50]}\n"
    "    - {name: b, type: leg, base: [440, 90, 0], platform_point: [170, 180, -50]}\n"
    "    - {name: c, type: leg, base: [-140, 430, 0], platform_point: [80, 240, -50]}\n"
    "    - {name: d, type: leg, base: [-300, 330, 0], platform_point: [-240, 50, -50]}\n"
    "    - {name: e, type: leg, base: [-300, -330, 0], platform_point: [-240, -50, -50]}\n"
    "    - {name: f, type: leg, base: [-140, -430, 0], platform_point: [80, -240, -50]}\n"
    "uncertain:\n  - {stiffness: a.length}\n  - {stiffness: b.length}\n"
    "  - {stiffness: c.length}\n  - {stiffness: d.length}\n  - {stiffness: e.length}\n"
    "  - {stiffness: f.length}\n";

// A push along each axis and back, in three postures.
std::string pushes() {
  std::string csv =
      "id,session,configuration,cycle,a.length,b.length,c.length,d.length,e.length,f.length,"
      "fx,fy,fz\n";
  int id = 0;
  for (int posture = 0; posture < 3; ++posture)
    for (int axis = 0; axis < 3; ++axis)
      for (const double load : {0., 800., 0., -800., 0.}) {
        csv += fmt::format("r{},am,p{},{}", id++, posture, 3 * posture + axis + 1);
        for (int leg = 0; leg < 6; ++leg)
          csv += fmt::format(",{:.3f}", 600 + 25 * std::sin(1.7 * posture + 2.3 * leg * posture));
        for (int k = 0; k < 3; ++k) csv += fmt::format(",{}", k == axis ? load : 0);
        csv += "\n";
      }
  return csv;
}

class SharedMounts : public testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Seeds, SharedMounts, testing::Values(1u, 2u));

void expect_found(const std::string& kind, const std::string& at, const std::string& size,
                  unsigned seed, const std::string& words) {
  test::Laboratory bench(hexapod);
  bench.options().components = {true, true, true, true, true, true};
  bench.options().translation_noise = 5e-7;
  bench.options().rotation_noise = 1.5e-6;
  bench.options().seed = seed;
  bench.hide(kind, at, size);
  const Campaign campaign = bench.measure(pushes());
  const Diagnosis d = bench.diagnose(campaign, {});
  const std::string said = report::first_screen(bench.robot(), campaign, d, "");
  ASSERT_EQ(d.found.size(), 1u) << said;
  EXPECT_EQ(d.verdict, Verdict::identified) << said;
  EXPECT_EQ(d.found[0].candidate.name(), kind + " at " + at) << said;
  EXPECT_NE(said.find(words), std::string::npos) << said;
}

TEST_P(SharedMounts, NameTheFoundation) {
  expect_found("base_tilt", "foundation", "x=6e-8 rad/(N m),z=1.2e-7 rad/(N m)", GetParam(),
               "ase tilt at the foundation of all chains");
}

TEST_P(SharedMounts, NameTheTool) {
  expect_found("platform_compliance", "tool", "rotation=8e-7 rad/(N m)", GetParam(),
               "latform compliance at the tool on the platform");
}

}  // namespace
}  // namespace kinetostat::calibration::shared_mounts_test

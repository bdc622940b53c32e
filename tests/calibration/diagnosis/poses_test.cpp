// Poses, in which nothing need change at one configuration: sizes are counted in what a model does
// not predict.
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "kinetostat/report/screen/diagnosis.h"

#include "calibration/two_links.h"

namespace kinetostat::calibration::poses_test {
namespace {

class Poses : public testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Seeds, Poses, testing::Range(1u, 7u));

// Sixty, one a minute, of an arm that yields by little beside its noise.
class Bench : public test::TwoLinks {
 public:
  explicit Bench(unsigned seed) : TwoLinks(seed) {
    options().displacement = DisplacementKind::absolute;
    options().translation_noise = 2e-5;
  }
  Campaign measured() {
    std::string csv = "id,session,time,q1,q2,fx\n";
    for (int r = 0; r < 60; ++r)
      csv += fmt::format("r{},am,{},{},{},{}\n", r, 60 * r, 1.5 * std::sin(0.9 * r),
                         1 + std::cos(1.3 * r), r % 2 == 0 ? 0 : 0.5);
    return measure(csv);
  }
  /// The only effect that is found; else all that is said.
  std::string only_one() {
    const Campaign campaign = measured();
    const Diagnosis d = diagnose(campaign, {});
    return d.verdict == Verdict::identified && d.found.size() == 1
               ? d.found[0].candidate.name()
               : report::text(robot(), campaign, d);
  }
};

TEST_P(Poses, NameAnEccentricDrive) {
  for (const char* joint : {"q1", "q2"}) {
    Bench bench(GetParam());
    bench.hide("eccentricity", joint, "cosine=3e-4 rad,sine=-1e-4 rad");
    EXPECT_EQ(bench.only_one(), fmt::format("eccentricity at arm.{}", joint));
  }
}

TEST_P(Poses, NameADrift) {
  Bench bench(GetParam());
  bench.hide("session_drift", "sensor", "x=3e-8 m/s,y=-2e-8 m/s");
  EXPECT_EQ(bench.only_one(), "session_drift at sensor");
}

}  // namespace
}  // namespace kinetostat::calibration::poses_test

// Instruments of the twin against closed forms.
#include "instrument.h"

#include <cmath>

#include <gtest/gtest.h>

namespace twin::instrument_test {
namespace {

const Pose rest{Vector3(0.3, -0.2, 0.5), Matrix3::Identity()};

// What is read along one axis beyond the way that was gone, which is one metre long.
double beyond(Instrument& gauge, int axis, double way) {
  Pose pose = rest;
  pose.x[axis] += way;
  return gauge.shown(pose, {}).x[axis] - pose.x[axis];
}

TEST(Instrument, ShowsWhatItLooksAtWhereNothingIsHidden) {
  Instrument plain({{"friction", "q1", 3}, {"gauge_play", "sensor", 0}}, rest);
  for (const double way : {1e-5, -2e-5, 0.}) EXPECT_EQ(beyond(plain, 0, way), 0);
}

// Far from where it turned round it is the gap behind; back and forth it makes a loop of twice
// the gap; on the way from rest the lag is gap (1 - exp(-way / gap)), however many steps that has.
TEST(Instrument, LagsBehindAsDahlSays) {
  const double size = 5e-6;
  for (int axis = 0; axis < 3; ++axis) {
    Instrument gauge({{"gauge_play", "sensor", size}}, rest);
    const double far = 1e-3, gap = -beyond(gauge, axis, far);
    EXPECT_GT(gap, 0.4 * size);
    EXPECT_LT(gap, size);
    EXPECT_NEAR(beyond(gauge, axis, -far), gap, 1e-12);
    EXPECT_NEAR(beyond(gauge, axis, far), -gap, 1e-12);
    Instrument once({{"gauge_play", "sensor", size}}, rest);
    Instrument often = once;
    const double way = 0.7 * gap, expected = -gap * (1 - std::exp(-0.7));
    EXPECT_NEAR(beyond(once, axis, way), expected, 1e-12);
    for (const double share : {0.1, 0.35, 0.8}) beyond(often, axis, share * way);
    EXPECT_NEAR(beyond(often, axis, way), expected, 1e-12);
  }
}

TEST(Instrument, IsOffInOneCycleOfMondayAlone) {
  const double size = 4e-5;
  Instrument stand({{"cycle_offset", "sensor", size}}, rest);
  const auto off = [&](const std::string& session, int cycle, int step) {
    return (stand.shown(rest, {.session = session, .cycle = cycle, .step = step}).x - rest.x)
        .norm();
  };
  EXPECT_NEAR(off("monday", 3, 1), size, 1e-12);
  EXPECT_NEAR(off("monday", 3, 3), 0.97 * 0.97 * size, 1e-12);
  EXPECT_EQ(off("monday", 2, 1), 0);
  EXPECT_EQ(off("tuesday", 3, 1), 0);
}

}  // namespace
}  // namespace twin::instrument_test

// A verdict does not depend on how robot and readings are written down: units, base frame, names,
// order, sessions, rows that are there twice, further candidates, more of the same.
#include <algorithm>
#include <functional>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/spatial/rotation.h"

#include "calibration/laboratory.h"

namespace kinetostat::calibration::rewritten_test {
namespace {

using spatial::Matrix3;
using spatial::Vector3;
using test::Laboratory;

// How the same arm and the same readings are written.
struct Writing {
  double length = 1, force = 1, angle = 1, time = 1;  // units of the files [SI]
  std::string units = "length: m, force: N, angle: rad, time: s";
  spatial::Pose base = {};  // of the arm, and of all that is read and applied
  std::string shoulder = "q1", elbow = "q2", chain = "arm";
  std::string effects = {};  // of the robot file
  std::function<std::string(const Reading&)> session = [](const Reading&) { return "day"; };
  std::function<void(std::vector<Reading>&)> order = [](std::vector<Reading>&) {};
};

std::string arm(const Writing& w) {
  const Vector3 at = w.base.position() / w.length;
  const spatial::Vector3 turn = spatial::log_rotation(w.base.rotation()) / w.angle;
  return fmt::format(
      "kinetostat: 1\nname: two joints\nunits: {{{}}}\n{}chain_types:\n  type:\n"
      "    - actuator: {{name: {}, axis: Rz, stiffness: {:.17g}}}\n    - offset: [{:.17g}, 0, 0]\n"
      "    - actuator: {{name: {}, axis: Ry, stiffness: {:.17g}}}\n    - offset: [{:.17g}, 0, 0]\n"
      "manipulator:\n  chains:\n    - {{name: {}, type: type, base: {{point: [{:.17g}, {:.17g}, "
      "{:.17g}], rotation_vector: [{:.17g}, {:.17g}, {:.17g}]}}}}\n"
      "uncertain:\n  - {{stiffness: {}}}\n  - {{stiffness: {}}}\n",
      w.units, w.effects, w.shoulder, 2e5 / (w.force * w.length), 0.4 / w.length, w.elbow,
      1e5 / (w.force * w.length), 0.3 / w.length, w.chain, at[0], at[1], at[2], turn[0], turn[1],
      turn[2], w.shoulder, w.elbow);
}

constexpr double exact_translation = 2e-6, exact_rotation = 1e-5;  // m, rad

// Of a campaign of the arm as it stands in Writing().
std::string readings(const Campaign& campaign, const Writing& w) {
  std::string csv = fmt::format("id,session,cycle,step,time,{},{},fx,fy,fz,dx,dy,dz,rx,ry,rz\n",
                                w.shoulder, w.elbow);
  std::vector<Reading> rows = campaign.readings;
  w.order(rows);
  const Matrix3& turn = w.base.rotation();
  for (const Reading& r : rows) {
    const auto& joints = campaign.configurations[r.configuration].joints;
    const Vector3 force = turn * r.load.force / w.force;
    const Vector3 shift = turn * r.displacement.head<3>() / w.length;
    const Vector3 tilt = turn * r.displacement.tail<3>() / w.angle;
    csv +=
        fmt::format("{},{},{},{},{:.17g},{:.17g},{:.17g}", r.id, w.session(r), r.cycle, *r.step,
                    *r.time / w.time, joints.at("arm.q1") / w.angle, joints.at("arm.q2") / w.angle);
    for (const Vector3& v : {force, shift, tilt})
      csv += fmt::format(",{:.17g},{:.17g},{:.17g}", v[0], v[1], v[2]);
    csv += "\n";
  }
  return csv;
}

std::string plan(int cycles) {
  std::string csv = "id,session,cycle,step,time,q1,q2,fx,fy,fz\n";
  int n = 0;
  for (int cycle = 0; cycle < cycles; ++cycle)
    for (int step = 0; step <= 12; ++step) {
      const int way = step <= 3 ? step : step <= 9 ? 6 - step : step - 12;
      const double level = 100 * way;
      ++n;
      csv += fmt::format("r{},day,c{},{},{},{},{},0,{},{}\n", n, cycle, step, 60 * n,
                         cycle % 2 == 0 ? 0.2 : -0.5, cycle % 2 == 0 ? 0.4 : 1.1,
                         cycle % 3 == 2 ? 0.0 : level, cycle % 3 == 2 ? level : 0.0);
    }
  return csv;
}

struct Hidden {
  const char *name, *kind, *at, *size;
  bool is_clear;  // else several answers have a share
};
constexpr Hidden friction{"friction", "friction", "q1", "force=15 N m,presliding=0.05 mrad", true};
constexpr Hidden play{"play", "clearance", "q2", "gap=0.1 mrad", true};
constexpr Hidden little_play{"little_play", "clearance", "q2", "gap=0.006 mrad", false};

Campaign measured(const Hidden& hidden, int cycles) {
  Laboratory laboratory(arm({}));
  laboratory.options().components = {true, true, true, true, true, true};
  laboratory.options().translation_noise = exact_translation;
  laboratory.options().rotation_noise = exact_rotation;
  laboratory.options().seed = 4;
  laboratory.hide(hidden.kind, hidden.at, hidden.size);
  return laboratory.measure(plan(cycles));
}

Diagnosis diagnosed(const Campaign& campaign, const Writing& w) {
  const kinetostat::test::TemporaryFolder folder;
  io::write_atomically(folder.path() / "robot.yaml", arm(w));
  io::write_atomically(folder.path() / "readings.csv", readings(campaign, w));
  io::write_atomically(
      folder.path() / "campaign.yaml",
      fmt::format("kinetostat: 1\ncampaign: as written\norigin: simulated\nrobot: robot.yaml\n"
                  "units: {{{}}}\ndisplacement: difference\nwrench_point: reference\n"
                  "noise: {{translation: {} m, rotation: {} rad}}\nreadings: readings.csv\n",
                  w.units, exact_translation, exact_rotation));
  const vjm::Robot robot = vjm::read_robot(folder.path() / "robot.yaml");
  const Campaign read = read_campaign(folder.path() / "campaign.yaml", robot.manipulator);
  common::Progress silent;
  return diagnose(robot, read, {.kinds = {}, .draws = 199}, 2, silent);
}

void expect_same(const Diagnosis& a, const Diagnosis& b, double within) {
  EXPECT_EQ(to_string(a.verdict), to_string(b.verdict));
  ASSERT_EQ(a.found.size(), b.found.size());
  for (std::size_t f = 0; f < a.found.size(); ++f) {
    EXPECT_NEAR(a.found[f].probability, b.found[f].probability, within);
    const std::vector<Answer>&one = a.found[f].decision.answers,
          &other = b.found[f].decision.answers;
    ASSERT_FALSE(one.empty() || other.empty());
    EXPECT_EQ(one[0].effect_class, other[0].effect_class);
    EXPECT_EQ(one[0].places.size(), other[0].places.size());
    EXPECT_EQ(a.found[f].candidate.effect.kind->name, b.found[f].candidate.effect.kind->name);
    EXPECT_NEAR(a.found[f].decision.nothing, b.found[f].decision.nothing, within);
    EXPECT_NEAR(a.found[f].decision.unexplained, b.found[f].decision.unexplained, within);
  }
}

class Rewritten : public testing::TestWithParam<Hidden> {
 protected:
  Rewritten() : campaign_(measured(GetParam(), 4)), plain_(diagnosed(campaign_, {})) {}

  void SetUp() override {
    if (!GetParam().is_clear) return;
    EXPECT_EQ(to_string(plain_.verdict), "identified");
    ASSERT_EQ(plain_.found.size(), 1u);
    EXPECT_EQ(plain_.found[0].candidate.effect.kind->name, GetParam().kind);
  }
  void expect_same_as(const Writing& w, double within = 0.01) const {
    expect_same(plain_, diagnosed(campaign_, w), within);
  }

  Campaign campaign_;
  Diagnosis plain_;
};

TEST_P(Rewritten, InOtherUnits) {
  expect_same_as({.length = 1e-3,
                  .force = 1e3,
                  .angle = std::acos(-1) / 180,
                  .time = 60,
                  .units = "length: mm, force: kN, angle: deg, time: min"});
  expect_same_as({.length = 0.0254,
                  .force = 4.4482216152605,
                  .angle = 1e-3,
                  .time = 3600,
                  .units = "length: in, force: lbf, angle: mrad, time: h"});
}

// Gains of channels are those of axes in which is read, and these are others now.
TEST_P(Rewritten, WithTheBaseElsewhere) {
  expect_same_as(
      {.base = spatial::Pose(spatial::exp_rotation(Vector3(0.7, -1.1, 0.4)), Vector3(3, -2, 11))},
      0.03);
}

TEST_P(Rewritten, WithOtherNames) {
  expect_same_as({.shoulder = "z_axis", .elbow = "a_axis", .chain = "nose"});
}

TEST_P(Rewritten, WithRowsInAnotherOrder) {
  // The cycles from last to first, each with its steps mixed.
  expect_same_as({.order = [](std::vector<Reading>& rows) {
    std::reverse(rows.begin(), rows.end());
    for (std::size_t k = 0; k + 5 < rows.size(); k += 3) std::swap(rows[k], rows[k + 5]);
  }});
}

// Errors that last from one reading to the next end with a session, which counts where two laws are
// nearly as probable.
TEST_P(Rewritten, InTwoSessions) {
  expect_same_as(
      {.session = [](const Reading& r) { return r.cycle < "c2" ? "morning" : "evening"; }},
      GetParam().is_clear ? 0.01 : 0.03);
}

// An effect that no reading can show, and one that all could and none does.
TEST_P(Rewritten, WithFurtherCandidates) {
  expect_same_as(
      {.effects = "effect_kinds:\n"
                  "  cam: {offset: 'a * sin(7 * u)', summary: the drive leads the joint astray, "
                  "parameters: {a: {unit: urad, between: [-900, 900], prior: 50}}}\n"
                  "  pull: {force: 'a * sin(t / 500)', summary: something pulls now and then, "
                  "parameters: {a: {unit: N m, between: [-900, 900], prior: 10}}}\n"});
}

TEST_P(Rewritten, WithEveryRowTwice) {
  expect_same_as({.order = [](std::vector<Reading>& rows) {
    const std::vector<Reading> once = rows;
    for (Reading copy : once) {
      copy.id += "_copy";
      rows.push_back(copy);
    }
  }});
}

TEST_P(Rewritten, WithMoreOfTheSameKind) {
  const Diagnosis more = diagnosed(measured(GetParam(), 16), {});
  EXPECT_EQ(to_string(more.verdict), "identified");
  ASSERT_EQ(more.found.size(), 1u);
  EXPECT_EQ(more.found[0].candidate.effect.kind->name, GetParam().kind);
  EXPECT_GE(more.found[0].probability, plain_.found[0].probability - 0.01);
  EXPECT_GT(more.found[0].length, 1.5 * plain_.found[0].length);
}

INSTANTIATE_TEST_SUITE_P(Effects, Rewritten, testing::Values(friction, play, little_play),
                         [](const auto& hidden) { return std::string(hidden.param.name); });

}  // namespace
}  // namespace kinetostat::calibration::rewritten_test

#include "kinetostat/vjm/workspace/workspace_map.h"

#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/vjm/chain/beam.h"
#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"

#include "support/temporary_folder.h"

namespace kinetostat::vjm::workspace_map_test {
namespace {

using spatial::Pose;
using spatial::Vector3;
using Kind = MapIndex::Kind;

Robot shipped(const std::string& name) {
  return read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/" + name);
}

// Three slides with springs, one after the other; nothing can turn.
Manipulator slides() {
  ChainBuilder chain("slides");
  chain.actuator("x", Motion::tx, 1e6)
      .actuator("y", Motion::ty, 2e6)
      .actuator("z", Motion::tz, 4e6);
  return {"slides", {chain.build()}};
}

TEST(WorkspaceMap, SpringsInSeriesHaveTheirClosedForm) {
  const std::vector<MapIndex> indices = {
      {.kind = Kind::stiffness, .direction = Vector3(1, 1, 0).normalized()},
      {.kind = Kind::weakest_translation},
      {.kind = Kind::rotational, .direction = Vector3::UnitZ()},
      {.kind = Kind::deflection}};
  const TargetPose target{Pose::translation({0.1, 0.2, 0.3}), {.force = {300, 0, 0}}};
  const MapPoint point = map_point(slides(), target, indices);
  EXPECT_EQ(point.state, MapState::reached);
  EXPECT_NEAR(point.values[0], 2 / (1 / 1e6 + 1 / 2e6), 1e-3);
  EXPECT_NEAR(point.values[1], 1e6, 1e-3);
  EXPECT_TRUE(std::isinf(point.values[2]));
  EXPECT_NEAR(point.values[3], 300 / 1e6, 1e-12);
}

// A robot that is rigid but for its two turning joints stands obliquely: rounding must not make its
// rigid directions yield, or unstable.
TEST(WorkspaceMap, RigidDirectionsStayRigidHoweverTheRobotStands) {
  const spatial::Matrix3 tilt =
      (Eigen::AngleAxisd(0.7, Vector3::UnitZ()) * Eigen::AngleAxisd(0.5, Vector3::UnitY()) *
       Eigen::AngleAxisd(0.3, Vector3::UnitX()))
          .toRotationMatrix();
  const double k1 = 2e5, k2 = 1e5, length = 0.4;
  for (const double q : {0.35, 1.0, 1.7}) {
    const auto at = [&](const spatial::Matrix3& base) {
      ChainBuilder chain("arm");
      chain.offset(Pose(base, Vector3::Zero()))
          .actuator("q1", Motion::rz, k1)
          .offset(Pose::translation({length, 0, 0}))
          .actuator("q2", Motion::rz, k2, q)
          .offset(Pose::translation({length, 0, 0}));
      return Manipulator("arm", {chain.build()});
    };
    // Both joints at the tool: J K^-1 J' of the plane.
    Eigen::Matrix2d j;
    j << -length * std::sin(q), -length * std::sin(q), length + length * std::cos(q),
        length * std::cos(q);
    const Eigen::Matrix2d c = j * Eigen::Vector2d(1 / k1, 1 / k2).asDiagonal() * j.transpose();
    const double weakest = 1 / Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(c).eigenvalues()[1];
    const Manipulator arm = at(tilt);
    const MapPoint point =
        map_point(arm, {posture_from_joints(arm, {}).posture.platform, {}},
                  {{.kind = Kind::weakest_translation},
                   {.kind = Kind::stiffness, .direction = tilt * Vector3::UnitZ()},
                   {.kind = Kind::rotational, .direction = tilt * Vector3::UnitX()},
                   {.kind = Kind::condition, .length = 0.1}});
    EXPECT_NEAR(point.values[0], weakest, 1e-9 * weakest);
    EXPECT_TRUE(std::isinf(point.values[1]));
    EXPECT_TRUE(std::isinf(point.values[2]));
    EXPECT_TRUE(std::isinf(point.values[3]));
  }
}

// A mass on a spring, sqrt(k/m); free where nothing holds it, none where there is none.
TEST(WorkspaceMap, FirstFrequencyIsThatOfTheMassOnItsSpring) {
  const auto on_a_slide = [](double mass, bool held) {
    ChainBuilder chain("slide");
    if (held)
      chain.actuator("x", Motion::tx, 4e6);
    else
      chain.passive("x", Motion::tx);
    if (mass > 0) chain.mass("load", mass, Vector3(0, 0, 0));
    return map_point({"slide", {chain.build()}}, {}, {{.kind = Kind::first_frequency}}).values[0];
  };
  EXPECT_NEAR(on_a_slide(100, true), 200 / (2 * std::acos(-1.)), 1e-9);
  EXPECT_EQ(on_a_slide(100, false), 0);
  EXPECT_TRUE(std::isinf(on_a_slide(0, true)));
}

// Spherical end joint: turning meets no resistance, forces through its centre do.
TEST(WorkspaceMap, FreeMotionSpoilsOnlyTheIndicesThatItMoves) {
  ChainBuilder chain("slides with a ball");
  chain.actuator("x", Motion::tx, 1e6).actuator("y", Motion::ty, 2e6);
  chain.actuator("z", Motion::tz, 4e6);
  chain.passive("a", Motion::rx).passive("b", Motion::ry).passive("c", Motion::rz);
  const MapPoint point = map_point({"ball", {chain.build()}}, {},
                                   {{.kind = Kind::weakest_translation},
                                    {.kind = Kind::weakest_rotation},
                                    {.kind = Kind::weakest, .length = 0.1},
                                    {.kind = Kind::condition, .length = 0.1}});
  EXPECT_EQ(point.state, MapState::free_motion);
  EXPECT_NEAR(point.values[0], 1e6, 1e-3);
  EXPECT_EQ(point.values[1], 0);
  EXPECT_EQ(point.values[2], 0);
  EXPECT_TRUE(std::isinf(point.values[3]));
}

TEST(WorkspaceMap, ScaledIndicesAreEigenvaluesOfADiagonalStiffness) {
  ChainBuilder chain("six springs");
  const double translation[] = {1e6, 2e6, 3e6}, rotation[] = {1e4, 2e4, 5e4};
  for (int i = 0; i < 3; ++i)
    chain.actuator("t" + std::to_string(i), static_cast<Motion>(i), translation[i]);
  for (int i = 0; i < 3; ++i)
    chain.actuator("r" + std::to_string(i), static_cast<Motion>(3 + i), rotation[i]);
  // Rotations times 0.05 m: 1e4/0.05^2 = 4e6 N/m is the softest of them, 2e7 N/m the stiffest.
  const MapPoint point = map_point({"six", {chain.build()}}, {},
                                   {{.kind = Kind::weakest, .length = 0.05},
                                    {.kind = Kind::condition, .length = 0.05},
                                    {.kind = Kind::weakest_rotation}});
  EXPECT_NEAR(point.values[0], 1e6, 1e-3);
  EXPECT_NEAR(point.values[1], 20, 1e-9);
  EXPECT_NEAR(point.values[2], 1e4, 1e-6);
}

TEST(WorkspaceMap, StiffnessUnderLoadIsTheSlopeOfTheNonlinearDeflection) {
  const Robot robot = shipped("orthoglide.yaml");
  const Vector3 direction = Vector3(1, -2, 0.5).normalized();
  const Pose pose = Pose::translation({0.02, -0.03, 0.05});
  const Vector3 force(800, -200, 300);
  const MapPoint point =
      map_point(robot.manipulator, {pose, {.force = force}},
                {{.kind = Kind::stiffness, .direction = direction}, {.kind = Kind::rotation}});
  const Posture posture = posture_at(robot.manipulator, pose).posture;
  const double step = 1;
  const auto moved = [&](double extra) {
    return equilibrium_under_load(robot.manipulator, posture, {.force = force + extra * direction});
  };
  const double slope =
      direction.dot(moved(step).displacement.translation - moved(-step).displacement.translation) /
      (2 * step);
  EXPECT_NEAR(point.values[0], 1 / slope, 1e-6 / slope);
  EXPECT_NEAR(point.values[1], moved(0).displacement.rotation.norm(), 1e-14);
}

TEST(WorkspaceMap, UnreachablePosesAreFlagged) {
  const Robot robot = shipped("orthoglide.yaml");
  const MapPoint point = map_point(robot.manipulator, {Pose::translation({5, 0, 0})},
                                   {{.kind = Kind::weakest_translation}});
  EXPECT_EQ(point.state, MapState::unreachable);
  EXPECT_TRUE(std::isnan(point.values[0]));
}

TEST(WorkspaceMap, LoadThatNothingResistsIsFlagged) {
  const Robot robot = shipped("stewart_gough_a.yaml");
  const MapPoint point =
      map_point(robot.manipulator, {Pose::translation({0, 0, 0.6}), {.moment = {0, 0, 10}}},
                {{.kind = Kind::weakest_translation}});
  EXPECT_EQ(point.state, MapState::no_equilibrium);
  EXPECT_TRUE(std::isnan(point.values[0]));
}

// A straight pair of rods with a spring in the knee, pushed with more than it can hold.
TEST(WorkspaceMap, UnstableEquilibriumIsFlagged) {
  ChainBuilder chain("knee");
  chain.actuator("knee", Motion::rz, 100).offset(Pose::translation({1, 0, 0}));
  const auto state = [&](double push) {
    return map_point({"rod", {chain.build()}},
                     {Pose::translation({1, 0, 0}), {.force = {-push, 0, 0}}},
                     {{.kind = Kind::weakest_translation}})
        .state;
  };
  EXPECT_EQ(state(99), MapState::reached);
  EXPECT_EQ(state(101), MapState::unstable);
}

std::vector<TargetPose> cube(int n) {
  std::vector<TargetPose> targets;
  for (int i = 0; i < n * n * n; ++i)
    targets.push_back({Pose::translation({-0.05 + 0.1 * (i % n) / n, -0.05 + 0.1 * (i / n % n) / n,
                                          -0.05 + 0.1 * (i / n / n) / n})});
  return targets;
}

const std::vector<MapIndex> two_indices = {{.kind = Kind::weakest_translation},
                                           {.kind = Kind::condition, .length = 0.1}};

bool same(const std::vector<MapPoint>& a, const std::vector<MapPoint>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i].state != b[i].state || a[i].values != b[i].values) return false;
  return true;
}

// A pendulum that a hinge with a spring keeps upright falls at k/L, pushed towards the hinge, and
// never when pulled. A weight above it takes its share.
TEST(WorkspaceMap, CriticalForceOfAPropIsItsSpringOverItsLength) {
  ChainBuilder chain("prop");
  chain.actuator("hinge", Motion::rz, 300.0).offset(Pose::translation({0.4, 0, 0})).node("top");
  const MapIndex push{.kind = Kind::critical_force, .direction = -Vector3::UnitX(), .up_to = 2000};
  MapIndex pull = push, near = push;
  pull.direction = Vector3::UnitX();
  near.up_to = 700;
  const TargetPose upright{Pose::translation({0.4, 0, 0})};
  const MapPoint point = map_point({"prop", {chain.build()}}, upright, {push, pull, near});
  EXPECT_NEAR(point.values[0], 300 / 0.4, 1e-8 * 750);
  EXPECT_TRUE(std::isinf(point.values[1]));
  EXPECT_TRUE(std::isinf(point.values[2]));
  const Load pushed{
      .nodes = {{.chain = 0, .node = chain.so_far().node_index("top"), .force = {-250, 0, 0}}}};
  EXPECT_NEAR(map_point({"prop", {chain.build()}}, {upright.platform, pushed}, {push}).values[0],
              500, 1e-8 * 750);
  EXPECT_THROW(
      map_point({"prop", {chain.build()}}, {upright.platform, {.force = {1, 0, 0}}}, {push}),
      std::invalid_argument);
}

// One cantilever spring does not feel its own beam buckle under a dead load at its end: Euler's
// pi^2 E I / 4 L^2 is found with finer segments only.
TEST(WorkspaceMap, ASlenderBeamBucklesAtEulersLoad) {
  constexpr double length = 1;
  Section section;
  section.area = 2e-4;
  section.second_moment_y = section.second_moment_z = 1.6667e-9;
  section.torsion_constant = 2e-9;
  const Material steel{210e9, 80e9, std::nullopt};
  const double euler = M_PI * M_PI / 4 * 210e9 * section.second_moment_z / (length * length);
  const auto beam = [&](int segments) {
    ChainBuilder chain("beam");
    const spatial::Compliance6 piece(
        beam_compliance(length / segments, section, steel, BeamTheory::euler_bernoulli).matrix());
    for (int i = 0; i < segments; ++i)
      chain.link("l" + std::to_string(i), Pose::translation({length / segments, 0, 0}), piece);
    return Manipulator("beam", {chain.build()});
  };
  const std::vector<Manipulator> finer{beam(2), beam(4)};
  const TargetPose end{Pose::translation({length, 0, 0})};
  const MapIndex push{
      .kind = Kind::critical_force, .direction = -Vector3::UnitX(), .up_to = 10 * euler};
  EXPECT_TRUE(std::isinf(map_point(beam(1), end, {push}).values[0]));
  // Richardson from two and four segments is left with their higher orders.
  EXPECT_NEAR(map_point(beam(1), end, {push}, finer).values[0], euler, 0.02 * euler);
  const auto state = [&](double share) {
    return map_point(beam(1), {end.platform, {.force = {-share * euler, 0, 0}}},
                     {{.kind = Kind::deflection}}, finer)
        .state;
  };
  EXPECT_EQ(state(0.9), MapState::reached);
  EXPECT_EQ(state(1.5), MapState::unstable);
}

TEST(WorkspaceMap, ResultDoesNotDependOnTheNumberOfThreads) {
  const Robot robot = shipped("orthoglide.yaml");
  common::Progress progress;
  const auto one = workspace_map(robot.manipulator, cube(6), two_indices, 1, progress);
  EXPECT_TRUE(same(one, workspace_map(robot.manipulator, cube(6), two_indices, 3, progress)));
}

// Cancels when it has been asked a few times.
class Impatient : public common::Progress {
 public:
  explicit Impatient(int patience) : patience_(patience) {}
  bool cancelled() const override { return --patience_ < 0; }

 private:
  mutable int patience_;
};

class MapCheckpoints : public testing::Test {
 protected:
  Robot robot = shipped("orthoglide.yaml");
  test::TemporaryFolder folder;
  std::filesystem::path file = folder.path() / "map.part";
  common::Progress calm;

  MapCheckpoint checkpoint(const std::string& request = "abc") const {
    return {.file = file, .request = request};
  }
  void interrupt() {
    Impatient impatient(1);
    MapCheckpoint begun = checkpoint();
    EXPECT_THROW(workspace_map(robot.manipulator, cube(6), two_indices, 2, impatient, &begun),
                 common::Cancelled);
    ASSERT_TRUE(std::filesystem::exists(file));
  }
  void expect_refused(const MapCheckpoint& other, const std::string& message) {
    MapCheckpoint copy = other;
    try {
      workspace_map(robot.manipulator, cube(6), two_indices, 1, calm, &copy);
      FAIL() << "accepted";
    } catch (const common::InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(message));
    }
  }
};

TEST_F(MapCheckpoints, InterruptedMapGoesOnToTheSameResult) {
  interrupt();
  MapCheckpoint resumed = checkpoint();
  const auto points = workspace_map(robot.manipulator, cube(6), two_indices, 1, calm, &resumed);
  EXPECT_GT(resumed.found, 0u);
  EXPECT_LT(resumed.found, points.size());
  EXPECT_TRUE(same(points, workspace_map(robot.manipulator, cube(6), two_indices, 1, calm)));
  EXPECT_FALSE(std::filesystem::exists(file));
}

TEST_F(MapCheckpoints, OfAnotherMapIsRefused) {
  interrupt();
  expect_refused(checkpoint("xyz"), "belongs to another robot");
}

TEST_F(MapCheckpoints, DamagedIsRefusedWithItsLine) {
  interrupt();
  const std::string text = io::read_text(file);
  const auto expect_noticed = [&](const std::string& damaged) {
    std::ofstream(file) << damaged;
    expect_refused(checkpoint(), "was damaged");
  };
  expect_noticed(text.substr(0, text.size() - 4));
  expect_noticed(text + "0 1 x\n");
  expect_noticed(text + text.substr(text.rfind('\n', text.size() - 2) + 1));
  std::ofstream(file) << text.substr(0, 40);
  expect_refused(checkpoint(), "ends in the middle of a line");
}

// A checkpoint of sound numbers that are not those of this map would end as a wrong map.
TEST_F(MapCheckpoints, EveryDigitCounts) {
  interrupt();
  const std::string text = io::read_text(file);
  const std::size_t points = text.size() - text.size() / 2;
  int flipped = 0;
  for (std::size_t i = points; i < text.size() && flipped < 20; ++i) {
    if (text[i] < '1' || text[i] > '8') continue;
    std::string other = text;
    ++other[i];
    std::ofstream(file) << other;
    expect_refused(checkpoint(), "was damaged");
    ++flipped;
  }
  EXPECT_EQ(flipped, 20);
}

TEST_F(MapCheckpoints, OfAnOlderVersionIsRefused) {
  std::ofstream(file) << "kinetostat map checkpoint 1\nabc 216 poses\n0 1 1\n";
  expect_refused(checkpoint(), "older version");
}

TEST(WorkspaceMap, RangeLeavesOutWhatIsNotFinite) {
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<MapPoint> points = {{MapState::reached, {3}},
                                        {MapState::unreachable, {std::nan("")}},
                                        {MapState::free_motion, {infinity}},
                                        {MapState::reached, {1}}};
  const MapRange range = range_of(points, 0);
  EXPECT_EQ(range.count, 2u);
  EXPECT_EQ(range.smallest, 1);
  EXPECT_EQ(range.smallest_at, 3u);
  EXPECT_EQ(range.largest, 3);
  EXPECT_EQ(range.mean, 2);
}

}  // namespace
}  // namespace kinetostat::vjm::workspace_map_test

#include "kinetostat/report/manipulators/manipulator.h"

#include <cmath>

#include <gtest/gtest.h>

#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::report::manipulator_test {
namespace {

using spatial::Pose;
using spatial::Vector6;

// K_q and K_theta of a loaded robot with closed loops, by name, against differences of equilibria.
TEST(MotionOfCoordinates, IsTheDerivativeByTheDisplacement) {
  const vjm::Robot robot =
      vjm::read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/orthoglide.yaml");
  const vjm::Posture posture =
      vjm::posture_at(robot.manipulator, Pose::translation({0.03, -0.02, 0.05})).posture;
  const vjm::Load load{.force = {200, -100, 300}, .moment = {5, 10, -5}};
  const vjm::Equilibrium e = vjm::equilibrium_under_load(robot.manipulator, posture, load);
  ASSERT_EQ(e.status, vjm::EquilibriumStatus::converged);
  const io::Json chains = to_json(robot, e)["chains"];
  const double h = 1e-7;
  std::size_t compared = 0;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const auto coordinates = [&](double step) {
      const Pose pose = spatial::displaced(e.platform, step * Vector6::Unit(k));
      return to_json(robot, equilibrium_at_pose(robot.manipulator, posture, pose))["chains"];
    };
    const io::Json after = coordinates(h), before = coordinates(-h);
    for (std::size_t c = 0; c < chains.size(); ++c) {
      const io::Json& motion = chains[c]["coordinates_by_displacement"];
      for (const char* part : {"K_q", "K_theta"})
        for (const auto& [name, row] : motion[part].items()) {
          const double slope = (after[c]["coordinates"][name].get<double>() -
                                before[c]["coordinates"][name].get<double>()) /
                               (2 * h);
          EXPECT_NEAR(row[static_cast<std::size_t>(k)].get<double>(), slope,
                      1e-5 * (1 + std::abs(slope)))
              << chains[c]["name"] << " " << part << " " << name;
          ++compared;
        }
    }
  }
  std::size_t all = 0;
  for (const vjm::Chain& chain : robot.manipulator.chains()) all += 6 * chain.coordinates().size();
  EXPECT_EQ(compared, all);
}

TEST(MotionOfCoordinates, NamesEachCoordinateWithItsUnit) {
  const vjm::Robot robot =
      vjm::read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/orthoglide.yaml");
  const vjm::Posture posture = vjm::posture_at(robot.manipulator, Pose()).posture;
  const vjm::Equilibrium e =
      vjm::equilibrium_under_load(robot.manipulator, posture, {.force = {100, 0, 0}});
  const io::Json motion = to_json(robot, e)["chains"][0]["coordinates_by_displacement"];
  EXPECT_TRUE(motion["K_q"].contains("u1.Rz"));
  EXPECT_TRUE(motion["K_theta"].contains("rho"));
  EXPECT_FALSE(motion["K_q"].contains("rho"));
  EXPECT_EQ(motion["units"]["u1.Rz"], "rad");
  EXPECT_EQ(motion["units"]["rho"], "m");
  EXPECT_EQ(motion["order"][3], "rx");
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(motion["point"][i].get<double>(), e.platform.position()[static_cast<int>(i)],
                1e-12);
}

// One spring in space: the chain is rigid in five directions, and has no such matrices.
TEST(MotionOfCoordinates, IsNullWhereAChainIsRigid) {
  const vjm::Robot robot =
      vjm::read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/bench.yaml");
  const vjm::Posture posture = vjm::posture_from_joints(robot.manipulator, {}).posture;
  const vjm::Equilibrium e =
      vjm::equilibrium_under_load(robot.manipulator, posture, {.force = {0, 0, 100}});
  ASSERT_EQ(e.status, vjm::EquilibriumStatus::converged);
  EXPECT_TRUE(to_json(robot, e)["chains"][0]["coordinates_by_displacement"].is_null());
}

}  // namespace
}  // namespace kinetostat::report::manipulator_test

// Newton's method allocates nothing inside its loop: a solution that takes more corrections takes
// no more memory. All allocations are counted, Eigen's included.
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"

#if defined(__SANITIZE_ADDRESS__) || !defined(__GLIBC__)
#define KINETOSTAT_COUNTS_ALLOCATIONS 0
#else
#define KINETOSTAT_COUNTS_ALLOCATIONS 1
#endif

namespace {
thread_local long allocations = 0;
}

#if KINETOSTAT_COUNTS_ALLOCATIONS
extern "C" void* __libc_malloc(std::size_t size);  // NOLINT: glibc's name
extern "C" void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
#endif

namespace kinetostat::vjm::allocation_test {
namespace {

struct Cost {
  long allocations = 0;
  std::size_t corrections = 0;
  int steps = 0;
};

template <class Solve>
Cost cost_of(const Solve& solve) {
  const long before = allocations;
  const Equilibrium e = solve();
  const long used = allocations - before;
  EXPECT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
  return {used, e.corrections.size(), e.steps};
}

void expect_no_more(const Cost& little, const Cost& much) {
#if !KINETOSTAT_COUNTS_ALLOCATIONS
  GTEST_SKIP() << "allocations are the sanitizer's here";
#endif
  ASSERT_EQ(little.steps, 1);
  ASSERT_EQ(much.steps, 1);
  ASSERT_GT(much.corrections, little.corrections);
  EXPECT_GT(little.allocations, 0);
  EXPECT_EQ(much.allocations, little.allocations);
}

Robot shipped(const std::string& name) {
  return read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/" + name);
}

TEST(Allocation, NewtonsLoopAllocatesNothingAtAPose) {
  const Robot robot = shipped("orthoglide.yaml");
  const Posture posture = posture_at(robot.manipulator, {}).posture;
  const auto cost = [&](double shift) {
    const auto target = spatial::Pose::translation({shift, shift, shift});
    return cost_of([&] { return equilibrium_at_pose(robot.manipulator, posture, target); });
  };
  expect_no_more(cost(1e-7), cost(1e-3));
}

// A robot, and a load so large that Newton's method has something to do.
struct LoadedRobot {
  const char* file;
  double factor;
};
class AllocationUnderLoad : public ::testing::TestWithParam<LoadedRobot> {};

TEST_P(AllocationUnderLoad, NewtonsLoopAllocatesNothing) {
  const Robot robot = shipped(GetParam().file);
  const Posture posture = posture_from_joints(robot.manipulator, {}).posture;
  const auto cost = [&](double factor) {
    const Load load{.force = factor * spatial::Vector3(300, -200, -400), .gravity = factor};
    return cost_of([&] { return equilibrium_under_load(robot.manipulator, posture, load); });
  };
  expect_no_more(cost(1e-5), cost(GetParam().factor));
}
INSTANTIATE_TEST_SUITE_P(SerialParallelAndMechanisms, AllocationUnderLoad,
                         ::testing::Values(LoadedRobot{"six_axis.yaml", 1},
                                           LoadedRobot{"translational_3puu.yaml", 1},
                                           LoadedRobot{"delta.yaml", 1},
                                           LoadedRobot{"heavy_arm.yaml", 30}),
                         [](const auto& test) { return std::string(test.param.file, 4); });

}  // namespace
}  // namespace kinetostat::vjm::allocation_test

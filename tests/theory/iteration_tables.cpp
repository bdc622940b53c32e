// Newton's method beside the papers' fixed-point iterations.
#include <cmath>

#include <fmt/format.h>

#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/fixed_point.h"

#include "tables.h"

namespace kinetostat::theory {
namespace {

using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;
using vjm::Equilibrium;
using vjm::EquilibriumStatus;
using vjm::FixedPoint;

std::string newton_text(const Equilibrium& e) {
  if (e.status != EquilibriumStatus::converged)
    return fmt::format("fails at {:.0f} %", 100 * e.reached);
  return fmt::format("{} in {} step{}{}", e.corrections.size(), e.steps, e.steps == 1 ? "" : "s",
                     e.held.stable() ? "" : ", unstable");
}

std::string fixed_text(const FixedPoint& f) {
  return f.converged ? fmt::format("{}", f.iterations)
                     : fmt::format("fails at {:.0f} %", 100 * f.reached);
}

vjm::FixedPointOptions in_steps(int steps) { return {.tolerance = 1e-10, .load_steps = steps}; }

}  // namespace

std::string iterations_at_a_pose() {
  const vjm::Robot robot = shipped("orthoglide.yaml");
  std::vector<std::vector<std::string>> rows;
  for (const std::size_t point : {0, 1, 2})
    for (const double shift : {0.1, 0.5, 1.0, 2.0, 5.0}) {
      const vjm::Posture posture =
          posture_at(robot.manipulator, Pose::translation(orthoglide_points[point].position))
              .posture;
      Vector6 d = Vector6::Zero();
      d.head<3>().setConstant(1e-3 * shift);
      const Pose target = spatial::displaced(posture.platform, d);
      rows.push_back(
          {orthoglide_points[point].name, fmt::format("{}", shift),
           newton_text(equilibrium_at_pose(robot.manipulator, posture, target)),
           fixed_text(fixed_point_at_pose(robot.manipulator, posture, target, in_steps(1))),
           fixed_text(fixed_point_at_pose(robot.manipulator, posture, target, in_steps(10)))});
    }
  return markdown(
      {"point", "shift on each axis [mm]", "Newton", "eq. 10 at once", "eq. 10 in 10 steps"}, rows);
}

std::string iterations_under_a_load() {
  const vjm::Robot robot = shipped("orthoglide.yaml");
  std::vector<std::vector<std::string>> rows;
  for (const std::size_t point : {0, 1, 2})
    for (const double force : {100.0, 500.0, 1000.0, 2000.0}) {
      const vjm::Posture posture =
          posture_at(robot.manipulator, Pose::translation(orthoglide_points[point].position))
              .posture;
      const vjm::Load load{.force = Vector3(force, -0.5 * force, 0.3 * force)};
      rows.push_back(
          {orthoglide_points[point].name, fmt::format("{:.0f}", force),
           newton_text(equilibrium_under_load(robot.manipulator, posture, load)),
           fixed_text(fixed_point_under_load(robot.manipulator, posture, load, in_steps(1))),
           fixed_text(fixed_point_under_load(robot.manipulator, posture, load, in_steps(10)))});
    }
  return markdown(
      {"point", "force (1, -0.5, 0.3) times [N]", "Newton", "eq. 11 at once", "eq. 11 in 10 steps"},
      rows);
}

}  // namespace kinetostat::theory

#include "kinetostat/apps/segment_check.h"

#include <tuple>

#include <fmt/format.h>

namespace kinetostat::apps {

std::optional<double> lumping_error(const vjm::Robot& robot, const PostureRequest& posture,
                                    const LoadRequest& load, const vjm::Equilibrium& found) {
  if (!robot.has_beams || found.status != vjm::EquilibriumStatus::converged) return std::nullopt;
  const vjm::Robot finer = vjm::read_robot(posture.robot_file, {.segment_multiple = 2});
  const vjm::Equilibrium again = load.solve(finer, posture.posture(finer));
  if (again.status != vjm::EquilibriumStatus::converged) return std::nullopt;
  const bool held = load.task(robot).platform_held;
  const auto size_and_change = [](const spatial::Vector3& a, const spatial::Vector3& b) {
    return std::pair(b.norm(), (a - b).norm());
  };
  auto [size, change] =
      held ? size_and_change(found.wrench.force, again.wrench.force)
           : size_and_change(found.displacement.translation, again.displacement.translation);
  if (size == 0)
    std::tie(size, change) =
        held ? size_and_change(found.wrench.moment, again.wrench.moment)
             : size_and_change(found.displacement.rotation, again.displacement.rotation);
  if (size == 0) return std::nullopt;
  return 4.0 / 3 * change / size;
}

std::string lumping_text(const vjm::Robot& robot, const std::optional<double>& error) {
  if (!error) return "";
  if (*error > 0.01)
    return fmt::format(
        "warning: lumped springs misstate this by about {:.2g} %: give the beams more 'segments'\n",
        100 * *error);
  if (robot.manipulator.gravity().isZero(0)) return "";
  return fmt::format("Lumping of springs and weight along the beams: about {:.2g} % of this.\n",
                     100 * *error);
}

}  // namespace kinetostat::apps

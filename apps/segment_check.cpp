#include "kinetostat/apps/segment_check.h"

#include <fmt/format.h>

#include "kinetostat/vjm/segments.h"

namespace kinetostat::apps {

std::optional<double> lumping_error(const vjm::Robot& robot, const PostureRequest& posture,
                                    const LoadRequest& load, const vjm::Equilibrium& found) {
  if (!robot.has_beams || found.status != vjm::EquilibriumStatus::converged) return std::nullopt;
  const vjm::Robot finer = vjm::read_robot(posture.robot_file, {.segment_multiple = 2});
  const vjm::Equilibrium again = load.solve(finer, posture.posture(finer));
  return vjm::lumping_error(found, again, load.task(robot).platform_held);
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

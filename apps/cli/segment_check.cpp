#include "kinetostat/apps/cli/segment_check.h"

#include <fmt/format.h>

#include "kinetostat/vjm/statics/segments.h"

namespace kinetostat::apps {

SegmentCheck check_segments(const vjm::Robot& robot, const PostureRequest& posture,
                            const LoadRequest& load, vjm::Equilibrium& found) {
  SegmentCheck check;
  if (!robot.has_beams || found.status != vjm::EquilibriumStatus::converged) return check;
  const bool held = load.task(robot).platform_held;
  const auto solved_with = [&](int multiple) {
    const vjm::Robot finer = vjm::read_robot(posture.robot_file, {.segment_multiple = multiple});
    return load.solve(finer, posture.posture(finer));
  };
  check.lumping_error = vjm::lumping_error(found, solved_with(2), held);
  check.hidden_buckling =
      take_stability(solved_with(SegmentCheck::stability_multiple), held, found);
  return check;
}

std::string SegmentCheck::text(const vjm::Robot& robot) const {
  std::string out;
  if (hidden_buckling)
    out += fmt::format(
        "warning: a beam buckles that one spring keeps straight: with {} times the segments this "
        "equilibrium is unstable\n",
        stability_multiple);
  if (!lumping_error) return out;
  if (*lumping_error > 0.01)
    return out + fmt::format(
                     "warning: lumped springs misstate this by about {:.2g} %: give the "
                     "beams more 'segments'\n",
                     100 * *lumping_error);
  if (robot.manipulator.gravity().isZero(0)) return out;
  return out + fmt::format(
                   "Lumping of springs and weight along the beams: about {:.2g} % of "
                   "this.\n",
                   100 * *lumping_error);
}

void SegmentCheck::add_to(io::Json& json) const {
  json["lumping_error"] = lumping_error ? io::Json(*lumping_error) : io::Json();
  json["hidden_buckling"] = hidden_buckling;
}

}  // namespace kinetostat::apps

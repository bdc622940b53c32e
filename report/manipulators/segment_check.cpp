#include "kinetostat/report/manipulators/segment_check.h"

#include <fmt/format.h>

namespace kinetostat::report {

std::string text(const vjm::Robot& robot, const vjm::SegmentCheck& check) {
  std::string out;
  if (check.hidden_buckling)
    out += fmt::format(
        "warning: a beam buckles that one spring keeps straight: with {} times the segments this "
        "equilibrium is unstable\n",
        vjm::SegmentCheck::stability_multiple);
  if (!check.lumping_error) return out;
  const double error = *check.lumping_error;
  if (error > 0.01)
    return out + fmt::format(
                     "warning: lumped springs misstate this by about {:.2g} %: give the beams more "
                     "'segments'\n",
                     100 * error);
  if (robot.manipulator.gravity().isZero(0)) return out;
  return out +
         fmt::format("Lumping of springs and weight along the beams: about {:.2g} % of this.\n",
                     100 * error);
}

void add_to(io::Json& json, const vjm::SegmentCheck& check) {
  json["lumping_error"] = check.lumping_error ? io::Json(*check.lumping_error) : io::Json();
  json["hidden_buckling"] = check.hidden_buckling;
}

}  // namespace kinetostat::report

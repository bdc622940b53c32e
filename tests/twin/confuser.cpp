#include "confuser.h"

#include <algorithm>
#include <stdexcept>

namespace twin {
namespace {

std::vector<HiddenEffect> all_effects(const RobotSpec& robot) {
  std::vector<HiddenEffect> all{{"base_compliance", "base"},     {"platform_compliance", "end"},
                                {"payload", "platform"},         {"wrench_gain", "load"},
                                {"wrench_misalignment", "load"}, {"application_point", "load"},
                                {"target_lever_arm", "sensor"},  {"sensor_frame", "sensor"},
                                {"session_drift", "sensor"}};
  for (const ChainSpec& chain : robot.chains)
    for (const Item& item : chain.items) {
      const std::string at = robot.place(chain, item);
      if (item.kind == Item::actuator)
        for (const char* name :
             {"friction", "clearance", "hardening", "piecewise_stiffness", "creep", "preload",
              "eccentricity", "bearing_compliance", "geometric_error"})
          all.push_back({name, at});
      if (item.kind == Item::actuator && item.axes[0] >= 3)
        all.push_back({"gravity_compensator", at});
      if (item.kind == Item::link)
        for (const char* name : {"thermal_expansion", "self_weight"}) all.push_back({name, at});
    }
  std::stable_partition(all.begin(), all.end(),
                        [](const HiddenEffect& e) { return !remembers_loads(e); });
  return all;
}

// Orthonormal columns that span all signatures but those that are seen only as a difference of
// others, twenty times as large.
Eigen::MatrixXd span_of(const std::vector<Eigen::VectorXd>& marks) {
  Eigen::MatrixXd span(marks.empty() ? 0 : marks.front().size(), 0);
  for (const Eigen::VectorXd& mark : marks) {
    Eigen::VectorXd left = mark.normalized();
    for (int twice = 0; twice < 2; ++twice) left -= (span * (span.transpose() * left)).eval();
    if (left.norm() < 0.05) continue;
    span.conservativeResize(Eigen::NoChange, span.cols() + 1);
    span.rightCols<1>() = left.normalized();
  }
  return span;
}

}  // namespace

Confuser confuser_of(const HiddenEffect& effect, World world, const Plan& plan, double enough) {
  // d': what is smaller at its usual size counts as it looks at ten times that.
  constexpr double visible = 1, least_visible = 0.1;
  world.elements = 1;
  world.effects.clear();
  const Responses base = respond(world, plan, true);
  const Whitened whitened(plan, base, stated_noise(world.robot, base));
  const auto mark_of = [&](const HiddenEffect& hidden) -> Eigen::VectorXd {
    world.effects = {hidden};
    return whitened.mark_of(respond(world, plan, false));
  };
  const Eigen::VectorXd mark = mark_of(effect).normalized();
  Confuser worst;
  for (const HiddenEffect& other : all_effects(world.robot)) {
    if (other.name == effect.name && other.at == effect.at) continue;
    for (const std::vector<HiddenEffect>& looks : looks_of(world.robot, other)) {
      std::vector<Eigen::VectorXd> marks;
      for (HiddenEffect look : looks) {
        try {
          Eigen::VectorXd m = mark_of(look);
          if (m.norm() < visible) {
            look.size *= 10;
            m = mark_of(look);
          }
          if (m.norm() > least_visible) marks.push_back(m);
        } catch (const std::runtime_error&) {  // so large that the robot collapses: not hidden
        }
      }
      if (marks.empty()) continue;
      const double cosine = (span_of(marks).transpose() * mark).norm();
      if (cosine > worst.cosine) worst = {other.name + " at " + other.at, cosine};
      if (worst.cosine > enough) return worst;
    }
  }
  return worst;
}

}  // namespace twin

// Every kind of effect at a place of two robots, with values that a machine may have.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "kinetostat/vjm/effects/effect_model.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::vjm::test {

inline Robot shipped(const std::string& name) {
  return read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/" + name);
}

inline Effect effect(const Manipulator& m, const std::string& kind, const std::string& at,
                     std::vector<double> values) {
  Effect result{.kind = effect_kind(kind), .at = at, .sites = {}, .values = {}};
  result.sites = effect_sites(*result.kind, m, at);
  result.values =
      Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  return result;
}

/// Whether an effect of this kind acts without load, too: it is not observable in differences to
/// the unloaded robot, but in poses.
inline bool displaces_without_load(const std::string& kind) {
  static const std::set<std::string> kinds = {
      "geometric_error",  "thermal_expansion", "eccentricity",        "preload",
      "self_weight",      "payload",           "gravity_compensator", "sensor_frame",
      "target_lever_arm", "session_drift",     "transmission_ratio",  "joint_offset"};
  return kinds.contains(kind);
}

/// A robot on which effects are tried, and loads that suit it.
struct Bench {
  std::string name;
  Manipulator manipulator;
  Posture posture;
  double force, moment;  // [N], [N m]
  std::vector<Effect> effects;
};

/// Three translations in a plane-free space, closed loops, light links.
inline Bench parallel_bench() {
  const Manipulator m = shipped("orthoglide.yaml").manipulator.with_gravity({0, 0, -9.81});
  const auto make = [&m](const char* kind, const char* at, std::vector<double> values) {
    return effect(m, kind, at, std::move(values));
  };
  return {"orthoglide",
          m,
          posture_at(m, spatial::Pose::translation({0.05, -0.03, 0.02})).posture,
          300,
          10,
          {make("joint_compliance", "x.rho", {2e-8}),
           make("link_compliance", "leg", {1.3}),
           make("bearing_compliance", "x.rho", {1e-8, 0, 2e-7}),
           make("bearing_compliance", "y.u1.Ry", {2e-8, 1e-8, 3e-6}),
           make("bearing_tilt", "z.rho", {1e-7, 3e-7, 2e-7}),
           make("bearing_tilt", "y.u1.Ry", {3e-6, 0, 2e-6}),
           make("base_compliance", "z.base", {1e-8, 3e-7}),
           make("base_tilt", "z.base", {3e-7, 1e-7, 2e-7}),
           make("platform_compliance", "end", {2e-8, 1e-6}),
           make("geometric_error", "y.foot", {1e-4, -2e-4, 1.5e-4, 4e-4, -3e-4, 2e-4}),
           make("thermal_expansion", "leg", {2.3e-5, 21, 15, 0}),
           make("eccentricity", "rho", {4e-6, -3e-6, 600}),
           make("transmission_ratio", "y.rho", {4e-5}),
           make("joint_offset", "x.rho", {3e-5}),
           make("creep", "x.rho", {5e-9, 300, 0}),
           make("hardening", "y.rho", {5e19}),
           make("load_hardening", "y.rho", {1e-12}),
           make("piecewise_stiffness", "x.rho", {1.5, 2, 60, 150}),
           make("directional_stiffness", "x.rho", {1.6}),
           make("opening_contact", "y.rho", {2.5, 60}),
           make("opening_contact", "z.rho", {1.8, -50}),
           make("periodic_stiffness", "x.rho", {0.2, -0.3, 600}),
           make("stiffness_along_joint", "rho", {-2}),
           make("thermal_softening", "y.rho", {0.01, 18, 10}),
           make("clearance", "z.rho", {2e-6, 0}),
           make("biased_clearance", "y.rho", {2e-6, 40, 1}),
           make("friction", "x.rho", {40, 3e-7, 0, 0}),
           make("load_friction", "x.rho", {0.2, 3e-7, 0, 0}),
           make("friction", "y.u1.Rz", {0.02, 1e-6, 0, 1}),
           make("preload", "z.rho", {50}),
           make("gravity_compensator", "x.u1.Rz", {2e3, 0.05, 0.2, 0.12, 0.4}),
           make("self_weight", "y.leg", {3}),
           make("payload", "platform", {5, 0.02, 0.01, -0.03}),
           make("wrench_gain", "load", {1.05}),
           make("wrench_misalignment", "load", {0.03, -0.02, 0.04}),
           make("wrench_zero", "load", {20, -30, 10, 2, 3, -4, 0}),
           make("wrench_channel_gain", "load", {0.05, -0.03, 0.02, 0.04, -0.02, 0.03}),
           make("wrench_saturation", "load", {2e-7, 3e-6}),
           make("application_point", "load", {2e-3, -3e-3, 1e-3}),
           make("sensor_frame", "sensor", {1e-3, 2e-3, -1e-3, 0.02, -0.01, 0.03}),
           make("sensor_scale", "sensor", {2e-3}),
           make("sensor_axis_scale", "sensor", {2e-3, -1e-3, 3e-3}),
           make("target_lever_arm", "sensor", {0.03, -0.02, 0.05}),
           make("session_drift", "sensor", {3e-9, -2e-9, 1e-9, 4e-9, 2e-9, -1e-9, 0.7}),
           make("gauge_play", "sensor", {3e-6, 2e-6, 4e-6, 1e-5, 2e-5, 1e-5}),
           make("target_slip", "sensor", {2e-6, -1e-6, 3e-6, 1e-5, -2e-5, 1e-5, 1, 2000, 1, 0}),
           make("cycle_offset", "sensor", {2e-6, -1e-6, 3e-6, 1e-5, -2e-5, 1e-5, 3})}};
}

/// A heavy arm whose chains start from moving bodies, under its own weight.
inline Bench arm_bench() {
  const Manipulator m = shipped("heavy_arm.yaml").manipulator;
  const auto make = [&m](const char* kind, const char* at, std::vector<double> values) {
    return effect(m, kind, at, std::move(values));
  };
  return {"heavy arm",
          m,
          posture_from_joints(m, {}).posture,
          1500,
          300,
          {make("joint_compliance", "arm.q3", {2e-7}),
           make("link_compliance", "forearm", {1.4}),
           make("bearing_compliance", "arm.q4", {1e-8, 2e-8, 1e-7}),
           make("bearing_compliance", "shoulder.q2", {1e-8, 1e-8, 1e-7}),
           make("bearing_tilt", "arm.q5", {3e-7, 0, 1e-7}),
           make("base_compliance", "carousel.base", {1e-8, 1e-7}),
           make("base_tilt", "carousel.base", {3e-8, 1e-7, 6e-8}),
           make("platform_compliance", "arm.end", {3e-8, 3e-7}),
           make("geometric_error", "arm.upper_arm", {1e-3, -2e-3, 1e-3, 2e-3, -1e-3, 2e-3}),
           make("thermal_expansion", "arm.forearm", {1.2e-5, 22, 0, 0}),
           make("payload", "platform", {8, 0.02, -0.03, 0.05}),
           make("eccentricity", "arm.q3", {1e-4, -2e-4, 3}),
           make("creep", "shoulder.q2", {1e-7, 400, 0}),
           make("hardening", "arm.q3", {2e12}),
           make("load_hardening", "arm.q3", {1e-11}),
           make("piecewise_stiffness", "arm.q5", {1.4, 2, 100, 400}),
           make("directional_stiffness", "arm.q3", {0.6}),
           make("opening_contact", "arm.q4", {0.5, -50}),
           make("periodic_stiffness", "arm.q3", {0.2, -0.1, 3}),
           make("thermal_softening", "arm.q3", {0.01, 22, 20}),
           make("clearance", "arm.q4", {2e-4, 1}),
           make("biased_clearance", "arm.q3", {2e-4, 200, 0}),
           make("friction", "shoulder.q2", {300, 2e-5, 0, 0}),
           make("load_friction", "arm.q5", {0.2, 5e-5, 0, 1}),
           make("friction", "arm.q5", {60, 5e-5, 0, 0}),
           make("preload", "arm.q3", {200}),
           make("gravity_compensator", "shoulder.q2", {4e4, 0.15, 0.45, 0.3, 0.4}),
           make("self_weight", "arm.forearm", {30}),
           make("wrench_gain", "load", {0.95}),
           make("wrench_misalignment", "load", {0.03, -0.02, 0.04}),
           make("wrench_zero", "load", {20, -30, 10, 2, 3, -4, 0.4}),
           make("wrench_channel_gain", "load", {0.05, -0.03, 0.02, 0.04, -0.02, 0.03}),
           make("wrench_saturation", "load", {2e-7, 3e-6}),
           make("application_point", "load", {2e-3, -3e-3, 1e-3}),
           make("sensor_frame", "sensor", {1e-3, 2e-3, -1e-3, 0.02, -0.01, 0.03}),
           make("sensor_scale", "sensor", {2e-3}),
           make("sensor_axis_scale", "sensor", {2e-3, -1e-3, 3e-3}),
           make("target_lever_arm", "sensor", {0.03, -0.02, 0.05}),
           make("session_drift", "sensor", {3e-8, -2e-8, 1e-8, 4e-8, 2e-8, -1e-8, 0.7}),
           make("gauge_play", "sensor", {5e-5, 8e-5, 6e-5, 5e-5, 4e-5, 5e-5}),
           make("target_slip", "sensor", {5e-5, -8e-5, 6e-5, 5e-5, 4e-5, -5e-5, 1, 1500, 0, 0}),
           make("cycle_offset", "sensor", {5e-5, -8e-5, 6e-5, 5e-5, 4e-5, -5e-5, 5})}};
}

}  // namespace kinetostat::vjm::test

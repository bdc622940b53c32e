#include "hidden_effect.h"

#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>

#include <fmt/format.h>

namespace twin {
namespace {

struct Joint {
  double stiffness = 0, command = 0;
  bool turns = false;
};

Joint find_joint(const RobotSpec& robot, const Posture* posture, const std::string& place) {
  for (std::size_t c = 0; c < robot.chains.size(); ++c) {
    Eigen::Index k = 0;
    for (const Item& item : robot.chains[c].items) {
      if (item.kind == Item::actuator && robot.place(robot.chains[c], item) == place)
        return {item.stiffness, posture ? posture->q[c][k] : item.home, item.axes[0] >= 3};
      k += static_cast<Eigen::Index>(item.axes.size());
    }
  }
  return {};
}

// How far a drive, or the one before it in its chain, is from home.
double travel_of(const RobotSpec& robot, const Posture& posture, const std::string& place,
                 bool of_the_one_before) {
  for (std::size_t c = 0; c < robot.chains.size(); ++c) {
    double before = 0;
    Eigen::Index k = 0;
    for (const Item& item : robot.chains[c].items) {
      if (item.kind == Item::actuator) {
        const double travel = posture.q[c][k] - item.home;
        if (robot.place(robot.chains[c], item) == place) return of_the_one_before ? before : travel;
        before = travel;
      }
      k += static_cast<Eigen::Index>(item.axes.size());
    }
  }
  return 0;
}

// Springs that scatter are found in the built robot, where they have their real stiffness.
double real_stiffness(const Built& built, const std::string& place) {
  return built.structure.coupling(built.joints.at(place)).law->at(0).tangent;
}

const Vector3 skew = Vector3(0.6, -0.48, 0.64);  // of unit length: no effect is along an axis

// Forms from 1 on are along the axes.
Vector3 direction_of(const HiddenEffect& effect) {
  return effect.form == 0 ? skew : Vector3::Unit((effect.form - 1) % 3);
}

// How many times as large or long the second number of a law is.
double further(const HiddenEffect& effect) {
  return effect.form == 0 ? 1 : (effect.form == 1 ? 1. / 3 : 3.);
}

}  // namespace

double usual_size(const RobotSpec& robot, const HiddenEffect& effect) {
  const Joint joint = find_joint(robot, nullptr, effect.at);
  const double deflection = joint.turns ? 4e-4 : 3e-6;  // [rad] or [m], about that of the loads
  const std::map<std::string, double> sizes{
      {"hardening", 1 / (deflection * deflection)},  // of sinh(d/d0): 1/d0^2
      {"clearance", deflection / 5},
      {"piecewise_stiffness", 0.4},
      {"creep", 0.1},
      {"friction", joint.stiffness * deflection / 20},
      {"dahl_friction", joint.stiffness * deflection / 20},
      {"gear_loss", 0.1},
      {"lifting_contact", 0.5},
      {"rippling_stiffness", 0.1},
      {"screw_stiffness", 0.5},
      {"position_scale", 1e-4},
      {"arctangent_stiffness", 0.4},
      {"servo_droop", 0.1},
      {"preload", joint.stiffness * deflection / 2},
      {"eccentricity", deflection / 2},
      {"screw_pitch", 1e-4},
      {"geared_wrist", 1e-3},
      {"bearing_compliance", joint.turns ? 0.1 / std::max(joint.stiffness, 1.) : 1e-9},
      {"base_compliance", robot.name.starts_with("six") ? 5e-8 : 3e-6},
      {"platform_compliance", robot.name.starts_with("six") ? 1e-7 : 3e-6},
      {"self_weight", robot.name.starts_with("six") ? 20. : 1.},
      {"payload", robot.name.starts_with("six") ? 20. : 1.},
      {"gravity_compensator", robot.name.starts_with("six") ? 2e5 : 300.},
      {"thermal_expansion", 1e-5},
      {"geometric_error", 1e-4},
      {"wrench_gain", 0.05},
      {"cell_zero", robot.name.starts_with("six") ? 10. : 3.},
      {"cell_end", 1e-6},
      {"target_slip", 2e-5},
      {"gauge_play", 1e-5},
      {"cycle_offset", 2e-5},
      {"wrench_misalignment", 0.02},
      {"application_point", 0.01},
      {"target_lever_arm", 0.01},
      {"sensor_frame", 0.02},
      {"session_drift", 3e-9},
      {"cable_drag", robot.name.starts_with("six") ? 1e3 : 300.},
      {"cross_coupling", 0.05},
      {"softening_by_heat", 5e-3}};
  const auto found = sizes.find(effect.name);
  if (found == sizes.end())
    throw std::invalid_argument(fmt::format("nobody knows the effect '{}'", effect.name));
  return found->second;
}

bool remembers_loads(const HiddenEffect& effect) {
  static const std::set<std::string> names{"friction", "dahl_friction", "gear_loss", "creep"};
  return names.contains(effect.name);
}

std::vector<std::vector<HiddenEffect>> looks_of(const RobotSpec& robot,
                                                const HiddenEffect& effect) {
  // Values in which the readings are linear add up; laws have several curves.
  static const std::map<std::string, int> axes{
      {"wrench_misalignment", 3}, {"cell_zero", 3},         {"target_slip", 3},
      {"application_point", 3},   {"target_lever_arm", 3},  {"sensor_frame", 3},
      {"session_drift", 3},       {"geometric_error", 6},   {"base_compliance", 2},
      {"platform_compliance", 2}, {"bearing_compliance", 2}};
  static const std::set<std::string> two_phases{"eccentricity", "gravity_compensator"};
  static const std::map<std::string, int> curves{{"friction", 3},
                                                 {"piecewise_stiffness", 3},
                                                 {"creep", 3},
                                                 {"clearance", 1},
                                                 {"hardening", 1}};
  const auto with = [&](int form, double share = 1) {
    HiddenEffect look{effect.name, effect.at, 0, form};
    look.size = share * usual_size(robot, look);
    return look;
  };
  std::vector<std::vector<HiddenEffect>> looks;
  if (const auto found = axes.find(effect.name); found != axes.end()) {
    looks.emplace_back();
    for (int form = 1; form <= found->second; ++form) looks.back().push_back(with(form));
  } else if (two_phases.contains(effect.name)) {
    looks.push_back({with(0), with(1)});
    looks.push_back({with(2), with(3)});
  } else if (const auto law = curves.find(effect.name); law != curves.end()) {
    for (int form = 0; form < law->second; ++form) looks.push_back({with(form)});
    for (const double share : {0.3, 3.}) looks.push_back({with(0, share)});
  } else {
    looks.push_back({with(0)});
  }
  return looks;
}

namespace {

JointLawPointer law_of(const HiddenEffect& effect, double k, double deflection) {
  if (effect.name == "hardening") return hardening_law(k, 1 / std::sqrt(effect.size));
  if (effect.name == "clearance") return clearance_law(k, effect.size);
  if (effect.name == "piecewise_stiffness")
    return two_slope_law(k, 1 + effect.size, further(effect) * deflection / 2);
  if (effect.name == "lifting_contact") return lifting_law(k, effect.size, deflection / 2);
  if (effect.name == "arctangent_stiffness")
    return arctangent_law(k, 1 + effect.size, deflection / 3);
  if (effect.name == "creep") return creep_law(k, effect.size / k, further(effect) * 300);
  if (effect.name == "servo_droop") return servo_droop_law(k, effect.size, deflection);
  return nullptr;
}

// With form 1 hardly anything shifts, with form 2 hardly anything turns.
double stiffness_of(const HiddenEffect& effect, bool turning, double compliance) {
  const bool stiff = turning ? effect.form == 2 : effect.form == 1;
  return 1 / (stiff ? 1e-3 * compliance : compliance);
}

Matrix6 soft(const HiddenEffect& effect) {
  Vector6 k;
  k << Vector3::Constant(stiffness_of(effect, false, 0.1 * effect.size)),
      Vector3::Constant(stiffness_of(effect, true, effect.size));
  return k.asDiagonal();
}

void bear(Coupling& coupling, const HiddenEffect& effect, bool turns) {
  for (int i = 0; i < 6; ++i)
    if (i != coupling.axis) {
      const double share = turns ? (i < 3 ? 0.1 : 1) : (i < 3 ? 1 : 100);
      coupling.stiffness(i, i) = stiffness_of(effect, i >= 3, share * effect.size);
    }
}

// Two phases of the first harmonic, then two of the second.
double periodic(int form, double command) {
  const int order = 1 + form / 2;
  return std::cos(order * command + 0.7 + (form % 2) * std::numbers::pi / 2);
}

void balance(Built& built, const HiddenEffect& effect, double command) {
  Structure& s = built.structure;
  const Coupling& joint = s.coupling(built.joints.at(effect.at));
  const Pose behind = s.pose_of(joint.b);
  // As the joint's axes stand before it turns.
  const Pose frame{behind.x, behind.R * rotation_of(-command * Vector3::Unit(joint.axis - 3))};
  // The cylinder hangs behind the joint and pulls at a lug of the moving link. In its other forms
  // its foot is a quarter turn further, or it pulls in proportion to its length.
  const Vector3 below = effect.form % 2 == 0 ? Vector3(-0.6, 0, -0.25) : Vector3(0.25, 0, -0.6);
  const Mark lug = s.mark(joint.b.body, {behind * Vector3(-0.05, 0, 0.25), Matrix3::Identity()});
  const Mark foot = s.mark(joint.a.body, {frame * below, Matrix3::Identity()});
  s.add(Strut{foot, lug, effect.size, effect.form < 2 ? 0.55 : 0});
}

void cross_couple(Built& built, const std::string& at, double share) {
  // A moment about the joint also turns what is behind it out of its plane.
  Coupling& joint = built.structure.coupling(built.joints.at(at));
  const double k = joint.law->at(0).tangent;
  const int other = joint.axis < 3 ? (joint.axis + 1) % 3 : 3 + (joint.axis - 2) % 3;
  const double c = 1 / k;
  Eigen::Matrix2d compliance;
  compliance << c, share * c, share * c, 1e-3 * c + share * share * c;
  const Eigen::Matrix2d stiffness = compliance.inverse();
  joint.law = linear_law(0);
  joint.stiffness(joint.axis, joint.axis) = stiffness(0, 0);
  joint.stiffness(joint.axis, other) = joint.stiffness(other, joint.axis) = stiffness(0, 1);
  joint.stiffness(other, other) = stiffness(1, 1);
}

}  // namespace

void apply_to_structure(const HiddenEffect& effect, const RobotSpec& robot, const Posture& posture,
                        Built& built) {
  if (effect.size == 0) return;
  Structure& s = built.structure;
  const Joint joint = find_joint(robot, &posture, effect.at);
  const double deflection = joint.turns ? 4e-4 : 3e-6;
  if (const auto number = built.joints.find(effect.at); number != built.joints.end()) {
    const double k = real_stiffness(built, effect.at);
    Coupling& coupling = s.coupling(number->second);
    if (const JointLawPointer law = law_of(effect, k, deflection)) coupling.law = law;
    if (effect.name == "friction")
      coupling.law = friction_law(coupling.law, effect.size, further(effect) * deflection / 30);
    if (effect.name == "dahl_friction")
      coupling.law = dahl_law(coupling.law, effect.size, deflection / 25);
    if (effect.name == "gear_loss")
      coupling.law = gear_loss_law(coupling.law, effect.size, deflection / 25);
    if (effect.name == "rippling_stiffness")
      coupling.law = linear_law(k * (1 + effect.size * periodic(effect.form, joint.command)));
    // The free length of a screw adds to a compliance: its bearing is half a metre before home.
    if (effect.name == "screw_stiffness")
      coupling.law =
          linear_law(k / (1 + effect.size * (0.5 + travel_of(robot, posture, effect.at, false))));
    if (effect.name == "preload") coupling.rest[coupling.axis] += effect.size / k;
    if (effect.name == "eccentricity")
      coupling.rest[coupling.axis] += effect.size * periodic(effect.form, joint.command);
    if (effect.name == "screw_pitch" || effect.name == "geared_wrist")
      coupling.rest[coupling.axis] +=
          effect.size * travel_of(robot, posture, effect.at, effect.name == "geared_wrist");
    if (effect.name == "bearing_compliance") bear(coupling, effect, joint.turns);
    if (effect.name == "cross_coupling") cross_couple(built, effect.at, effect.size);
    if (effect.name == "gravity_compensator") balance(built, effect, joint.command);
    if (effect.name == "geometric_error") {
      Vector6 shift;
      shift << effect.size * skew, effect.size * Vector3(skew.z(), skew.x(), skew.y());
      if (effect.form > 0) shift = effect.size * Vector6::Unit(effect.form - 1);
      shift[coupling.axis] = 0;
      coupling.rest += shift;
    }
  }
  if (effect.name == "base_compliance")
    for (const int mount : built.mounts) s.coupling(mount).stiffness = soft(effect);
  if (effect.name == "platform_compliance")
    for (const int end : built.ends) s.coupling(end).stiffness = soft(effect);
  if (effect.name == "self_weight") {
    const std::vector<int>& bodies = built.beams_bodies.at(effect.at);
    const double share = effect.size / static_cast<double>(bodies.size() - 1);
    for (std::size_t i = 0; i < bodies.size(); ++i)
      if (bodies[i] != ground)
        s.add_mass(bodies[i], i == 0 || i + 1 == bodies.size() ? share / 2 : share);
  }
  if (effect.name == "payload") s.add_mass(built.platform.body, effect.size);
  if (effect.name == "cable_drag") {
    // The dress pack: an elastic line from a post beside the robot to the tool.
    const Vector3 tool = s.pose_of(built.platform).x;
    const Vector3 post = tool.norm() * Vector3(0.2, 0.9, 0.5);
    s.add(Strut{{ground, {post, Matrix3::Identity()}},
                built.platform,
                effect.size,
                0.7 * (tool - post).norm()});
  }
}

void apply_conditions(const std::vector<HiddenEffect>& effects, const std::vector<Vector6>& rests,
                      const Row& row, Built& built) {
  for (const HiddenEffect& effect : effects) {
    if (effect.name == "thermal_expansion") {
      const std::vector<int>& elements = built.links.at(effect.at);
      const auto n = static_cast<double>(elements.size());
      for (std::size_t i = 0; i < elements.size(); ++i) {
        // Warmer at the end where the motor is.
        const double gradient = 1 + 0.2 * (0.5 - (static_cast<double>(i) + 0.5) / n);
        const auto number = static_cast<std::size_t>(elements[i]);
        built.structure.couplings()[number].rest[0] =
            rests[number][0] * (1 + effect.size * gradient * (row.link_temperature - 20));
      }
    }
    if (effect.name == "softening_by_heat") {
      Coupling& coupling = built.structure.coupling(built.joints.at(effect.at));
      coupling.stiffness(coupling.axis, coupling.axis) =
          -effect.size * (row.link_temperature - 20) * coupling.law->at(0).tangent;
    }
  }
}

// By which a load cell's amplifier that nears its end, a hyperbolic tangent, reads too little.
double stretched(double force, double curvature) {
  const double x = force * std::sqrt(3 * curvature);
  if (!(x < 1)) throw std::invalid_argument("the load cell is at its end");
  return x > 1e-9 ? std::atanh(x) / x : 1;
}

DeadLoad actual_load(const std::vector<HiddenEffect>& effects, const Row& row,
                     const Mark& platform) {
  DeadLoad load{platform, row.force, Vector3::Zero()};
  if (row.weighed) return load;
  for (const HiddenEffect& effect : effects) {
    if (effect.name == "wrench_gain") load.force *= 1 + effect.size;
    if (effect.name == "cell_zero" && row.force.norm() > 0)
      load.force += effect.size * direction_of(effect);
    if (effect.name == "cell_end") load.force *= stretched(row.force.norm(), effect.size);
    if (effect.name == "wrench_misalignment")
      load.force = rotation_of(effect.size * direction_of(effect)) * load.force;
    if (effect.name == "application_point")
      load.at.at.x += load.at.at.R * (effect.size * direction_of(effect));
  }
  return load;
}

// A nest that is knocked on the way, and set right for the next session.
constexpr double slip_time = 9000;  // [s]

Pose seen(const std::vector<HiddenEffect>& effects, const Pose& platform, const Row& row) {
  Pose pose = platform;
  for (const HiddenEffect& effect : effects) {
    if (effect.name == "target_lever_arm")
      pose.x = pose * Vector3(effect.size * direction_of(effect));
    if (effect.name == "sensor_frame")
      pose = Pose{Vector3::Zero(), rotation_of(effect.size * direction_of(effect))} * pose;
    if (effect.name == "target_slip" && row.session == "monday" && row.time > slip_time)
      pose.x = pose * Vector3(effect.size * direction_of(effect));
    if (effect.name == "position_scale") pose.x *= 1 + effect.size;
    if (effect.name == "session_drift") pose.x += effect.size * row.time * direction_of(effect);
  }
  return pose;
}

}  // namespace twin

#include <set>

#include <fmt/format.h>

#include "case.h"

namespace twin {
namespace {

/// What can be hidden in a trial robot so that a plan can show it.
struct Trial {
  std::string robot, plan;
  std::vector<HiddenEffect> effects, outside;
};

const std::vector<Trial>& trials() {
  static const std::vector<Trial> all{
      {"scara",
       "push",
       {{"friction", "q1"},
        {"clearance", "q2"},
        {"arctangent_stiffness", "q1"},
        {"base_compliance", "base"},
        {"application_point", "load"},
        {"bearing_compliance", "q2"}},
       {{"cross_coupling", "q1"}}},
      {"scara",
       "poses",
       {{"thermal_expansion", "fore"}, {"eccentricity", "q2"}, {"geometric_error", "q2"}},
       {{"cable_drag", "platform"}}},
      {"arm_7r",
       "push",
       {{"dahl_friction", "a2"},
        {"clearance", "a4"},
        {"hardening", "a2"},
        {"creep", "a4"},
        {"base_compliance", "base"},
        {"target_lever_arm", "sensor"}},
       {{"servo_droop", "a2"}}},
      {"arm_7r",
       "poses",
       {{"payload", "platform"}, {"eccentricity", "a4"}, {"thermal_expansion", "upper"}},
       {{"cable_drag", "platform"}}},
      {"arm_7r", "weights", {{"clearance", "a2"}, {"dahl_friction", "a4"}}, {}},
      {"gantry",
       "push",
       {{"clearance", "gy"},
        {"dahl_friction", "gx"},
        {"bearing_compliance", "gx"},
        {"hardening", "gz"},
        {"wrench_misalignment", "load"}},
       {{"servo_droop", "gy"}}},
      {"gantry",
       "poses",
       {{"geometric_error", "gy"}, {"thermal_expansion", "bridge"}, {"payload", "platform"}},
       {}},
      {"planar_3rrr",
       "push",
       {{"clearance", "a.q"},
        {"friction", "b.q"},
        {"arctangent_stiffness", "c.q"},
        {"session_drift", "sensor"}},
       {{"servo_droop", "a.q"}}},
      {"hexapod",
       "push",
       {{"clearance", "a.rho"},
        {"dahl_friction", "d.rho"},
        {"hardening", "b.rho"},
        {"application_point", "load"}},
       {{"servo_droop", "c.rho"}}},
      {"hexapod", "poses", {{"thermal_expansion", "a.strut"}, {"payload", "platform"}}, {}},
      {"delta",
       "push",
       {{"clearance", "a.q"}, {"dahl_friction", "b.q"}, {"creep", "c.q"}},
       {{"cable_drag", "platform"}}},
      {"delta", "weights", {{"friction", "b.q"}, {"arctangent_stiffness", "a.q"}}, {}},
      {"scara", "push", {{"gear_loss", "q1"}, {"gear_loss", "q2"}}, {}},
      {"planar_3rrr", "push", {{"gear_loss", "b.q"}, {"gear_loss", "c.q"}}, {}},
      {"arm_7r", "push", {{"gear_loss", "a2"}, {"gear_loss", "a4"}}, {}},
      {"scara", "push", {{"lifting_contact", "q2"}, {"rippling_stiffness", "q2"}}, {}},
      {"arm_7r", "push", {{"rippling_stiffness", "a2"}, {"lifting_contact", "a4"}}, {}},
      {"gantry", "push", {{"screw_stiffness", "gy"}, {"lifting_contact", "gy"}}, {}},
      {"arm_7r", "poses", {{"position_scale", "sensor"}}, {}},
      {"scara", "poses", {{"position_scale", "sensor"}}, {}},
      {"gantry", "poses", {{"screw_pitch", "gx"}}, {}},
      {"scara", "poses", {{"screw_pitch", "q2"}, {"geared_wrist", "q2"}}, {}},
      {"arm_7r", "poses", {{"geared_wrist", "a4"}, {"screw_pitch", "a2"}}, {}}};
  return all;
}

/// What a load cell and a target do, which came later.
const std::vector<Trial>& instruments() {
  static const std::vector<Trial> all{
      {"scara", "push", {{"cell_zero", "load"}, {"cell_end", "load"}}, {}},
      {"arm_7r", "push", {{"cell_end", "load"}, {"cell_zero", "load"}}, {}},
      {"gantry", "push", {{"cell_zero", "load"}, {"cell_end", "load"}}, {}},
      {"scara", "poses", {{"target_slip", "sensor"}}, {}},
      {"arm_7r", "poses", {{"target_slip", "sensor"}}, {}},
      {"gantry", "poses", {{"target_slip", "sensor"}}, {}}};
  return all;
}

/// A dial gauge with play, and a cycle of which the zero was taken wrong.
const std::vector<Trial>& gauges() {
  static const std::vector<Trial> all{{"scara", "push", {{"gauge_play", "sensor"}}, {}},
                                      {"arm_7r", "push", {{"gauge_play", "sensor"}}, {}},
                                      {"gantry", "push", {{"gauge_play", "sensor"}}, {}},
                                      {"scara", "push", {{"cycle_offset", "sensor"}}, {}},
                                      {"arm_7r", "push", {{"cycle_offset", "sensor"}}, {}},
                                      {"gantry", "poses", {{"cycle_offset", "sensor"}}, {}}};
  return all;
}

/// Effects that act together in one robot.
struct Together {
  std::string robot, plan;
  std::vector<HiddenEffect> effects;
};

const std::vector<Together>& together() {
  static const std::vector<Together> all{
      {"scara", "push", {{"clearance", "q2"}, {"base_compliance", "base"}}},
      {"scara", "push", {{"friction", "q1"}, {"clearance", "q2"}}},
      {"scara", "push", {{"friction", "q2"}, {"clearance", "q2"}}},
      {"scara", "poses", {{"eccentricity", "q2"}, {"thermal_expansion", "fore"}}},
      {"arm_7r", "push", {{"clearance", "a4"}, {"hardening", "a2"}}},
      {"arm_7r", "push", {{"dahl_friction", "a2"}, {"base_compliance", "base"}}},
      {"arm_7r", "push", {{"creep", "a4"}, {"dahl_friction", "a4"}}},
      {"arm_7r", "poses", {{"payload", "platform"}, {"eccentricity", "a4"}}},
      {"arm_7r", "weights", {{"clearance", "a2"}, {"dahl_friction", "a4"}}},
      {"gantry", "push", {{"clearance", "gy"}, {"bearing_compliance", "gx"}}},
      {"gantry", "push", {{"dahl_friction", "gx"}, {"hardening", "gz"}}},
      {"gantry", "poses", {{"thermal_expansion", "bridge"}, {"geometric_error", "gy"}}},
      {"planar_3rrr", "push", {{"clearance", "a.q"}, {"friction", "b.q"}}},
      {"hexapod", "push", {{"clearance", "a.rho"}, {"dahl_friction", "d.rho"}}},
      {"delta", "push", {{"clearance", "a.q"}, {"creep", "c.q"}}},
      {"scara", "push", {{"friction", "q1"}, {"clearance", "q2"}, {"application_point", "load"}}},
      {"arm_7r",
       "push",
       {{"clearance", "a4"}, {"dahl_friction", "a2"}, {"base_compliance", "base"}}},
      {"gantry", "push", {{"clearance", "gy"}, {"dahl_friction", "gx"}, {"hardening", "gz"}}}};
  return all;
}

}  // namespace

std::vector<Case> trial_suite() {
  std::vector<Case> cases;
  bool held_back = false;
  const auto add = [&](const std::string& kind, const Trial& trial, const std::string& what,
                       std::vector<Target> targets) {
    Case c{.name = fmt::format("t{:03}_{}_{}_{}_{}", cases.size() + 1, trial.robot, kind,
                               trial.plan, what),
           .kind = kind,
           .robot = trial.robot,
           .plan = trial.plan,
           .targets = std::move(targets)};
    c.seed = 50'000 + cases.size();
    c.held_back = held_back;
    cases.push_back(std::move(c));
  };
  const auto add_singles = [&](const Trial& trial) {
    for (std::size_t i = 0; i < trial.effects.size(); ++i)
      for (const double d : {8., 25.}) {
        held_back = (i % 2 == 0) == (d > 10);
        add("single", trial, fmt::format("{}_d{:g}", trial.effects[i].name, d),
            {{trial.effects[i], d}});
      }
  };
  for (const Trial& trial : trials()) {
    add_singles(trial);
    for (const bool second : {false, true}) {
      held_back = second;
      add("clean", trial, second ? "b" : "a", {});
      for (const HiddenEffect& effect : trial.outside)
        add("outside", trial, fmt::format("{}_d{:g}", effect.name, second ? 25. : 15.),
            {{effect, second ? 25. : 15.}});
    }
  }
  for (const Together& all : together())
    for (const double d : {12., 30.}) {
      held_back = d > 20;
      std::string name;
      std::vector<Target> targets;
      for (const HiddenEffect& effect : all.effects) {
        name += effect.name + "_";
        targets.push_back({effect, d});
      }
      add("pair", {all.robot, all.plan, {}, {}}, fmt::format("{}d{:g}", name, d), targets);
    }
  held_back = false;  // the rate of false alarms wants more campaigns
  std::set<std::pair<std::string, std::string>> seen;
  for (const Trial& trial : trials())
    if (seen.emplace(trial.robot, trial.plan).second)
      for (const char* which : {"c", "d", "e"}) add("clean", trial, which, {});
  for (const Trial& trial : instruments()) add_singles(trial);
  for (const Trial& trial : gauges()) add_singles(trial);
  return cases;
}

}  // namespace twin

#include "case.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "campaign_text.h"
#include "plan_table.h"

namespace twin {
namespace {

using Readings = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// What can be hidden in a robot so that a plan can show it.
struct Menu {
  std::string robot, plan;
  std::vector<HiddenEffect> effects, outside;
};

const std::vector<Menu>& menus() {
  static const std::vector<Menu> all{
      {"bench",
       "cycles",
       {{"friction", "q1"},
        {"clearance", "q1"},
        {"hardening", "q1"},
        {"piecewise_stiffness", "q1"},
        {"creep", "q1"}},
       {{"servo_droop", "q1"}}},
      {"arm_3r",
       "cycles",
       {{"friction", "q2"},
        {"clearance", "q3"},
        {"hardening", "q2"},
        {"creep", "q2"},
        {"base_compliance", "base"},
        {"platform_compliance", "end"},
        {"application_point", "load"},
        {"wrench_misalignment", "load"},
        {"target_lever_arm", "sensor"},
        {"session_drift", "sensor"}},
       {{"servo_droop", "q2"}, {"cable_drag", "platform"}, {"cross_coupling", "q2"}}},
      {"arm_3r",
       "poses",
       {{"payload", "platform"},
        {"self_weight", "fore"},
        {"eccentricity", "q2"},
        {"thermal_expansion", "upper"},
        {"geometric_error", "q3"}},
       {{"cable_drag", "platform"}}},
      {"arm_6r",
       "cycles",
       {{"friction", "q3"},
        {"clearance", "q2"},
        {"hardening", "q2"},
        {"base_compliance", "base"},
        {"piecewise_stiffness", "q3"}},
       {{"servo_droop", "q3"}, {"softening_by_heat", "q2"}}},
      {"arm_6r",
       "poses",
       {{"gravity_compensator", "q2"},
        {"payload", "platform"},
        {"eccentricity", "q3"},
        {"thermal_expansion", "upper"}},
       {{"cable_drag", "platform"}}},
      {"orthoglide",
       "cycles",
       {{"clearance", "x.rho"},
        {"session_drift", "sensor"},
        {"wrench_misalignment", "load"},
        {"application_point", "load"}},
       {{"servo_droop", "y.rho"}, {"cable_drag", "platform"}}},
      {"orthoglide",
       "poses",
       {{"thermal_expansion", "x.leg"}, {"preload", "y.rho"}, {"payload", "platform"}},
       {{"cable_drag", "platform"}}}};
  return all;
}

// About a fifth of the joint's force under the largest load.
double one_way_friction(const std::string& robot) {
  if (robot == "bench") return 6;
  if (robot == "arm_3r") return 6;
  return robot == "arm_6r" ? 200 : 90;
}

}  // namespace

std::vector<Case> suite() {
  std::vector<Case> cases;
  std::size_t number = 0;
  int round = 0;
  const auto add = [&](const std::string& kind, const Menu& menu, const std::string& what,
                       std::vector<Target> targets, const std::string& plan = "") {
    Case c{.name = fmt::format("{:04}_{}_{}_{}", number + 1, menu.robot, kind, what),
           .kind = kind,
           .robot = menu.robot,
           .plan = plan.empty() ? menu.plan : plan,
           .targets = std::move(targets)};
    c.seed = 1000 + number++;
    c.round = std::min(round + 1, rounds);
    // An Orthoglide takes as long as ten others: it has one round, and its largest effects.
    if (menu.robot == "orthoglide" && round > 0 && round < rounds) return;
    cases.push_back(c);
  };
  for (; round < rounds; ++round) {
    for (const Menu& menu : menus())
      for (const char* kind : {"clean", "off_base", "loud"})
        for (int i = 0; i < 2; ++i) add(kind, menu, menu.plan, {});
    for (const double d : {8., 5., 15., 3.5, 2.})
      for (const Menu& menu : menus())
        for (const HiddenEffect& effect : menu.effects)
          add("single", menu, fmt::format("{}_d{:g}", effect.name, d), {{effect, d}});
    for (const Menu& menu : menus())
      for (const HiddenEffect& effect : menu.outside)
        for (const double d : {8., 15.})
          add("outside", menu, fmt::format("{}_d{:g}", effect.name, d), {{effect, d}});
    for (const Menu& menu : menus()) {
      // One three times the other, then two alike. A joint has one law, and friction beside it.
      const std::size_t n = menu.effects.size(), r = static_cast<std::size_t>(round);
      const HiddenEffect &other = menu.effects[1 + r % (n - 1)], &first = menu.effects[0];
      add("pair", menu, other.name + "_" + first.name, {{other, 24}, {first, 8}});
      add("pair", menu, first.name + "_" + other.name + "_alike", {{other, 10}, {first, 10}});
    }
    for (const Menu& menu : menus()) {
      if (menu.plan != "cycles") continue;
      add("blind", menu, "wrench_gain", {{{"wrench_gain", "load", 0.05}, 0}});
      if (menu.robot != "bench") add("blind", menu, "payload", {{{"payload", "platform", 0.5}, 0}});
      add("blind", menu, "friction_one_way",
          {{{"friction", menu.effects[0].at, one_way_friction(menu.robot)}, 0}}, "one_way");
    }
    // In the catalogue, but not tried: the scorer takes it out for the run.
    for (const Menu& menu : menus())
      for (const HiddenEffect& effect : menu.effects)
        if (effect.name == "creep")
          for (const double d : {8., 15.})
            add("outside", menu, fmt::format("creep_d{:g}", d), {{effect, d}});
  }
  // So large that the laws of product and twin, which differ, can be distinguished. A joint that
  // hardens ends up rigid, which an arm with its other joints hardly shows.
  for (const Menu& menu : menus())
    for (const HiddenEffect& effect : menu.effects)
      if (effect.name != "hardening" || menu.robot == "bench")
        add("single", menu, effect.name + "_d50", {{effect, 50}});
  // False alarms are rare: it takes many campaigns without anything hidden to count them.
  for (const Menu& menu : menus())
    for (int i = 0; menu.robot != "orthoglide" && i < 12; ++i) add("clean", menu, menu.plan, {});
  return cases;
}

std::vector<Case> stories() {
  return {{.name = "story_arm",
           .kind = "story",
           .robot = "arm_6r",
           .plan = "push",
           .targets = {{{"base_compliance", "base", 9e-8}}, {{"clearance", "q3", 5.7e-5}}},
           .seed = 39}};
}

namespace {

// 12 % of scatter in every stiffness; 20 % more where the base model is to be wrong.
std::vector<double> scattered(const RobotSpec& robot, bool off, Random& random) {
  std::vector<double> factors;
  for (std::size_t i = 0; i < robot.springs().size(); ++i) {
    factors.push_back(std::exp(0.12 * std::clamp(random.normal(), -2., 2.)));
    if (off) factors.back() *= 1 + 0.2 * random.sign();
  }
  return factors;
}

// The robot as it is but for what is hidden, and how it is measured.
struct Setting {
  World world;
  Plan plan;
};

Setting setting_of(const Case& spec, Random& random) {
  World world{.robot = robot_named(spec.robot), .factors = {}, .effects = {}};
  world.factors = scattered(world.robot, spec.kind == "off_base", random);
  return {world, plan_named(spec.plan, world.robot, random)};
}

// The size that is as detectable as wanted, by secants in logarithms.
double size_for(const Target& target, World world, const Plan& plan, const Whitened& whitened) {
  HiddenEffect effect = target.effect;
  const auto detectability = [&](double size) {
    effect.size = size;
    world.effects = {effect};
    return whitened.mark_of(respond(world, plan, false)).norm();
  };
  double at = usual_size(world.robot, effect), d = detectability(at), power = 1;
  for (int i = 0; i < 12 && std::abs(std::log(d / target.d_prime)) > 0.03; ++i) {
    const double next = at * std::exp(std::clamp(std::log(target.d_prime / d) / power, -1.5, 1.5));
    const double further = detectability(next);
    if (const double change = std::log(next / at); std::abs(change) > 1e-6)
      power = std::clamp(std::log(further / d) / change, 0.3, 4.);
    at = next;
    d = further;
  }
  if (std::abs(std::log(d / target.d_prime)) > 0.2)
    throw std::runtime_error(fmt::format("{} at {} reaches d' = {:.3g}, wanted {}", effect.name,
                                         effect.at, d, target.d_prime));
  return at;
}

// Noise of instrument and load cell, a slight drift of each session, and one outlier in a hundred.
Readings disturbed(const Case& spec, const Plan& plan, const Responses& clear,
                   const Readings& noise, Random& random) {
  const double loud = spec.kind == "loud" ? 1.6 : 1;
  Readings read = clear.read;
  const Vector6 drift = 0.1 * noise.col(0).cwiseProduct(
                                  (Vector6() << random.direction(), random.direction()).finished());
  double longest = 1;
  for (const Row& row : plan.rows) longest = std::max(longest, row.time);
  for (Eigen::Index i = 0; i < read.cols(); ++i) {
    const double load = wrench_noise * loud * random.normal();
    read.col(i) +=
        load * clear.elastic.col(i) + drift * plan.rows[static_cast<std::size_t>(i)].time / longest;
    for (int c = 0; c < 6; ++c) {
      const double stated = noise(c, i), from_load = wrench_noise * clear.elastic(c, i);
      read(c, i) +=
          loud * random.normal() * std::sqrt(std::max(0., stated * stated - from_load * from_load));
    }
    if (random.uniform() < 0.01)
      read(random.below(plan.rotations ? 6 : 3), i) +=
          noise(0, i) * random.sign() * random.uniform(8, 15);
  }
  return read;
}

// Last in the list is applied last: friction beside whatever law there is.
void hide(const HiddenEffect& effect, World& world) {
  world.effects.insert(effect.name == "friction" ? world.effects.end() : world.effects.begin(),
                       effect);
}

// As the robot file calls it: each chain of a parallel robot has links of its own.
std::string place_in_file(const RobotSpec& robot, const std::string& at) {
  for (const ChainSpec& chain : robot.chains)
    for (const Item& item : chain.items)
      if (!robot.serial && item.kind == Item::link && robot.place(chain, item) == at)
        return at + "_" + chain.name;
  return at;
}

}  // namespace

void write_case(const Case& spec, const std::filesystem::path& folder,
                const std::filesystem::path& truth) {
  Random random(spec.seed);
  const auto [world, plan] = setting_of(spec, random);
  const std::vector<double> nominal(world.robot.springs().size(), 1);
  const Responses base = respond(world, plan, true);
  const Readings noise = stated_noise(world.robot, base);
  const Whitened whitened(plan, base, noise);

  std::string hidden;
  World real = world;
  for (const Target& target : spec.targets) {
    HiddenEffect effect = target.effect;
    if (effect.size == 0) effect.size = size_for(target, world, plan, whitened);
    hide(effect, real);
    World alone = world;
    alone.effects = {effect};
    const Eigen::VectorXd mark = whitened.mark_of(respond(alone, plan, false));
    hidden += fmt::format(
        "{}\n    {{\"effect\": \"{}\", \"at\": \"{}\", \"size\": {:.6g}, \"d_prime\": {:.4g}}}",
        hidden.empty() ? "" : ",", effect.name, place_in_file(world.robot, effect.at), effect.size,
        mark.norm());
  }
  const Responses clear = real.effects.empty() ? base : respond(real, plan, false);
  std::filesystem::create_directories(folder);
  std::filesystem::create_directories(truth.parent_path());
  write_text(folder / "robot.yaml", robot_file(world.robot, nominal));
  const Readings read = disturbed(spec, plan, clear, noise, random);
  write_campaign("case", world.robot, plan, read, noise, random, folder);
  write_text(
      truth,
      fmt::format("{{\"name\": \"{}\", \"class\": \"{}\", \"robot\": \"{}\", \"plan\": \"{}\", "
                  "\"seed\": {},\n  \"readings\": {}, \"values\": {},\n  \"effects\": [{}]}}\n",
                  spec.name, spec.kind, spec.robot, spec.plan, spec.seed, plan.rows.size(),
                  plan.rows.size() * (plan.rotations ? 6u : 3u), hidden));
}

void write_follow_up(const Case& spec, const std::vector<double>& sizes, const FollowUp& next,
                     const std::filesystem::path& folder) {
  if (sizes.size() != spec.targets.size())
    throw std::invalid_argument(fmt::format("{} hides {} effects", spec.name, spec.targets.size()));
  Random random(spec.seed);
  auto [world, first] = setting_of(spec, random);
  Random later(spec.seed + 1'000'000 * static_cast<std::uint64_t>(next.number));
  Plan plan = plan_of_table(next.table, world.robot, fmt::format("planned{}", next.number), later);
  plan.absolute = next.absolute;
  plan.rotations = first.rotations;
  for (Row& row : plan.rows) row.weighed = next.known_loads;
  const Responses base = respond(world, plan, false);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    HiddenEffect effect = spec.targets[i].effect;
    effect.size = sizes[i];
    hide(effect, world);
  }
  const Responses clear = world.effects.empty() ? base : respond(world, plan, false);
  const Readings noise = stated_noise(world.robot, base);
  const Readings read = disturbed(spec, plan, clear, noise, later);
  std::filesystem::create_directories(folder);
  std::filesystem::copy_file(next.from / "robot.yaml", folder / "robot.yaml",
                             std::filesystem::copy_options::overwrite_existing);
  add_session(next.from, next.known_loads, world.robot, plan, read, noise, later, folder);
}

Confuser confuser_in(const Case& spec, double size, double enough) {
  if (spec.targets.empty())
    throw std::invalid_argument(fmt::format("nothing is hidden in {}", spec.name));
  Random random(spec.seed);
  const auto [world, plan] = setting_of(spec, random);
  HiddenEffect effect = spec.targets[0].effect;
  effect.size = size;
  return confuser_of(effect, world, plan, enough);
}

void write_agreement(const std::string& robot, const std::string& plan_name, int elements,
                     const std::filesystem::path& folder) {
  Random random(7);
  World world{.robot = robot_named(robot), .factors = {}, .effects = {}, .elements = elements};
  world.factors = scattered(world.robot, false, random);
  const Plan plan = plan_named(plan_name, world.robot, random);
  const Responses clear = respond(world, plan, false);
  std::filesystem::create_directories(folder);
  write_text(folder / "robot.yaml", robot_file(world.robot, world.factors));
  write_campaign("agreement", world.robot, plan, clear.read, stated_noise(world.robot, clear),
                 random, folder);
}

}  // namespace twin

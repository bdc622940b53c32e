#include "kinetostat/report/screen/plan.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/report/manipulators/joint_motion.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

using calibration::Configuration;
using calibration::Plan;
using calibration::PlanBlock;
using calibration::PlannedSplit;

constexpr std::size_t most_steps = 12;
constexpr double least_useful = 2;  // d' below which a pair is not distinguished

std::string model_in_words(const vjm::Robot& robot, const std::string& name) {
  const std::size_t at = name.find(" at ");
  return at == std::string::npos
             ? name
             : effect_in_words(robot.without_effects(), name.substr(0, at), name.substr(at + 4));
}

// What the batch does, without its time.
std::string purpose(const vjm::Robot& robot, const calibration::PlanQuestion& question,
                    const Plan& plan) {
  if (question.open.empty()) {
    if (std::isnan(plan.work_before)) return "sharpen the model";
    const std::string unit = length_unit_for(plan.work_before, robot.units.length);
    const double length = spatial::parse_unit(unit).factor;
    return fmt::format("sharpen the model: displacements unsure by {} {} now, by {} {} after",
                       number(plan.work_before / length, 2), unit,
                       number(plan.work_after / length, 2), unit);
  }
  if (plan.splits.empty()) return "show what may be missing";
  const PlannedSplit& hardest = plan.splits.front();
  return fmt::format(
      "distinguish {} from {}{}", model_in_words(robot, hardest.a),
      model_in_words(robot, hardest.b),
      plan.splits.size() > 1 ? fmt::format(", and {} more pairs", plan.splits.size() - 1) : "");
}

// One joint that differs, the others alike; empty where there is no such joint.
std::string joint_alone(const Configuration& a, const Configuration& b) {
  if (a.target || b.target) return {};
  std::string joint;
  std::map<std::string, std::array<double, 2>> values;
  for (const auto& [name, value] : a.joints) values[name][0] = value;
  for (const auto& [name, value] : b.joints) values[name][1] = value;
  for (const auto& [name, pair] : values)
    if (std::abs(pair[0] - pair[1]) > 1e-12) {
      if (!joint.empty()) return {};
      joint = name;
    }
  return joint;
}

double joint_value(const Configuration& c, const std::string& joint) {
  const auto found = c.joints.find(joint);
  return found == c.joints.end() ? 0 : found->second;
}

double in_joint_units(const vjm::Robot& robot, const std::string& joint, double si) {
  const std::string& unit = joint_turns(robot, joint) ? robot.units.angle : robot.units.length;
  const double value = si / spatial::parse_unit(unit).factor;
  return std::abs(value) < 1e-9 ? 0 : value;
}

std::string joint_unit(const vjm::Robot& robot, const std::string& joint) {
  return joint_turns(robot, joint) ? robot.units.angle : robot.units.length;
}

std::string posture_in_words(const vjm::Robot& robot, const Configuration& c) {
  if (c.target) {
    const spatial::Vector3 p =
        c.target->position() / spatial::parse_unit(robot.units.length).factor;
    const auto shown = [](double v) { return number(std::abs(v) < 1e-9 ? 0 : v, 4); };
    return fmt::format("at ({}, {}, {}) {}", shown(p.x()), shown(p.y()), shown(p.z()),
                       robot.units.length);
  }
  if (c.joints.empty()) return "at home";
  std::vector<std::string> names, values;
  bool is_one_unit = true;
  const std::string unit = joint_unit(robot, c.joints.begin()->first);
  for (const auto& [name, value] : c.joints) {
    is_one_unit = is_one_unit && joint_unit(robot, name) == unit;
    names.push_back(short_name(robot.without_effects(), name));
    values.push_back(number(in_joint_units(robot, name, value), 4));
  }
  if (is_one_unit && names.size() > 1)
    return fmt::format("({}) = ({}) {}", fmt::join(names, ", "), fmt::join(values, ", "), unit);
  std::vector<std::string> parts;
  std::size_t i = 0;
  for (const auto& [name, value] : c.joints) {
    parts.push_back(fmt::format("{} = {} {}", names[i], values[i], joint_unit(robot, name)));
    ++i;
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string load_in_words(const vjm::Robot& robot, const PlanBlock& block) {
  if (block.direction.empty()) return "unloaded";
  const bool moment = block.direction[1] == 'm';
  const std::string unit =
      moment ? robot.units.force + " " + robot.units.length : robot.units.force;
  const double factor = moment ? spatial::parse_unit(robot.units.force).factor *
                                     spatial::parse_unit(robot.units.length).factor
                               : spatial::parse_unit(unit).factor;
  return fmt::format("{} {} along {}{}", number(block.level() / factor, 3), unit,
                     block.direction[0] == '-' ? "-" : "", block.direction.substr(2));
}

// Blocks that are one line: `first` and what was added to it.
struct Group {
  const PlanBlock* first;
  std::vector<const PlanBlock*> all;
  std::string joint;  // that is moved alone from block to block
  std::vector<std::string> why;
};

bool is_alike(const PlanBlock& a, const PlanBlock& b) {
  return a.direction == b.direction && a.pattern == b.pattern &&
         std::abs(a.level() - b.level()) <= 1e-9 * (1 + a.level());
}

// The next of a row in which one joint alone moves.
bool goes_on(const Plan& plan, Group& group, const PlanBlock& block) {
  if (!is_alike(*group.first, block)) return false;
  const auto& configurations = plan.readings.configurations;
  const std::string joint = joint_alone(configurations[group.all.back()->configuration],
                                        configurations[block.configuration]);
  if (joint.empty() || (group.all.size() > 1 && joint != group.joint)) return false;
  group.joint = joint;
  return true;
}

// The group that a block belongs to: a row of one joint, or the same load without a change of
// posture in between, in whatever order; else none.
Group* group_of(const Plan& plan, std::vector<Group>& groups, const PlanBlock& block) {
  if (groups.empty()) return nullptr;
  if (groups.back().all.back()->configuration != block.configuration)
    return goes_on(plan, groups.back(), block) ? &groups.back() : nullptr;
  for (auto group = groups.rbegin(); group != groups.rend(); ++group) {
    if (group->first->configuration != block.configuration || !group->joint.empty()) break;
    if (is_alike(*group->first, block)) return &*group;
  }
  return nullptr;
}

std::string postures_of(const vjm::Robot& robot, const Plan& plan, const Group& group) {
  const auto& configurations = plan.readings.configurations;
  if (group.joint.empty())
    return posture_in_words(robot, configurations[group.first->configuration]);
  std::vector<std::string> values;
  for (const PlanBlock* block : group.all)
    values.push_back(
        number(in_joint_units(robot, group.joint,
                              joint_value(configurations[block->configuration], group.joint)),
               4));
  return fmt::format("move joint {} alone: {} {}", short_name(robot.without_effects(), group.joint),
                     fmt::join(values, ", "), joint_unit(robot, group.joint));
}

std::string step_text(std::size_t number, const WorkStep& step) {
  const std::string count =
      fmt::format("{:>3} readings {:>8}", step.readings, minutes(step.minutes));
  std::string what = step.load + (step.how.empty() ? "" : ", " + step.how) +
                     (step.cycles > 1 ? fmt::format(", {} times", step.cycles) : "") + "; " +
                     step.posture;
  constexpr std::size_t width = 70;
  if (what.size() <= width) return fmt::format("  {:>2} {:<{}}{}\n", number, what, width, count);
  return wrapped(fmt::format("{:>2} {}", number, what), 3, 5) + std::string(5 + width, ' ') +
         count + "\n";
}

}  // namespace

namespace {

std::string why_nothing_is_planned(const vjm::Robot& robot, const Plan& plan) {
  for (const PlannedSplit& split : plan.splits)
    if (!split.advice.empty())
      return fmt::format("No readings of this kind distinguish {} from {}: {}.",
                         model_in_words(robot, split.a), model_in_words(robot, split.b),
                         split.advice);
  return "No readings of this kind would change what is known.";
}

}  // namespace

std::string headline(const vjm::Robot& robot, const calibration::PlanQuestion& question,
                     const calibration::PlanOptions& options, const Plan& plan) {
  if (plan.blocks.empty()) return why_nothing_is_planned(robot, plan);
  std::string text = fmt::format("{} {}", minutes(plan.minutes), purpose(robot, question, plan));
  if (!question.open.empty() && !plan.splits.empty()) {
    const PlannedSplit& hardest = plan.splits.front();
    text += fmt::format(" (expected d' {})", number(hardest.separation, 2));
    if (hardest.separation < least_useful)
      text += fmt::format("; that is hardly enough{}",
                          hardest.advice.empty() ? "" : ": " + hardest.advice);
  }
  text += ".";
  if (plan.minutes < 0.8 * options.minutes) text += " More time adds little.";
  return text;
}

std::string plan_in_short(const vjm::Robot& robot, const calibration::PlanQuestion& question,
                          const Plan& plan) {
  if (plan.blocks.empty()) return "no readings of this kind would change what is known";
  return fmt::format("{}: {} readings, {}", purpose(robot, question, plan),
                     plan.readings.readings.size(), minutes(plan.minutes));
}

std::vector<WorkStep> work_list(const vjm::Robot& robot, const Plan& plan) {
  std::vector<Group> groups;
  for (std::size_t b = 0; b < plan.blocks.size(); ++b) {
    const PlanBlock& block = plan.blocks[b];
    Group* group = group_of(plan, groups, block);
    if (group == nullptr) group = &groups.emplace_back(Group{&block, {}, "", {}});
    group->all.push_back(&block);
    group->why.push_back(plan.why[b]);
  }
  std::vector<WorkStep> steps;
  for (const Group& group : groups) {
    WorkStep step{.posture = postures_of(robot, plan, group),
                  .load = load_in_words(robot, *group.first),
                  .how = group.first->direction.empty() ? "" : group.first->pattern->name,
                  .cycles = group.joint.empty() ? group.all.size() : 1,
                  .readings = 0,
                  .minutes = 0,
                  .why = group.why.front()};
    for (const PlanBlock* block : group.all) {
      step.readings += block->pattern->steps.size();
      step.minutes += block->minutes;
    }
    steps.push_back(std::move(step));
  }
  return steps;
}

io::Json to_json(const std::vector<WorkStep>& steps) {
  io::Json list = io::Json::array();
  for (const WorkStep& step : steps)
    list.push_back({{"posture", step.posture},
                    {"load", step.load},
                    {"how", step.how},
                    {"times", step.cycles},
                    {"readings", step.readings},
                    {"minutes", step.minutes},
                    {"for", step.why}});
  return list;
}

std::string first_screen(const vjm::Robot& robot, const calibration::PlanQuestion& question,
                         const calibration::PlanOptions& options, const Plan& plan,
                         const std::string& next) {
  std::string text = wrapped(headline(robot, question, options, plan));
  if (plan.asks_for_absolute && !plan.blocks.empty())
    text +=
        wrapped("Read absolute poses, a campaign of their own: in differences the effect cancels.");
  if (plan.asks_for_weights && !plan.blocks.empty())
    text += wrapped("Load by known weights, in a session that 'known_loads' lists.");
  const std::vector<WorkStep> steps = work_list(robot, plan);
  if (!steps.empty()) text += "\n";
  std::size_t shown = 0, lines = 0;
  for (const WorkStep& step : steps) {
    const std::string line = step_text(shown + 1, step);
    lines += static_cast<std::size_t>(std::count(line.begin(), line.end(), '\n'));
    if (lines > most_steps) break;
    text += line;
    ++shown;
  }
  if (shown < steps.size()) {
    double rest = 0;
    for (std::size_t i = shown; i < steps.size(); ++i) rest += steps[i].minutes;
    text += fmt::format("  {} more line{}, {}: --verbose, or the file of -o\n",
                        steps.size() - shown, steps.size() - shown == 1 ? "" : "s", minutes(rest));
  }
  return text + (next.empty() ? "" : "\n" + next);
}

}  // namespace kinetostat::report

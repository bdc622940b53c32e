#include "kinetostat/report/manipulators/path.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/io/csv.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/manipulators/skeleton.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

using io::Json;
using vjm::Along;
using vjm::Branch;
using vjm::BranchEnd;
using vjm::CriticalKind;
using vjm::CriticalPoint;
using vjm::Path;
using vjm::PathPoint;
using vjm::PathTask;
using vjm::Robot;

// Units of deflection, force and stiffness along a task.
struct AlongUnits {
  double deflection, force;
  std::string deflection_name, force_name;

  AlongUnits(const Robot& robot, const PathTask& task) {
    const double length = spatial::parse_unit(robot.units.length).factor;
    force = spatial::parse_unit(robot.units.force).factor;
    force_name = robot.units.force;
    deflection = length;
    deflection_name = robot.units.length;
    if (!turns(task)) return;
    deflection = spatial::parse_unit(robot.units.angle).factor;
    deflection_name = robot.units.angle;
    force *= length;
    force_name += " " + robot.units.length;
  }
  std::string stiffness_name() const { return force_name + "/" + deflection_name; }
  double stiffness() const { return force / deflection; }
};

const char* name(CriticalKind kind) {
  switch (kind) {
    case CriticalKind::limit_point:
      return "limit point";
    case CriticalKind::contact:
      return "contact";
    case CriticalKind::bifurcation:
      break;
  }
  return "bifurcation";
}

std::string ending(const Path& path, const Branch& branch) {
  switch (branch.end) {
    case BranchEnd::target:
      return "at the target";
    case BranchEnd::range:
      return "at the end of the range";
    case BranchEnd::junction:
      return fmt::format("at critical point {}", *branch.to + 1);
    case BranchEnd::joined:
      return fmt::format("on branch {}, already followed", *branch.onto + 1);
    case BranchEnd::closed:
      return "where it started";
    case BranchEnd::free:
      return "free: more than one motion costs nothing";
    case BranchEnd::locked:
      return "locked: the force grows without displacement";
    case BranchEnd::critical:
      return "at the first critical point";
    case BranchEnd::limit:
      return "after the most points allowed";
    case BranchEnd::lost:
      break;
  }
  return path.status == vjm::EquilibriumStatus::converged ? "lost: " + branch.reason
                                                          : branch.reason;
}

// Programs read the words that JSON has always had.
std::string ending_in_json(const Path& path, const Branch& branch) {
  return branch.end == BranchEnd::closed ? "where it began" : ending(path, branch);
}

std::string shown(const std::optional<double>& value, double unit, int digits = 6) {
  return value ? number(*value / unit, digits) : "-";
}

// Stiffness along the path beside a critical point, on its own branch.
std::optional<double> stiffness_at(const Branch& branch, std::size_t i) {
  if (i >= branch.points.size()) return std::nullopt;
  const std::optional<Along>& at = branch.points[i].along;
  return at ? at->stiffness : std::nullopt;
}

// On the stable branch that leaves there, if one was followed; else further on the same branch.
std::optional<double> stiffness_after(const PathTask& task, const Path& path,
                                      std::size_t critical) {
  for (const Branch& branch : path.branches)
    if (branch.from == critical && branch.points.size() > 2 &&
        branch.points[2].stability(task).stable())
      return stiffness_at(branch, 2);
  const CriticalPoint& point = path.critical[critical];
  return stiffness_at(path.branches[point.branch], point.after + 1);
}

// Where it does not move, rounding remains of it.
double shown_parameter(const PathPoint& point) {
  return std::abs(point.parameter) < 1e-15 ? 0 : point.parameter;
}

std::vector<std::string> critical_row(const PathTask& task, const Path& path, std::size_t c,
                                      const AlongUnits& units) {
  const CriticalPoint& point = path.critical[c];
  const std::optional<Along>& at = point.point.along;
  return {
      fmt::format("{} {}{}", c + 1, name(point.kind),
                  point.multiplicity > 1 ? fmt::format(" ({} motions)", point.multiplicity) : ""),
      std::to_string(point.branch + 1),
      number(shown_parameter(point.point), 8),
      at ? number(at->deflection / units.deflection, 7) : "-",
      at ? number(at->force / units.force, 7) : "-",
      fmt::format("{} -> {}", point.unstable_before, point.unstable_after),
      shown(stiffness_at(path.branches[point.branch], point.after), units.stiffness(), 4),
      shown(stiffness_after(task, path, c), units.stiffness(), 4),
      fmt::format("{:.0e}", std::max(point.uncertainty, 1e-16))};
}

std::string critical_table(const Robot& robot, const PathTask& task, const Path& path) {
  const AlongUnits units(robot, task);
  Table table({"critical point", "branch", "parameter", "deflection " + units.deflection_name,
               "force " + units.force_name, "unstable", "stiffness before", "after", "located to"});
  for (std::size_t c = 0; c < path.critical.size(); ++c)
    table.add_row(critical_row(task, path, c, units));
  return table.text() + fmt::format("  stiffness along the path in {}\n", units.stiffness_name());
}

// "stable", "unstable" or both, in the order of the branch.
std::string stability_along(const PathTask& task, const Branch& branch) {
  std::vector<std::string> parts;
  // A branch that leaves another starts with the critical point itself, which is neither.
  for (std::size_t i = branch.from ? 1 : 0; i < branch.points.size(); ++i) {
    const std::string word = branch.points[i].stability(task).stable() ? "stable" : "unstable";
    if (parts.empty() || parts.back() != word) parts.push_back(word);
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string branch_table(const PathTask& task, const Path& path) {
  Table table({"branch", "from", "points", "parameter", "stability", "ends"});
  for (std::size_t b = 0; b < path.branches.size(); ++b) {
    const Branch& branch = path.branches[b];
    if (branch.points.empty()) continue;
    table.add_row({std::to_string(b + 1),
                   branch.from ? fmt::format("critical point {}", *branch.from + 1) : "start",
                   std::to_string(branch.points.size()),
                   fmt::format("{} to {}", number(shown_parameter(branch.points.front()), 5),
                               number(shown_parameter(branch.points.back()), 5)),
                   stability_along(task, branch), ending(path, branch)});
  }
  std::string out = table.text();
  if (path.not_tried > 0)
    out += fmt::format("  no more than {} branches are followed: {} directions were not tried\n",
                       path.branches.size(), path.not_tried);
  return out;
}

// Why there is no equilibrium at parameter 1.
std::string no_target(const Path& path) {
  for (const Branch& branch : path.branches) {
    if (branch.end != BranchEnd::range || branch.points.back().parameter <= 0) continue;
    return fmt::format("The range ends at parameter {}, before the target at 1.\n",
                       number(branch.points.back().parameter, 5));
  }
  return "No branch that was followed comes to parameter 1.\n";
}

std::string target_table(const Robot& robot, const PathTask& task, const Path& path) {
  const AlongUnits units(robot, task);
  Table table({"equilibrium", "branch", "stability", "force " + units.force_name,
               "deflection " + units.deflection_name, "elastic energy J", "potential J"});
  for (std::size_t i = 0; i < path.at_target.size(); ++i) {
    const vjm::TargetPoint& target = path.at_target[i];
    const std::optional<Along>& at = target.point.along;
    table.add_row({std::to_string(i + 1), std::to_string(target.branch + 1),
                   target.point.stability(task).stable() ? "stable" : "unstable",
                   at ? number(at->force / units.force, 7) : "-",
                   at ? number(at->deflection / units.deflection, 7) : "-",
                   number(target.point.equilibrium.energy, 7),
                   shown(target.point.potential, 1, 7)});
  }
  return table.text();
}

Json along_json(const std::optional<Along>& along) {
  if (!along) return nullptr;
  return {{"deflection", along->deflection},
          {"force", along->force},
          {"stiffness", along->stiffness ? Json(*along->stiffness) : Json()}};
}

Json point_json(const Robot& robot, const PathTask& task, const PathPoint& point) {
  Json equilibrium = to_json(robot, point.equilibrium);
  for (const char* key : {"status", "reason", "reached", "load_steps", "newton_corrections"})
    equilibrium.erase(key);
  return {{"parameter", point.parameter},
          {"stable", point.stability(task).stable()},
          {"along", along_json(point.along)},
          {"potential", point.potential ? Json(*point.potential) : Json()},
          {"equilibrium", equilibrium}};
}

Json critical_json(const Robot& robot, const PathTask& task, const CriticalPoint& critical) {
  Json json{{"kind", name(critical.kind)},
            {"branch", critical.branch},
            {"after_point", critical.after},
            {"multiplicity", critical.multiplicity},
            {"uncertainty", critical.uncertainty},
            {"unstable_before", critical.unstable_before},
            {"unstable_after", critical.unstable_after}};
  json["point"] = point_json(robot, task, critical.point);
  return json;
}

// One row of the CSV file, in the units of the robot file.
std::string csv_row(const Robot& robot, const PathTask& task, std::size_t branch,
                    const std::string& kind, const PathPoint& point) {
  const AlongUnits units(robot, task);
  const double length = spatial::parse_unit(robot.units.length).factor;
  const double angle = spatial::parse_unit(robot.units.angle).factor;
  const double force = spatial::parse_unit(robot.units.force).factor;
  const auto cell = [](const std::optional<double>& value, double unit) {
    return value ? fmt::format("{}", *value / unit) : std::string();
  };
  const std::optional<Along>& at = point.along;
  std::vector<std::string> cells{
      std::to_string(branch + 1),
      kind,
      fmt::format("{}", point.parameter),
      cell(at ? std::optional(at->deflection) : std::nullopt, units.deflection),
      cell(at ? std::optional(at->force) : std::nullopt, units.force),
      cell(at ? at->stiffness : std::nullopt, units.stiffness())};
  const spatial::Vector6 d = point.equilibrium.displacement.coordinates();
  const spatial::Vector6 w = point.equilibrium.wrench.coordinates();
  for (int i = 0; i < 6; ++i) cells.push_back(cell(d[i], i < 3 ? length : angle));
  for (int i = 0; i < 6; ++i) cells.push_back(cell(w[i], i < 3 ? force : force * length));
  cells.emplace_back(point.stability(task).stable() ? "1" : "0");
  cells.push_back(std::to_string(point.stability(task).unstable));
  cells.push_back(cell(point.equilibrium.energy, 1));
  cells.push_back(cell(point.potential, 1));
  return fmt::format("{}\n", fmt::join(cells, ","));
}

}  // namespace

namespace {

std::string without_critical_points(const PathTask& task, const Branch& branch) {
  const bool is_stable = !branch.points.empty() && branch.points.back().stability(task).stable();
  return fmt::format("No critical point as far as parameter {} (1 is the whole load): {}.",
                     number(branch.points.empty() ? 0 : shown_parameter(branch.points.back()), 3),
                     is_stable ? "stable" : "unstable from the start");
}

}  // namespace

std::string headline(const Robot& robot, const PathTask& task, const Path& path) {
  if (path.critical.empty()) return without_critical_points(task, path.branches.front());
  const AlongUnits units(robot, task);
  const CriticalPoint& first = path.critical.front();
  const std::optional<Along>& at = first.point.along;
  const std::string place =
      at ? fmt::format("at {} {} and {} {}", number(at->force / units.force, 4), units.force_name,
                       number(at->deflection / units.deflection, 4), units.deflection_name)
         : fmt::format("at {} of the whole load", number(shown_parameter(first.point), 4));
  return fmt::format(
      "First critical point, a {}, {}; beyond it the path is {}. {} critical point{} "
      "in all.",
      name(first.kind), place, first.unstable_after > 0 ? "unstable" : "stable",
      path.critical.size(), path.critical.size() == 1 ? "" : "s");
}

std::string text(const Robot& robot, const PathTask& task, const Path& path) {
  std::string out;
  if (path.critical.empty()) {
    out += "No critical point: stability does not change on the way.\n";
  } else {
    out += critical_table(robot, task, path);
  }
  out += "\n" + branch_table(task, path);
  if (path.at_target.empty()) {
    out += "\n" + no_target(path);
  } else {
    out +=
        "\nEquilibria at parameter 1, the most stable first:\n" + target_table(robot, task, path);
  }
  return out;
}

Json to_json(const Robot& robot, const PathTask& task, const Path& path) {
  Json json{{"branches", Json::array()},
            {"critical_points", Json::array()},
            {"at_target", Json::array()}};
  for (const Branch& branch : path.branches) {
    Json points = Json::array();
    for (const PathPoint& point : branch.points) points.push_back(point_json(robot, task, point));
    json["branches"].push_back({{"from_critical_point", branch.from ? Json(*branch.from) : Json()},
                                {"ends", ending_in_json(path, branch)},
                                {"points", std::move(points)}});
  }
  for (const CriticalPoint& critical : path.critical)
    json["critical_points"].push_back(critical_json(robot, task, critical));
  for (const vjm::TargetPoint& target : path.at_target) {
    Json point = point_json(robot, task, target.point);
    point["branch"] = target.branch;
    json["at_target"].push_back(std::move(point));
  }
  return json;
}

std::string csv(const Robot& robot, const PathTask& task, const Path& path) {
  const AlongUnits units(robot, task);
  const std::string& l = robot.units.length;
  const std::string& a = robot.units.angle;
  const std::string& f = robot.units.force;
  std::string out = io::csv_comment(fmt::format(
      "{}: deflection [{}], force [{}], stiffness [{}] along the path; "
      "dx dy dz [{}], rx ry rz [{}], fx fy fz [{}], mx my mz [{} {}], J",
      robot.name, units.deflection_name, units.force_name, units.stiffness_name(), l, a, f, f, l));
  out +=
      "branch,kind,parameter,deflection,force,stiffness,dx,dy,dz,rx,ry,rz,fx,fy,fz,mx,my,mz,"
      "stable,unstable_directions,elastic_energy,potential\n";
  for (std::size_t b = 0; b < path.branches.size(); ++b) {
    const Branch& branch = path.branches[b];
    for (std::size_t i = 0; i < branch.points.size(); ++i) {
      out += csv_row(robot, task, b, "point", branch.points[i]);
      for (const CriticalPoint& critical : path.critical)
        if (critical.branch == b && critical.after == i)
          out += csv_row(robot, task, b, name(critical.kind), critical.point);
    }
  }
  return out;
}

Json picture(const Robot& robot, const PathTask& task, const Path& path) {
  Json branches = Json::array();
  for (const Branch& branch : path.branches) {
    Json lines = Json::array();
    for (const PathPoint& point : branch.points)
      lines.push_back(chain_lines(robot.manipulator, point.equilibrium));
    branches.push_back(std::move(lines));
  }
  return {{"path", {{"turns", turns(task)}, {"lines", std::move(branches)}}}};
}

Json without_equilibria(Json path) {
  if (!path.is_object()) return path;
  const auto drop = [](Json& point) {
    if (point.is_object()) point.erase("equilibrium");
  };
  for (const char* list : {"branches", "critical_points", "at_target"})
    if (path.contains(list) && path[list].is_array())
      for (Json& entry : path[list]) {
        if (entry.contains("points") && entry["points"].is_array())
          for (Json& point : entry["points"]) drop(point);
        if (entry.contains("point")) drop(entry["point"]);
        drop(entry);
      }
  return path;
}

std::string text(const Robot& robot, const PathTask& task, const vjm::SegmentStudy& study) {
  if (study.values.size() < 2) return "";
  const AlongUnits units(robot, task);
  Table table({"springs per beam", "critical force " + units.force_name, "against the estimate"});
  for (const int multiple : study.without)
    table.add_row({fmt::format("x {}", multiple), "none", "-"});
  for (std::size_t i = 0; i < study.values.size(); ++i)
    table.add_row({fmt::format("x {}", study.multiples[i]),
                   number(study.values[i] / units.force, 7),
                   fmt::format("{:+.2g} %", 100 * study.error(i))});
  std::string out = "\n" + table.text();
  out += fmt::format("  Richardson's estimate for the distributed beam: {} {}{}\n",
                     number(study.extrapolated() / units.force, 7), units.force_name,
                     study.observed_order()
                         ? fmt::format(" (observed order {:.2f})", *study.observed_order())
                         : "");
  if (study.without.empty() && std::abs(study.error(0)) > 0.01)
    out += fmt::format(
        "warning: with the segments of the robot file the first critical force is {:.2g} % {}; "
        "give "
        "the beams more 'segments'\n",
        100 * std::abs(study.error(0)), study.error(0) > 0 ? "too high" : "too low");
  return out;
}

std::string warning(const Robot& robot, const PathTask& task, const vjm::SegmentStudy& study) {
  if (study.without.empty() || study.values.empty()) return "";
  const AlongUnits units(robot, task);
  const double force = study.values.size() > 1 ? study.extrapolated() : study.values.front();
  return fmt::format(
      "warning: a beam buckles at about {} {}, which the path below leaves out: one spring keeps "
      "it straight. Give the beams more 'segments'\n",
      number(force / units.force, 4), units.force_name);
}

Json to_json(const vjm::SegmentStudy& study) {
  if (study.values.size() < 2) return nullptr;
  return {{"multiples_without_critical_point", study.without},
          {"multiples", study.multiples},
          {"critical_force", study.values},
          {"estimate", study.extrapolated()},
          {"observed_order", study.observed_order() ? Json(*study.observed_order()) : Json()},
          {"error_as_given", study.without.empty() ? Json(study.error(0)) : Json()}};
}

}  // namespace kinetostat::report

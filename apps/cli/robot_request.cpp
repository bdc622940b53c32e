#include "kinetostat/apps/cli/robot_request.h"

#include <charconv>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/apps/cli/version.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/io/table_parts.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/uncertainty/deflection_numbers.h"
#include "kinetostat/vjm/uncertainty/stiffness_numbers.h"

namespace kinetostat::apps {
namespace {

using spatial::Dimension;
namespace dimension = spatial::dimension;

// The unit of a joint value depends on whether the joint turns.
Dimension joint_dimension(const vjm::Robot& robot, const std::string& name) {
  for (const vjm::Chain& chain : robot.manipulator.chains())
    for (const vjm::Coordinate& c : chain.coordinates())
      if (name == c.name || name == chain.name() + "." + c.name)
        return is_rotation(c.motion) ? dimension::angle : dimension::length;
  return dimension::none;  // unknown: posture_from_joints says so, with did-you-mean
}

vjm::PostureResult from_joints(const vjm::Robot& robot, const std::string& text) {
  std::map<std::string, double> values;
  for (const std::string& part : split(text)) {
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos)
      throw UsageError("--joints", fmt::format("'{}' is not of the form name=value", part),
                       "Write --joints q1=30,q2=-45");
    const std::string name = part.substr(0, equals);
    const Dimension dimension = joint_dimension(robot, name);
    const std::string value = part.substr(equals + 1);
    if (!values
             .emplace(name, dimension == dimension::none
                                ? 0
                                : quantity("--joints", value, dimension, robot.units))
             .second)
      throw UsageError("--joints", fmt::format("'{}' is given twice", name));
  }
  try {
    return posture_from_joints(robot.manipulator, values);
  } catch (const std::invalid_argument& error) {
    throw UsageError("--joints", error.what());
  }
}

// "node" or "chain.node" of a robot; node names may hold dots themselves.
vjm::NodeLoad find_node(const vjm::Robot& robot, const std::string& name) {
  std::vector<vjm::NodeLoad> found;
  std::vector<std::string> known, words;
  const auto& chains = robot.manipulator.chains();
  for (std::size_t c = 0; c < chains.size(); ++c)
    for (std::size_t n = 0; n < chains[c].nodes().size(); ++n) {
      const std::string& node = chains[c].nodes()[n].name;
      known.push_back(chains.size() == 1 ? node : chains[c].name() + "." + node);
      words.insert(words.end(), {node, known.back()});
      if (name == node || name == chains[c].name() + "." + node)
        found.push_back({.chain = c, .node = n});
    }
  if (found.size() == 1) return found[0];
  if (found.size() > 1)
    throw UsageError("--node-load", fmt::format("the node '{}' is in several chains", name),
                     fmt::format("Write <chain>.{}", name));
  if (known.empty())
    throw UsageError("--node-load", "the robot has no nodes",
                     "Name points of its chains with '- node: {name: ..., at: ...}'");
  const std::string near = common::nearest_spelling(name, words);
  throw UsageError("--node-load", fmt::format("there is no node '{}'", name),
                   near.empty() ? fmt::format("Known are: {}", fmt::join(known, ", "))
                                : fmt::format("Did you mean '{}'?", near));
}

vjm::NodeLoad read_node_load(const vjm::Robot& robot, const std::string& text) {
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos)
    throw UsageError("--node-load", fmt::format("'{}' is not of the form node=Fx,Fy,Fz", text),
                     "Write --node-load elbow=0,0,-500");
  vjm::NodeLoad load = find_node(robot, text.substr(0, equals));
  const spatial::Vector6 values = six_values("--node-load", text.substr(equals + 1),
                                             dimension::force, dimension::moment, robot.units);
  load.force = values.head<3>();
  load.moment = values.tail<3>();
  return load;
}

}  // namespace

void PostureRequest::add_options(OptionList& app) {
  app.add_option("ROBOT", robot_file, "Robot file (YAML)").required();
  add_posture_options(app);
}

void PostureRequest::add_posture_options(OptionList& app) {
  Option at_option = app.add_option("--at", at,
                                    "Pose of the platform, x,y,z or x,y,z,rx,ry,rz (rotation "
                                    "vector), in the units of the file")
                         .type_name("POSE");
  app.add_option("--joints", joints, "Joint values instead, name=value,...")
      .type_name("VALUES")
      .excludes(at_option);
}

vjm::Robot PostureRequest::read(const vjm::LinkOptions& options) const {
  return source ? source(options) : vjm::read_robot(robot_file, options);
}

vjm::Posture PostureRequest::posture(const vjm::Robot& robot) const {
  vjm::PostureResult result;
  if (!at.empty()) {
    const spatial::Vector6 values =
        six_values("--at", at, dimension::length, dimension::angle, robot.units);
    result =
        posture_at(robot.manipulator, {spatial::exp_rotation(values.tail<3>()), values.head<3>()});
  } else if (!joints.empty()) {
    result = from_joints(robot, joints);
  } else {
    result = posture_from_joints(robot.manipulator, {});
  }
  if (!result.reached) throw common::NoConvergence(result.reason);
  return result.posture;
}

std::vector<std::string> beyond_ranges(const vjm::Robot& robot, const vjm::Posture& posture) {
  constexpr double rounding = 1e-9;
  std::vector<std::string> words;
  const auto& chains = robot.manipulator.chains();
  for (std::size_t c = 0; c < chains.size(); ++c)
    for (Eigen::Index k = 0; k < chains[c].size(); ++k) {
      const vjm::Coordinate& joint = chains[c].coordinates()[static_cast<std::size_t>(k)];
      if (!joint.range) continue;
      const auto [least, most] = *joint.range;
      const double value = posture.coordinates[c][k], margin = rounding * (most - least);
      if (value >= least - margin && value <= most + margin) continue;
      const std::string& name = is_rotation(joint.motion) ? robot.units.angle : robot.units.length;
      const double unit = spatial::parse_unit(name).factor;
      words.push_back(
          fmt::format("joint {} stands at {:.6g} {}, outside of its range {:.6g} to {:.6g} {}",
                      chains.size() == 1 ? joint.name : chains[c].name() + "." + joint.name,
                      value / unit, name, least / unit, most / unit, name));
    }
  return words;
}

void warn_beyond_ranges(const vjm::Robot& robot, const vjm::Posture& posture, const Run& run) {
  for (const std::string& words : beyond_ranges(robot, posture)) run.warn(words);
}

std::optional<vjm::Posture> PostureRequest::posture_like(const vjm::Posture& known,
                                                         const vjm::Robot& of,
                                                         const vjm::Robot& other) const {
  if (!have_other_postures(of)) return known;
  try {
    return posture(other);
  } catch (const common::NoConvergence&) {
    return std::nullopt;
  }
}

void LoadRequest::add_options(OptionList& app) {
  add_load_options(app);
  app.add_option("--move,--along", move,
                 "Displacement to hold instead, dx,dy,dz or dx,dy,dz,rx,ry,rz, base axes")
      .type_name("DISPLACEMENT")
      .excludes("--wrench");
}

void LoadRequest::add_load_options(OptionList& app) {
  Option wrench_option = app.add_option("--wrench", wrench,
                                        "Load on the platform, Fx,Fy,Fz or Fx,Fy,Fz,Mx,My,Mz, base "
                                        "axes, in the units of the file")
                             .type_name("WRENCH");
  app.add_option("--point", point, "Where it acts, x,y,z on the platform (default: its origin)")
      .type_name("POINT")
      .needs(wrench_option);
  app.add_option("--node-load", node_loads,
                 "Load at a node of a chain, base axes, node=Fx,Fy,Fz[,Mx,My,Mz] with "
                 "chain.node where several chains have the node; may be repeated")
      .type_name("LOAD")
      .hide_default()
      .one_at_a_time();
}

vjm::Load LoadRequest::load(const vjm::Robot& robot) const {
  vjm::Load load;
  if (!wrench.empty()) {
    const spatial::Vector6 values =
        six_values("--wrench", wrench, dimension::force, dimension::moment, robot.units);
    load.force = values.head<3>();
    load.moment = values.tail<3>();
  }
  if (!point.empty())
    load.point_on_platform = three_values("--point", point, dimension::length, robot.units);
  for (const std::string& text : node_loads) load.nodes.push_back(read_node_load(robot, text));
  return load;
}

vjm::PathTask LoadRequest::task(const vjm::Robot& robot) const {
  vjm::PathTask task;
  task.platform_held = !move.empty();
  if (!task.platform_held) {
    task.growing = load(robot);
    return task;
  }
  task.displacement = six_values("--move", move, dimension::length, dimension::angle, robot.units);
  task.constant = load(robot).nodes;
  return task;
}

vjm::Equilibrium LoadRequest::solve(const vjm::Robot& robot, const vjm::Posture& posture) const {
  const vjm::Load acting = load(robot);
  if (move.empty()) return equilibrium_under_load(robot.manipulator, posture, acting);
  const spatial::Vector6 displacement =
      six_values("--move", move, dimension::length, dimension::angle, robot.units);
  return equilibrium_at_pose(robot.manipulator, posture,
                             spatial::displaced(posture.platform, displacement), {}, acting.nodes);
}

void UncertaintyRequest::add_options(OptionList& app) {
  Option exact = app.add_flag("--no-uncertainty", none,
                              "Take all numbers of the robot file as exact, which is quicker");
  app.add_option("--draws", draws,
                 "So many robots drawn from what its uncertain numbers may be, beside first order")
      .type_name("N")
      .between(2, 1000000)
      .excludes(exact)
      .hide_default();
  app.add_option("--seed", seed, "Of the draws, 1 unless given").hide_default();
}

void UncertaintyRequest::add_drawn_options(OptionList& app) {
  const Option table =
      app.add_option("--drawn", drawn,
                     "Table of these draws: those that it has, of a part or of a run that was "
                     "stopped, are taken from it, others are added")
          .type_name("FILE");
  app.add_option("--part", part, "Only the i-th of n parts of the draws, into --drawn, for join")
      .type_name("i/n")
      .needs(table);
}

namespace {

// All that decides what the draws are, but for the part.
std::string title_of_draws(const UncertaintyRequest& request, const vjm::Robot& robot,
                           const Run& run) {
  io::Json options = run.options();
  options.erase("part");
  options.erase("drawn");
  return io::title_of_table("draws",
                            this_program() + report::provenance(robot).dump() + options.dump(),
                            static_cast<std::size_t>(request.draws), "draws");
}

std::optional<Eigen::VectorXd> numbers_in(const std::string& line,
                                          const std::filesystem::path& file) {
  const std::vector<std::string> cells = split(line.substr(0, line.size() - 1));
  if (cells.size() == 2 && cells[1] == "none") return std::nullopt;
  Eigen::VectorXd numbers(static_cast<Eigen::Index>(cells.size()) - 1);
  for (std::size_t i = 1; i < cells.size(); ++i) {
    double& number = numbers[static_cast<Eigen::Index>(i) - 1];
    const auto [end, error] =
        std::from_chars(cells[i].data(), cells[i].data() + cells[i].size(), number);
    if (error != std::errc() || end != cells[i].data() + cells[i].size())
      throw common::InputError(file, fmt::format("'{}' is no number", cells[i]),
                               "Remove the file: the draws are computed anew");
  }
  return numbers;
}

std::string line_of_draw(std::size_t number, const std::optional<Eigen::VectorXd>& numbers) {
  if (!numbers) return fmt::format("{},none\n", number);
  return fmt::format("{},{}\n", number, fmt::join(numbers->begin(), numbers->end(), ","));
}

// The table as it was, or an empty one.
io::NumberedTable table_of_draws(const std::string& file, const std::string& title) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return {.title = title, .header = "draw,numbers\n"};
  io::NumberedTable table = io::read_numbered_table(file);
  if (table.title != title)
    throw common::InputError(file,
                             "these are draws of another robot, of other options or by another "
                             "build of the program",
                             "Give --drawn a new file, or remove this one");
  return table;
}

// None where others than those of the part are missing.
std::optional<vjm::Draws> draws_by_table(const UncertaintyRequest& request, const vjm::Robot& robot,
                                         const vjm::Computation& compute, Run& run) {
  const auto count = static_cast<std::size_t>(request.draws);
  const io::Part part = part_of("--part", request.part);
  io::NumberedTable table = table_of_draws(request.drawn, title_of_draws(request, robot, run));
  std::vector<std::size_t> wanted;
  for (std::size_t i = 0; i < count; ++i)
    if (part.has(i) && !table.lines.contains(i)) wanted.push_back(i);
  for (const auto& [number, numbers] :
       compute_draws(robot, compute, count, request.seed, wanted, run.threads(), run.progress()))
    table.lines[number] = line_of_draw(number, numbers);
  // An empty part is a table, too, for join.
  if (!wanted.empty() || table.lines.empty()) io::write_atomically(request.drawn, table.text());
  if (table.lines.size() < count) {
    run.remark(fmt::format("{} of {} draws are in {}", table.lines.size(), count, request.drawn));
    return std::nullopt;
  }
  vjm::DrawnNumbers all;
  for (const auto& [number, line] : table.lines) all[number] = numbers_in(line, request.drawn);
  return vjm::draws_of(count, request.seed, all);
}

}  // namespace

std::optional<vjm::Uncertainty> UncertaintyRequest::of(const vjm::Robot& robot,
                                                       const vjm::Computation& compute,
                                                       Run& run) const {
  if (!drawn.empty() && draws == 0)
    throw UsageError("--drawn", "no draws are asked for", "Give --draws 1000");
  if (none) return std::nullopt;
  if (robot.sources.empty()) {
    if (draws > 0 || required)
      throw UsageError(draws > 0 ? "--draws" : "the uncertainty",
                       "the robot file says of no number that it is uncertain",
                       "Write some as {value: 2.0e4, sd: 5 %}");
    return std::nullopt;
  }
  try {
    vjm::Uncertainty uncertainty{propagate(robot, compute, run.threads(), run.progress())};
    if (draws > 0)
      uncertainty.draws = drawn.empty() ? vjm::draw(robot, compute, static_cast<std::size_t>(draws),
                                                    seed, run.threads(), run.progress())
                                        : draws_by_table(*this, robot, compute, run);
    return uncertainty;
  } catch (const common::NoConvergence& error) {
    if (required) throw;
    run.warn(error.what());  // the result itself stands
    return std::nullopt;
  }
}

std::optional<vjm::Uncertainty> UncertaintyRequest::of(const vjm::Robot& robot,
                                                       const PostureRequest& request,
                                                       const vjm::Posture& posture,
                                                       const spatial::Vector3& direction,
                                                       Run& run) const {
  const auto numbers = [&](const vjm::Robot& other) -> std::optional<Eigen::VectorXd> {
    const auto own = request.posture_like(posture, robot, other);
    return own ? vjm::stiffness_numbers(other, *own, direction) : std::nullopt;
  };
  return of(robot, numbers, run);
}

std::optional<vjm::Uncertainty> UncertaintyRequest::of(
    const vjm::Robot& robot, const PostureRequest& request, const vjm::Posture& posture,
    const LoadRequest& load, const vjm::Equilibrium& equilibrium, Run& run) const {
  if (equilibrium.status != vjm::EquilibriumStatus::converged) return std::nullopt;
  const auto numbers = [&](const vjm::Robot& other) -> std::optional<Eigen::VectorXd> {
    const auto own = request.posture_like(posture, robot, other);
    return own ? vjm::deflection_numbers(load.solve(other, *own)) : std::nullopt;
  };
  return of(robot, numbers, run);
}

vjm::SegmentCheck check_segments(const vjm::Robot& robot, const PostureRequest& posture,
                                 const LoadRequest& load, vjm::Equilibrium& found) {
  vjm::SegmentCheck check;
  if (!robot.has_beams || found.status != vjm::EquilibriumStatus::converged) return check;
  const bool held = load.task(robot).platform_held;
  const auto solved_with = [&](int multiple) {
    const vjm::Robot finer = posture.read({.segment_multiple = multiple});
    return load.solve(finer, posture.posture(finer));
  };
  check.lumping_error = vjm::lumping_error(found, solved_with(2), held);
  check.hidden_buckling =
      take_stability(solved_with(vjm::SegmentCheck::stability_multiple), held, found);
  return check;
}

void stop_short_unless_stable(const LoadRequest& request, const vjm::Robot& robot,
                              const vjm::Equilibrium& equilibrium, Run& run) {
  if (equilibrium.status != vjm::EquilibriumStatus::converged) {
    run.stop_short(equilibrium.reason);
    return;
  }
  const bool held = request.task(robot).platform_held;
  if ((held ? equilibrium.held : equilibrium.free).stable()) return;
  run.stop_short(
      fmt::format("this equilibrium is unstable, the manipulator would leave it; 'kinetostat trace "
                  "{} ...' with "
                  "the same load shows where the stable path ends",
                  robot.file.string()));
}

}  // namespace kinetostat::apps

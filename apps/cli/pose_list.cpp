#include "kinetostat/apps/cli/pose_list.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/io/csv.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/manipulator/joint_place.h"

namespace kinetostat::apps {
namespace {

using vjm::pose_columns;
using vjm::wrench_columns;
namespace dimension = spatial::dimension;

constexpr std::size_t most_poses = 20'000'000;

spatial::Pose pose_of(const spatial::Vector6& coordinates) {
  return {spatial::exp_rotation(coordinates.tail<3>()), coordinates.head<3>()};
}

// "-70:120:20" or "0".
std::vector<double> read_axis(const std::string& option, const std::string& name,
                              const std::string& text, const spatial::Dimension& what,
                              const spatial::UnitSystem& units) {
  const std::vector<std::string> parts = split(text, ':');
  if (parts.size() == 1) return {quantity(option, text, what, units)};
  if (parts.size() != 3)
    throw UsageError(option, fmt::format("'{}={}' is not from:to:points", name, text),
                     fmt::format("Write {}=-50:50:11, or {}=10 for one value", name, name));
  const double from = quantity(option, parts[0], what, units);
  const double to = quantity(option, parts[1], what, units);
  const double count = quantity(option, parts[2], dimension::none, units);
  if (!(count >= 2 && count <= most_poses) || count != std::floor(count))
    throw UsageError(option, fmt::format("'{}' is not a number of points from 2", parts[2]));
  std::vector<double> values(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = from + (to - from) * static_cast<double>(i) / (count - 1);
  return values;
}

// Where a column of the file goes: a coordinate (0 to 5), a component of the wrench (6 to 11) or a
// joint that is held, by its full name; and what its numbers are worth in SI.
struct Column {
  std::size_t place = 0;
  std::string joint = {};
  double factor = 1;
  std::size_t number = 0;  // in the table

  bool is_wrench() const { return joint.empty() && place >= 6; }
};

struct NamedColumn {
  Column column;
  spatial::Dimension dimension;
};

// Nothing where neither a column nor a drive has the name.
std::optional<NamedColumn> column_named(const std::string& name,
                                        const std::vector<std::string>& known,
                                        const vjm::Manipulator& manipulator) {
  static const std::array<spatial::Dimension, 4> dimensions = {dimension::length, dimension::angle,
                                                               dimension::force, dimension::moment};
  const auto at =
      static_cast<std::size_t>(std::find(known.begin(), known.end(), name) - known.begin());
  if (at < 12) return NamedColumn{{.place = at}, dimensions[at / 3]};
  try {
    const vjm::JointPlace joint = find_joint(manipulator, name);
    const vjm::Coordinate& coordinate = coordinate_at(manipulator, joint);
    if (coordinate.role == vjm::Role::actuated)
      return NamedColumn{{.joint = full_name(manipulator, joint)},
                         is_rotation(coordinate.motion) ? dimension::angle : dimension::length};
  } catch (const std::invalid_argument&) {  // the caller says what is known
  }
  return std::nullopt;
}

// Columns of a pose and its wrench, then actuated joints as they may be called.
std::vector<std::string> known_columns(const vjm::Manipulator& manipulator) {
  std::vector<std::string> known(pose_columns.begin(), pose_columns.end());
  known.insert(known.end(), wrench_columns.begin(), wrench_columns.end());
  for (const vjm::JointPlace& joint : actuated_joints(manipulator)) {
    known.push_back(full_name(manipulator, joint));
    if (manipulator.size() == 1) known.push_back(coordinate_at(manipulator, joint).name);
  }
  return known;
}

[[noreturn]] void refuse_column(const io::CsvTable& table, const std::string& column,
                                const std::string& what, const std::string& cure) {
  throw common::InputError({.file = table.file(),
                            .line = table.header_line(),
                            .key = column,
                            .what = what,
                            .cure = cure});
}

// "x", or "x [m]" with a unit of its own.
Column read_column(const io::CsvTable& table, const std::string& column, const vjm::Robot& robot) {
  const std::vector<std::string> known = known_columns(robot.manipulator);
  const std::size_t bracket = column.find('[');
  std::string name = column.substr(0, bracket);
  name.erase(name.find_last_not_of(' ') + 1);
  std::optional<NamedColumn> found = column_named(name, known, robot.manipulator);
  if (!found) {
    const std::string near = common::nearest_spelling(name, known);
    refuse_column(table, column, "this column is not known in a path",
                  near.empty() ? fmt::format("Known are {}", fmt::join(known, ", "))
                               : fmt::format("Did you mean '{}'?", near));
  }
  const spatial::Dimension what = found->dimension;
  double& factor = found->column.factor;
  if (bracket == std::string::npos) {
    factor = spatial::parse_quantity("1", what, robot.units.unit_for(what));
    return found->column;
  }
  if (!column.ends_with(']'))
    refuse_column(table, column, "the unit is not closed", "Write 'x [mm]'");
  const std::string unit = column.substr(bracket + 1, column.size() - bracket - 2);
  try {
    factor = spatial::parse_quantity("1 " + unit, what);
    return found->column;
  } catch (const std::invalid_argument& error) {
    refuse_column(table, column, error.what(), "");
  }
}

bool is_one_chain(const vjm::Robot& robot) {
  return robot.manipulator.size() == 1 && robot.manipulator.is_parallel();
}

// Joints, and no coordinate of the pose.
bool are_joints_alone(const std::vector<Column>& columns) {
  const auto is_joint = [](const Column& c) { return !c.joint.empty(); };
  return std::any_of(columns.begin(), columns.end(), is_joint) &&
         std::all_of(columns.begin(), columns.end(),
                     [&](const Column& c) { return is_joint(c) || c.is_wrench(); });
}

// A table that `map` has written has results from `state` on; a `pose` before that is the number of
// the row, and where there are joints, these lead to the poses beside them.
std::vector<Column> read_columns(const io::CsvTable& table, const vjm::Robot& robot) {
  std::vector<Column> columns;
  std::set<std::pair<std::string, std::size_t>> places;
  const std::optional<std::size_t> state = table.find("state");
  for (std::size_t number = 0; number < state.value_or(table.columns().size()); ++number) {
    const std::string& name = table.columns()[number];
    if (state && name == "pose") continue;
    columns.push_back(read_column(table, name, robot));
    columns.back().number = number;
    if (!places.insert({columns.back().joint, columns.back().place}).second)
      refuse_column(table, name, "another column means the same", "Keep one of them");
  }
  const auto is_of_pose = [](const Column& column) { return column.joint.empty(); };
  if (state && !std::all_of(columns.begin(), columns.end(), is_of_pose))
    std::erase_if(columns, is_of_pose);
  const bool of_joints = are_joints_alone(columns);
  if (std::all_of(columns.begin(), columns.end(), [](const Column& c) { return c.is_wrench(); }) ||
      (of_joints && !is_one_chain(robot)))
    throw common::InputError({.file = table.file(),
                              .line = table.header_line(),
                              .what = "no column states the pose",
                              .cure = of_joints
                                          ? "Give at least one of x, y, z, rx, ry, rz: drives "
                                            "alone say where a robot of one chain goes"
                                          : "Give at least one of x, y, z, rx, ry, rz, or "
                                            "the drives"});
  return columns;
}

// Values of a grid along a coordinate of the pose or of a drive.
struct Axis {
  Column column;
  std::vector<double> values;
};

// In the order of the text.
std::vector<Axis> read_axes(const std::string& option, const std::string& grid,
                            const vjm::Robot& robot) {
  const std::vector<std::string> known = known_columns(robot.manipulator);
  std::vector<Axis> axes;
  for (const std::string& part : split(grid)) {
    const std::size_t equals = part.find('=');
    const std::string name = part.substr(0, equals);
    const auto found = column_named(name, known, robot.manipulator);
    if (equals == std::string::npos || !found || found->column.is_wrench()) {
      const std::string near =
          equals == std::string::npos ? "" : common::nearest_spelling(name, known);
      throw UsageError(
          option,
          fmt::format("'{}' does not start with x=, y=, z=, rx=, ry=, rz= or the name of a drive",
                      part),
          near.empty() ? fmt::format("Write {} x=-50:50:11,y=-50:50:11,z=0", option)
                       : fmt::format("Did you mean '{}'?", near));
    }
    for (const Axis& other : axes)
      if (other.column.joint == found->column.joint && other.column.place == found->column.place)
        throw UsageError(option, fmt::format("'{}' is given twice", name));
    axes.push_back({found->column, read_axis(option, name, part.substr(equals + 1),
                                             found->dimension, robot.units)});
    if (axes.back().column.joint.empty() != axes.front().column.joint.empty())
      throw UsageError(option, "a grid is of coordinates of the platform or of drives, not of both",
                       "Leave out the ones or the others");
  }
  return axes;
}

// A pose that joints alone lead to.
vjm::TargetPose by_joints(const vjm::Robot& robot, const vjm::Load& load,
                          std::map<std::string, double> joints) {
  vjm::TargetPose target{
      .platform = {}, .load = load, .held = std::move(joints), .is_by_joints = true};
  target.platform = posture_to(robot.manipulator, target).posture.platform;
  return target;
}

// Each coordinate of the position that no column has.
std::vector<std::string> missing_places(const std::string& file,
                                        const std::vector<Column>& columns) {
  std::vector<std::string> notes;
  for (std::size_t place = 0; place < 3; ++place)
    if (std::none_of(columns.begin(), columns.end(), [place](const Column& column) {
          return column.joint.empty() && column.place == place;
        }))
      notes.push_back(
          fmt::format("{} has no column {}: it is 0 in every pose", file, pose_columns[place]));
  return notes;
}

bool has_wrench(const vjm::Load& load) { return !load.force.isZero(0) || !load.moment.isZero(0); }

// Of poses of a part, their numbers.
void number_poses(const io::Part& part, vjm::PoseList& list) {
  if (part.is_whole()) return;
  for (std::size_t i = 0; i < list.poses.size(); ++i)
    list.numbers.push_back(part.number - 1 + i * part.count);
  list.shape = {list.poses.size(), 1, 1, 1, 1, 1};
}

}  // namespace

vjm::PoseList read_grid(const std::string& grid, const vjm::Robot& robot, const vjm::Load& load,
                        const std::string& option, const io::Part& part) {
  std::vector<Axis> axes = read_axes(option, grid, robot);
  const bool of_joints = !axes.front().column.joint.empty();
  if (of_joints && !is_one_chain(robot))
    throw UsageError(option, "a grid of drives is for a robot of one chain",
                     "Give coordinates of the platform, x, y, z, rx, ry, rz");
  if (!of_joints)
    std::sort(axes.begin(), axes.end(),
              [](const Axis& a, const Axis& b) { return a.column.place < b.column.place; });
  vjm::PoseList list;
  double count = 1;
  for (const Axis& axis : axes) {
    if (!of_joints) list.shape[axis.column.place] = axis.values.size();
    count *= static_cast<double>(axis.values.size());
  }
  if (count > most_poses)
    throw UsageError(option, fmt::format("it has {:.3g} poses, more than {}", count, most_poses));
  list.whole = static_cast<std::size_t>(count);
  list.has_wrench = has_wrench(load);
  list.poses.reserve(list.whole / part.count + 1);
  for (std::size_t n = part.number - 1; n < list.whole; n += part.count) {
    spatial::Vector6 coordinates = spatial::Vector6::Zero();
    std::map<std::string, double> joints;
    std::size_t rest = n;
    for (auto axis = axes.rbegin(); axis != axes.rend(); ++axis) {
      const double value = axis->values[rest % axis->values.size()];
      rest /= axis->values.size();
      if (of_joints)
        joints[axis->column.joint] = value;
      else
        coordinates[static_cast<Eigen::Index>(axis->column.place)] = value;
    }
    list.poses.push_back(of_joints ? by_joints(robot, load, std::move(joints))
                                   : vjm::TargetPose{pose_of(coordinates), load});
  }
  if (of_joints) list.shape[0] = list.whole;
  number_poses(part, list);
  return list;
}

vjm::PoseList read_path(const std::string& file, const vjm::Robot& robot, const vjm::Load& load,
                        const io::Part& part) {
  const io::CsvTable table = io::read_table(file);
  const std::vector<Column> columns = read_columns(table, robot);
  const bool of_joints = are_joints_alone(columns);
  const bool has_wrenches = std::any_of(columns.begin(), columns.end(),
                                        [](const Column& column) { return column.is_wrench(); });
  if (has_wrenches && has_wrench(load))
    throw UsageError("--wrench", fmt::format("'{}' has loads of its own", file),
                     "Leave --wrench out, or the columns fx to mz");
  vjm::PoseList list;
  if (!of_joints) list.notes = missing_places(file, columns);
  list.shape[0] = table.rows();
  list.whole = table.rows();
  for (std::size_t row = 0; row < table.rows(); ++row) {
    spatial::Vector6 coordinates = spatial::Vector6::Zero(), wrench = spatial::Vector6::Zero();
    std::map<std::string, double> held;
    for (const Column& column : columns) {
      const double value = column.factor * table.number(row, column.number);
      const auto i = static_cast<Eigen::Index>(column.place % 6);
      if (!column.joint.empty())
        held[column.joint] = value;
      else
        (column.is_wrench() ? wrench : coordinates)[i] = value;
    }
    vjm::TargetPose target = of_joints
                                 ? by_joints(robot, load, std::move(held))
                                 : vjm::TargetPose{pose_of(coordinates), load, std::move(held)};
    if (has_wrenches) {
      target.load.force = wrench.head<3>();
      target.load.moment = wrench.tail<3>();
    }
    list.has_wrench = list.has_wrench || has_wrench(target.load);
    if (part.has(row)) list.poses.push_back(std::move(target));
  }
  number_poses(part, list);
  return list;
}

void remark_on(const vjm::PoseList& list, const Run& run) {
  for (const std::string& note : list.notes) run.remark(note);
}

}  // namespace kinetostat::apps

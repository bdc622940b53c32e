#include "kinetostat/report/manipulators/map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/io/csv.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/manipulators/pose.h"
#include "kinetostat/report/manipulators/skeleton.h"
#include "kinetostat/report/text/text.h"
#include "kinetostat/vjm/manipulator/joint_place.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::report {
namespace {

using io::Json;
using vjm::MapPoint;
using vjm::MapState;

constexpr std::array all_states{MapState::reached, MapState::free_motion, MapState::unstable,
                                MapState::no_equilibrium, MapState::unreachable};

std::ptrdiff_t count_of(const std::vector<MapPoint>& points, MapState state) {
  return std::count_if(points.begin(), points.end(),
                       [state](const MapPoint& p) { return p.state == state; });
}

// A number as it is written in tables: 12 significant digits, nothing where there is none.
std::string cell(double value) { return std::isnan(value) ? "" : fmt::format("{:.12g}", value); }

std::string with_unit(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : fmt::format("{} [{}]", name, unit);
}

// A joint that leads to the poses, by itself or with others, in the unit of the robot file.
struct JointColumn {
  std::string joint, name, unit;
  double factor;

  double value(const Map& map, std::size_t pose) const {
    return map.list.poses[pose].held.at(joint) / factor;
  }
};

std::vector<JointColumn> joints_of(const Map& map) {
  std::vector<JointColumn> columns;
  if (map.list.poses.empty() || !map.list.poses.front().is_by_joints) return columns;
  for (const auto& [joint, value] : map.list.poses.front().held) {
    const std::string unit = joint_unit(map.robot, joint);
    columns.push_back(
        {joint, joint_column(map.robot, joint), unit, spatial::parse_unit(unit).factor});
  }
  return columns;
}

std::string header(const Map& map) {
  std::vector<std::string> headings;
  headings.reserve(vjm::pose_columns.size() + 1 + map.indices.size());
  for (const std::string name : vjm::pose_columns)
    headings.push_back(io::csv_cell(
        with_unit(name, name.size() == 1 ? map.robot.units.length : map.robot.units.angle)));
  for (const JointColumn& joint : joints_of(map))
    headings.push_back(io::csv_cell(with_unit(joint.name, joint.unit)));
  headings.emplace_back("state");
  for (const NamedIndex& index : map.indices)
    headings.push_back(io::csv_cell(with_unit(index.name, index.unit)));
  return fmt::format("{}\n", fmt::join(headings, ","));
}

// "q2 = 0.4, q3 = 1" or the coordinates of the platform.
// "1, 2, 3"
std::string numbers_in(const std::string& unit, const spatial::Vector3& values) {
  const double factor = spatial::parse_unit(unit).factor;
  return fmt::format("{}, {}, {}", number(values[0] / factor), number(values[1] / factor),
                     number(values[2] / factor));
}

// Position and, where it is turned, rotation vector of a pose, in units of the file.
struct PlaceWords {
  std::string position, rotation;

  PlaceWords(const Map& map, std::size_t number_of_pose) {
    const spatial::Vector6 c = coordinates_of(map.list.poses[number_of_pose].platform);
    position = numbers_in(map.robot.units.length, c.head<3>());
    if (!c.tail<3>().isZero(1e-12)) rotation = numbers_in(map.robot.units.angle, c.tail<3>());
  }
};

std::string joints_text(const Map& map, std::size_t number_of_pose) {
  std::vector<std::string> values;
  for (const JointColumn& joint : joints_of(map))
    values.push_back(fmt::format("{} = {}", joint.name, number(joint.value(map, number_of_pose))));
  return fmt::format("{}", fmt::join(values, ", "));
}

std::string place_text(const Map& map, std::size_t number_of_pose) {
  if (!joints_of(map).empty()) return joints_text(map, number_of_pose);
  const PlaceWords at(map, number_of_pose);
  return at.rotation.empty() ? at.position : at.position + ", " + at.rotation;
}

// "(500, 200, 0) mm, (0, 90, 0) deg"; of joints "(q1 = 30, q2 = 60)".
std::string place_in_units(const Map& map, std::size_t number_of_pose) {
  if (!joints_of(map).empty()) return fmt::format("({})", joints_text(map, number_of_pose));
  const PlaceWords at(map, number_of_pose);
  const std::string position = fmt::format("({}) {}", at.position, map.robot.units.length);
  return at.rotation.empty()
             ? position
             : fmt::format("{}, ({}) {}", position, at.rotation, map.robot.units.angle);
}

std::vector<std::string> range_row(const Map& map, std::size_t k) {
  const NamedIndex& index = map.indices[k];
  const vjm::MapRange range = range_of(map.points, k);
  if (range.count == 0) return {index.name, index.unit, "-", "-", "-", "-", "-"};
  const auto shown = [&](double v) { return number(v / index.factor, 6); };
  return {index.name,
          index.unit,
          shown(range.smallest),
          place_text(map, range.smallest_at),
          shown(range.mean),
          shown(range.largest),
          place_text(map, range.largest_at)};
}

Json place_json(const Map& map, std::size_t number_of_pose) {
  Json json = to_json(map.list.poses[number_of_pose].platform);
  if (!joints_of(map).empty()) json["joints"] = map.list.poses[number_of_pose].held;
  return json;
}

Json range_json(const Map& map, std::size_t k) {
  const vjm::MapRange range = range_of(map.points, k);
  Json json{{"index", map.indices[k].name}, {"finite_values", range.count}};
  if (range.count == 0) return json;
  json["smallest"] = range.smallest;
  json["smallest_at"] = place_json(map, range.smallest_at);
  json["mean"] = range.mean;
  json["largest"] = range.largest;
  json["largest_at"] = place_json(map, range.largest_at);
  return json;
}

// Values of one index at all poses, in its unit.
std::vector<double> values_of(const Map& map, std::size_t k) {
  std::vector<double> values;
  for (const MapPoint& point : map.points)
    values.push_back(point.values[k] / map.indices[k].factor);
  return values;
}

// A block of cells: how many along each of its directions, and how far apart neighbours are in the
// list of poses.
struct Cells {
  int directions = 0;
  std::array<std::size_t, 3> count{1, 1, 1};
  std::array<int, 3> step{0, 0, 0};
};

Cells cells_of(const vjm::PoseList& list) {
  const auto& shape = list.shape;
  Cells cells;
  if (shape[3] * shape[4] * shape[5] > 1) {  // the platform turns: points alone
    cells.count[0] = list.poses.size();
    cells.step[0] = 1;
    return cells;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (shape[i] == 1) continue;
    const auto at = static_cast<std::size_t>(cells.directions++);
    cells.count[at] = shape[i] - 1;
    cells.step[at] = 1;
    for (std::size_t k = 5; k > i; --k) cells.step[at] *= static_cast<int>(shape[k]);
  }
  return cells;
}

void add_cells(const vjm::PoseList& list, io::VtuGrid& grid) {
  constexpr io::VtuCell kinds[] = {io::VtuCell::vertex, io::VtuCell::line, io::VtuCell::quad,
                                   io::VtuCell::hexahedron};
  // VTK's order of corners: around the first face, then around the opposite one.
  constexpr int corners[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                 {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  const Cells cells = cells_of(list);
  grid.cell = kinds[cells.directions];
  grid.nodes_per_cell = 1 << cells.directions;
  const auto offset = [&cells](int a, int b, int c) {
    return a * cells.step[0] + b * cells.step[1] + c * cells.step[2];
  };
  for (std::size_t c = 0; c < cells.count[2]; ++c)
    for (std::size_t b = 0; b < cells.count[1]; ++b)
      for (std::size_t a = 0; a < cells.count[0]; ++a)
        for (int k = 0; k < grid.nodes_per_cell; ++k)
          grid.connectivity.push_back(
              offset(static_cast<int>(a), static_cast<int>(b), static_cast<int>(c)) +
              offset(corners[k][0], corners[k][1], corners[k][2]));
}

}  // namespace

namespace {

// Where no pose is reached that may be for its orientation, which a robot of few joints does not
// choose.
std::string hint(const Map& map) {
  const auto unreachable = static_cast<std::size_t>(count_of(map.points, MapState::unreachable));
  if (unreachable < map.points.size() || map.robot.manipulator.size() > 1 ||
      !joints_of(map).empty())
    return "";
  const auto drives = actuated_joints(map.robot.manipulator);
  if (drives.empty()) return "";
  return fmt::format(
      " Where rx, ry and rz are not given a pose has no rotation. A grid of joints reaches all of "
      "its poses: --grid {}=FROM:TO:POINTS,...",
      joint_column(map.robot, full_name(map.robot.manipulator, drives.back())));
}

}  // namespace

std::string joint_column(const vjm::Robot& robot, const std::string& joint) {
  std::string name =
      coordinate_at(robot.manipulator, vjm::find_joint(robot.manipulator, joint)).name;
  const auto is_name = [&name](const char* column) { return name == column; };
  if (std::any_of(vjm::pose_columns.begin(), vjm::pose_columns.end(), is_name) ||
      std::any_of(vjm::wrench_columns.begin(), vjm::wrench_columns.end(), is_name))
    return joint;
  try {
    vjm::find_joint(robot.manipulator, name);
    return name;
  } catch (const std::invalid_argument&) {  // in several chains
    return joint;
  }
}

std::string joint_unit(const vjm::Robot& robot, const std::string& joint) {
  const vjm::JointPlace place = vjm::find_joint(robot.manipulator, joint);
  return is_rotation(coordinate_at(robot.manipulator, place).motion) ? robot.units.angle
                                                                     : robot.units.length;
}

std::string headline(const Map& map) {
  if (map.indices.empty()) return fmt::format("{} poses.", map.points.size());
  const NamedIndex& index = map.indices.front();
  const vjm::MapRange range = range_of(map.points, 0);
  if (range.count == 0)
    return fmt::format("No value of {} at any of {} poses.{}", index.name, map.points.size(),
                       hint(map));
  const std::string unit = index.unit.empty() ? "" : " " + index.unit;
  const auto shown = [&](double v) { return number(v / index.factor, 4); };
  if (map.points.size() == 1)
    return fmt::format("{} {}{} at {}.", index.name, shown(range.mean), unit,
                       place_in_units(map, range.smallest_at));
  return fmt::format("{} {} to {}{}, {}{} in the mean, over {} of {} poses; least at {}.",
                     index.name, shown(range.smallest), shown(range.largest), unit,
                     shown(range.mean), unit, range.count, map.points.size(),
                     place_in_units(map, range.smallest_at));
}

std::string text(const Map& map) {
  std::string out = fmt::format("{}: {} pose{}", map.robot.name, map.points.size(),
                                map.points.size() == 1 ? "" : "s");
  for (const MapState state : all_states)
    if (const auto count = count_of(map.points, state); count != 0)
      out += fmt::format(", {} {}", count, to_string(state));
  Table table({"index", "unit", "smallest", "smallest at", "mean", "largest", "largest at"});
  for (std::size_t k = 0; k < map.indices.size(); ++k) table.add_row(range_row(map, k));
  return out + "\n\n" + table.text();
}

Json to_json(const Map& map) {
  Json json{{"inputs", provenance(map.robot)},
            {"headline", headline(map)},
            {"poses", map.points.size()},
            {"states", Json::object()},
            {"indices", Json::array()}};
  for (const MapState state : all_states)
    json["states"][to_string(state)] = count_of(map.points, state);
  for (std::size_t k = 0; k < map.indices.size(); ++k)
    json["indices"].push_back(range_json(map, k));
  return json;
}

std::string csv(const Map& map) {
  const double length = spatial::parse_unit(map.robot.units.length).factor;
  const double angle = spatial::parse_unit(map.robot.units.angle).factor;
  const std::vector<JointColumn> joints = joints_of(map);
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "{}", header(map));
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    const spatial::Vector6 c = coordinates_of(map.list.poses[i].platform);
    for (Eigen::Index k = 0; k < 6; ++k)
      fmt::format_to(out, "{},", cell(c[k] / (k < 3 ? length : angle)));
    for (const JointColumn& joint : joints) fmt::format_to(out, "{},", cell(joint.value(map, i)));
    fmt::format_to(out, "{}", to_string(map.points[i].state));
    for (std::size_t k = 0; k < map.indices.size(); ++k)
      fmt::format_to(out, ",{}", cell(map.points[i].values[k] / map.indices[k].factor));
    fmt::format_to(out, "\n");
  }
  return fmt::to_string(text);
}

io::VtuGrid vtu(const Map& map) {
  io::VtuGrid grid;
  io::VtuField state{.name = "state"};
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    for (const double x : map.list.poses[i].platform.position()) grid.points.push_back(x);
    state.values.push_back(static_cast<double>(map.points[i].state));
  }
  grid.point_fields.push_back(std::move(state));
  for (std::size_t k = 0; k < map.indices.size(); ++k)
    grid.point_fields.push_back(
        {.name = with_unit(map.indices[k].name, map.indices[k].unit), .values = values_of(map, k)});
  add_cells(map.list, grid);
  return grid;
}

namespace {

// The robot at every pose, as far as it reaches it; none where there are too many for a page.
Json robots_of(const Map& map) {
  constexpr std::size_t most = 200;
  Json robots = Json::array();
  if (map.points.size() > most) return robots;
  const vjm::Manipulator manipulator = map.robot.manipulator.without_errors();
  for (const auto& pose : map.list.poses) {
    const vjm::PostureResult found = posture_to(manipulator, pose);
    robots.push_back(found.reached ? skeleton(manipulator, found.posture) : Json());
  }
  return robots;
}

}  // namespace

Json picture(const Map& map) {
  Json poses = Json::array(), states = Json::array(), values = Json::array();
  const double length = spatial::parse_unit(map.robot.units.length).factor;
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    poses.push_back(io::to_json(spatial::Vector3(map.list.poses[i].platform.position() / length)));
    states.push_back(to_string(map.points[i].state));
  }
  for (std::size_t k = 0; k < map.indices.size(); ++k)
    values.push_back({{"name", map.indices[k].name},
                      {"unit", map.indices[k].unit},
                      {"values", values_of(map, k)}});
  return {{"map",
           {{"shape", map.list.shape},
            {"length", map.robot.units.length},
            {"positions", std::move(poses)},
            {"states", std::move(states)},
            {"indices", std::move(values)},
            {"robots", robots_of(map)}}}};
}

}  // namespace kinetostat::report

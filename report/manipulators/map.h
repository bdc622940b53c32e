// Indices of stiffness over a grid or along a path, for people, spreadsheets, ParaView and
// programs.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/io/json.h"
#include "kinetostat/io/vtu.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/workspace/workspace_map.h"

namespace kinetostat::report {

/// An index, what it is called, and the unit in which it is written.
struct NamedIndex {
  std::string name;
  vjm::MapIndex index;
  std::string unit;   // empty for a plain number
  double factor = 1;  // [SI] of one unit
};

/// A map that was computed: values[k] of points[i] is that of indices[k] at list.poses[i].
struct Map {
  const vjm::Robot& robot;
  const vjm::PoseList& list;
  const std::vector<NamedIndex>& indices;
  const std::vector<vjm::MapPoint>& points;
};

/// What a column of the joint "chain.joint" is called: "joint" where that is unique and no column
/// of a path, else in full.
std::string joint_column(const vjm::Robot& robot, const std::string& joint);
/// The unit of length or angle in which the robot file has it.
std::string joint_unit(const vjm::Robot& robot, const std::string& joint);

/// Of the first index: where it is smallest, its mean and its largest value, over how many poses.
std::string headline(const Map& map);
/// How many poses are in which state, and the range of every index in its unit.
std::string text(const Map& map);
/// The same, in SI units.
io::Json to_json(const Map& map);
/// One row a pose, in the units of the robot file and of the indices.
std::string csv(const Map& map);
/// Positions [m] with the state and the indices in their units; cells between the neighbours of a
/// grid of positions, a polyline along a path; points alone where the platform turns.
io::VtuGrid vtu(const Map& map);
/// What the charts of a page need; with the robot at every pose where there are at most 200.
io::Json picture(const Map& map);

}  // namespace kinetostat::report

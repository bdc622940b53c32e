#include "kinetostat/apps/commands/path_freedom.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_values.h"
#include "kinetostat/apps/cli/pose_list.h"
#include "kinetostat/vjm/manipulator/joint_place.h"
#include "kinetostat/vjm/manipulator/redundancy.h"

namespace kinetostat::apps {
namespace {

constexpr std::size_t most_joints = 2;
// Postures that are tried along a path, and combinations at one pose, each of which is compared
// with each of the next.
constexpr double most_postures = 2e6, most_combinations = 20'000;

spatial::Vector3 axis_of(const std::string& text, const spatial::UnitSystem& units) {
  if (text.size() == 1 && std::string("xyz").find(text) != std::string::npos)
    return spatial::Vector3::Unit(text[0] - 'x');
  const spatial::Vector3 axis = three_values("--turn", text, spatial::dimension::none, units);
  if (axis.isZero(0)) throw UsageError("--turn", fmt::format("'{}' has no length", text));
  return axis.normalized();
}

// "FROM:TO:POINTS" into the members of a free motion.
template <class Free>
void read_range(const std::string& option, const std::string& text,
                const spatial::Dimension& dimension, const spatial::UnitSystem& units, Free& free) {
  const std::vector<std::string> parts = split(text, ':');
  if (parts.size() != 3)
    throw UsageError(option, fmt::format("'{}' is no range", text),
                     "Write from, to and the number of values: -90:90:37");
  free.from = quantity(option, parts[0], dimension, units);
  free.to = quantity(option, parts[1], dimension, units);
  const double steps = quantity(option, parts[2], spatial::dimension::none, units);
  if (!(free.from < free.to) || !(steps >= 2 && steps <= 3601) || steps != std::floor(steps))
    throw UsageError(option, fmt::format("'{}' is no range", text),
                     "Write the least value first, and 2 to 3601 values: -90:90:37");
  free.steps = static_cast<int>(steps);
}

template <class Free>
void read_change(const std::string& option, const std::string& text,
                 const spatial::Dimension& dimension, const spatial::UnitSystem& units,
                 Free& free) {
  free.largest_change = quantity(option, text, dimension, units);
  if (!(free.largest_change > 0))
    throw UsageError(option, "a change from pose to pose is above zero");
}

std::optional<vjm::FreeTurn> read_turn(const FreedomRequest& request,
                                       const spatial::UnitSystem& units) {
  if (request.turn.empty()) return std::nullopt;
  vjm::FreeTurn turn{.axis = axis_of(request.turn, units),
                     .from = -std::numbers::pi,
                     .to = std::numbers::pi,
                     .steps = 73};
  if (!request.turn_range.empty())
    read_range("--turn-range", request.turn_range, spatial::dimension::angle, units, turn);
  if (!request.turn_change.empty())
    read_change("--turn-change", request.turn_change, spatial::dimension::angle, units, turn);
  return turn;
}

std::string actuated_names(const vjm::Manipulator& manipulator) {
  std::vector<std::string> names;
  for (const vjm::JointPlace& place : actuated_joints(manipulator))
    names.push_back(full_name(manipulator, place));
  return fmt::format("{}", fmt::join(names, ", "));
}

vjm::JointPlace actuated_joint(const vjm::Robot& robot, const std::string& name) {
  const auto cure = [&] {
    return fmt::format("Its actuated joints are {}", actuated_names(robot.manipulator));
  };
  vjm::JointPlace place;
  try {
    place = find_joint(robot.manipulator, name);
  } catch (const std::invalid_argument& error) {
    throw UsageError("--joint", error.what(), cure());
  }
  if (coordinate_at(robot.manipulator, place).role != vjm::Role::actuated)
    throw UsageError("--joint", fmt::format("'{}' is passive: no drive holds it", name), cure());
  return place;
}

// The limits of the drive, and what of them is asked for.
void read_joint_range(const vjm::Robot& robot, const vjm::Coordinate& coordinate,
                      const std::string& text, vjm::FreeJoint& joint) {
  if (coordinate.range) joint.from = (*coordinate.range)[0], joint.to = (*coordinate.range)[1];
  if (text.empty()) {
    if (coordinate.range) return;
    throw UsageError("--joint", fmt::format("'{}' has no limits", joint.name),
                     "Give --joint-range FROM:TO:POINTS, or the joint a 'range' in the robot file");
  }
  const bool turns = is_rotation(coordinate.motion);
  read_range("--joint-range", text, turns ? spatial::dimension::angle : spatial::dimension::length,
             robot.units, joint);
  if (!coordinate.range) return;
  const auto [least, largest] = *coordinate.range;
  const double rounding = 1e-9 * (1 + std::abs(least) + std::abs(largest));
  if (joint.from >= least - rounding && joint.to <= largest + rounding) return;
  const std::string unit = turns ? robot.units.angle : robot.units.length;
  const double factor = spatial::parse_unit(unit).factor;
  throw UsageError(
      "--joint-range", fmt::format("'{}' goes beyond the range of {}", text, joint.name),
      fmt::format("It may stand at {:.6g} to {:.6g} {}", least / factor, largest / factor, unit));
}

std::vector<vjm::FreeJoint> read_joints(const FreedomRequest& request, const vjm::Robot& robot) {
  const std::size_t count = request.joints.size();
  if (count > most_joints)
    throw UsageError("--joint", fmt::format("{} joints are more than {}", count, most_joints));
  for (const auto& [option, given] : {std::pair("--joint-range", request.joint_ranges.size()),
                                      std::pair("--joint-change", request.joint_changes.size())})
    if (given > count)
      throw UsageError(option, fmt::format("it is given {} times for {} joints", given, count),
                       "Give it once for each --joint, in their order");
  std::vector<vjm::FreeJoint> joints;
  for (std::size_t j = 0; j < count; ++j) {
    const vjm::JointPlace place = actuated_joint(robot, request.joints[j]);
    const vjm::Coordinate& coordinate = coordinate_at(robot.manipulator, place);
    vjm::FreeJoint joint{.name = full_name(robot.manipulator, place)};
    if (!joints.empty() && joints.front().name == joint.name)
      throw UsageError("--joint", fmt::format("'{}' is given twice", joint.name));
    read_joint_range(robot, coordinate,
                     j < request.joint_ranges.size() ? request.joint_ranges[j] : "", joint);
    if (j < request.joint_changes.size())
      read_change(
          "--joint-change", request.joint_changes[j],
          is_rotation(coordinate.motion) ? spatial::dimension::angle : spatial::dimension::length,
          robot.units, joint);
    joints.push_back(std::move(joint));
  }
  return joints;
}

// Where the base may stand, in the axes of the path.
std::vector<spatial::Pose> read_places(const FreedomRequest& request, const vjm::Robot& robot) {
  std::vector<spatial::Pose> places;
  if (request.place.empty()) return {spatial::Pose()};
  for (const vjm::TargetPose& place : read_grid(request.place, robot, {}, "--place").poses) {
    if (place.is_by_joints)
      throw UsageError("--place", "no drive says where the base stands",
                       "Give x, y, z, and rx, ry, rz");
    places.push_back(place.platform);
  }
  const spatial::Vector3 weight = robot.manipulator.gravity();
  for (const spatial::Pose& place : places)
    if (!(place.rotation() * weight).isApprox(weight, 1e-9) && !weight.isZero(0))
      throw UsageError("--place", "the base of a robot with weight stays upright",
                       "Turn it about the vertical only, or leave the turns out");
  return places;
}

// What a pose leaves of freedom to a joint when those before it are held where they stand.
bool is_left_free(const vjm::Manipulator& manipulator, const vjm::TargetPose& pose,
                  const std::vector<vjm::FreeJoint>& joints, std::size_t j) {
  std::map<std::string, double> held = pose.held;
  const vjm::PostureResult standing = posture_holding(manipulator, pose.platform, held);
  for (std::size_t before = 0; before < j; ++before) {
    const vjm::JointPlace place = find_joint(manipulator, joints[before].name);
    held[joints[before].name] = standing.posture.coordinates[place.chain][place.coordinate];
  }
  return may_move_at(manipulator, pose.platform, held, joints[j].name);
}

std::string what_is_free(const vjm::Manipulator& manipulator, const vjm::TargetPose& pose) {
  const std::vector<std::string> free = redundant_joints(manipulator, pose.platform, pose.held);
  if (free.empty())
    return "No joint of this robot is redundant there: give --turn AXIS for a turn that the work "
           "leaves free, or --place GRID";
  return fmt::format("Joints that may move there while the platform stays: {}",
                     fmt::join(free, ", "));
}

void require_redundant(const vjm::Manipulator& manipulator,
                       const std::vector<vjm::TargetPose>& poses,
                       const std::vector<vjm::FreeJoint>& joints) {
  const auto reached = std::find_if(poses.begin(), poses.end(), [&](const vjm::TargetPose& pose) {
    return posture_holding(manipulator, pose.platform, pose.held).reached;
  });
  if (reached == poses.end()) return;  // what is chosen says so
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (std::none_of(reached, poses.end(), [&](const vjm::TargetPose& pose) {
          return is_left_free(manipulator, pose, joints, j);
        }))
      throw UsageError(
          "--joint",
          fmt::format("the poses of the path leave '{}' no freedom{}", joints[j].name,
                      j > 0 ? fmt::format(" when '{}' is held", joints.front().name) : ""),
          what_is_free(manipulator, *reached));
}

void refuse_too_many(const vjm::PathFreedom& freedom, std::size_t poses) {
  const double combinations = candidates_per_pose(freedom);
  if (freedom.joints.empty()) return;
  if (combinations > most_combinations || combinations * static_cast<double>(poses) > most_postures)
    throw UsageError("--joint",
                     fmt::format("{:.6g} combinations at each of {} poses are more than can be "
                                 "tried",
                                 combinations, poses),
                     fmt::format("Try fewer values (--turn-range, --joint-range): at most {:.0f} "
                                 "at a pose and {:.0f} in all",
                                 most_combinations, most_postures));
}

}  // namespace

void FreedomRequest::add_options(OptionList& app) {
  const auto turns = app.add_option("--turn", turn,
                                    "Choose at each pose of the path how far the platform is "
                                    "turned about this axis of its own, z or 0,0,1: for the best "
                                    "worst value of the first index")
                         .type_name("AXIS");
  app.add_option("--turn-range", turn_range,
                 "Turns that are tried, FROM:TO:POINTS; -180:180:73 deg unless given")
      .type_name("RANGE")
      .needs(turns);
  app.add_option("--turn-change", turn_change, "Largest turn from one pose to the next")
      .type_name("ANGLE")
      .needs(turns);
  const auto held = app.add_option("--joint", joints,
                                   "Choose likewise where this joint of a redundant robot stands, "
                                   "while the others lead to the pose; may be given twice")
                        .type_name("NAME")
                        .one_at_a_time();
  app.add_option("--joint-range", joint_ranges,
                 "Values of the joint that are tried, FROM:TO:POINTS; 37 over its limits unless "
                 "given; in the order of --joint")
      .type_name("RANGE")
      .one_at_a_time()
      .needs(held);
  app.add_option("--joint-change", joint_changes,
                 "Largest change of the joint from one pose to the next, in the order of --joint")
      .type_name("VALUE")
      .one_at_a_time()
      .needs(held);
  app.add_option("--place", place,
                 "Choose likewise where the base stands, as against the path: "
                 "x=FROM:TO:POINTS,y=...,z=...,rz=...")
      .type_name("GRID");
}

vjm::PathFreedom FreedomRequest::read(const vjm::Robot& robot,
                                      const std::vector<vjm::TargetPose>& poses) const {
  vjm::PathFreedom freedom{.turn = read_turn(*this, robot.units),
                           .joints = read_joints(*this, robot),
                           .placements = read_places(*this, robot)};
  refuse_too_many(freedom, poses.size());
  std::vector<vjm::TargetPose> seen;
  if (!freedom.joints.empty())
    for (const vjm::TargetPose& pose : poses)
      seen.push_back(seen_from(pose, freedom.placements.front()));
  require_redundant(robot.manipulator, seen, freedom.joints);
  return freedom;
}

}  // namespace kinetostat::apps

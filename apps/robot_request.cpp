#include "kinetostat/apps/robot_request.h"

#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/apps/command.h"
#include "kinetostat/files/error.h"
#include "kinetostat/spatial/rotation.h"

namespace kinetostat::apps {
namespace {

using spatial::Dimension;
using spatial::Vector3;
namespace dimension = spatial::dimension;

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == ',') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

double quantity(const std::string& option, const std::string& text, const Dimension& dimension,
                const spatial::UnitSystem& units) {
  try {
    return spatial::parse_quantity(text, dimension, units.unit_for(dimension));
  } catch (const std::invalid_argument& error) {
    throw UsageError(option, error.what());
  }
}

// Three values, then three more that may be left out.
spatial::Vector6 six(const std::string& option, const std::string& text, const Dimension& first,
                     const Dimension& second, const spatial::UnitSystem& units) {
  const std::vector<std::string> parts = split(text);
  if (parts.size() != 3 && parts.size() != 6)
    throw UsageError(option, fmt::format("'{}' has {} values, not 3 or 6", text, parts.size()),
                     "Separate them with commas and no blanks, such as 0,0,-100");
  spatial::Vector6 values = spatial::Vector6::Zero();
  for (std::size_t i = 0; i < parts.size(); ++i)
    values[static_cast<Eigen::Index>(i)] =
        quantity(option, parts[i], i < 3 ? first : second, units);
  return values;
}

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

}  // namespace

void PostureRequest::add_options(CLI::App& app) {
  app.add_option("ROBOT", robot_file, "Robot file (YAML)")->required();
  auto* at_option = app.add_option(
      "--at", at,
      "Pose of the platform, x,y,z or x,y,z,rx,ry,rz (rotation vector), in the units of the file");
  app.add_option("--joints", joints, "Joint values instead, name=value,...")->excludes(at_option);
}

vjm::Robot PostureRequest::read() const { return vjm::read_robot(robot_file); }

vjm::Posture PostureRequest::posture(const vjm::Robot& robot) const {
  vjm::PostureResult result;
  if (!at.empty()) {
    const spatial::Vector6 values =
        six("--at", at, dimension::length, dimension::angle, robot.units);
    result =
        posture_at(robot.manipulator, {spatial::exp_rotation(values.tail<3>()), values.head<3>()});
  } else if (!joints.empty()) {
    result = from_joints(robot, joints);
  } else {
    result = posture_from_joints(robot.manipulator, {});
  }
  if (!result.reached) throw files::NoConvergence(result.reason);
  return result.posture;
}

void LoadRequest::add_options(CLI::App& app) {
  auto* wrench_option = app.add_option(
      "--wrench", wrench,
      "Load on the platform, Fx,Fy,Fz or Fx,Fy,Fz,Mx,My,Mz, base axes, in the units of the file");
  app.add_option("--point", point, "Where it acts, x,y,z on the platform (default: its origin)")
      ->needs(wrench_option);
  app.add_option("--move", move,
                 "Displacement to hold instead, dx,dy,dz or dx,dy,dz,rx,ry,rz, base axes")
      ->excludes(wrench_option);
}

vjm::Equilibrium LoadRequest::solve(const vjm::Robot& robot, const vjm::Posture& posture) const {
  if (!move.empty()) {
    const spatial::Vector6 displacement =
        six("--move", move, dimension::length, dimension::angle, robot.units);
    return equilibrium_at_pose(robot.manipulator, posture,
                               spatial::displaced(posture.platform, displacement));
  }
  const spatial::Vector6 values =
      six("--wrench", wrench, dimension::force, dimension::moment, robot.units);
  vjm::Load load{values.head<3>(), values.tail<3>(), Vector3::Zero()};
  if (!point.empty())
    load.point_on_platform =
        six("--point", point, dimension::length, dimension::length, robot.units).head<3>();
  return equilibrium_under_load(robot.manipulator, posture, load);
}

}  // namespace kinetostat::apps

#include "kinetostat/vjm/exchange/description_file.h"

#include <fmt/format.h>

#include "kinetostat/vjm/exchange/dh_table.h"
#include "kinetostat/vjm/exchange/mjcf_import.h"
#include "kinetostat/vjm/exchange/sdf_import.h"
#include "kinetostat/vjm/exchange/urdf_import.h"
#include "kinetostat/vjm/exchange/xml_file.h"

namespace kinetostat::vjm {
namespace {

bool is_table(const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  return extension == ".yaml" || extension == ".yml" || extension == ".csv" || extension == ".tsv";
}

RobotDescription read_by_format(const std::filesystem::path& file) {
  if (is_table(file)) return read_dh_table(file);
  const XmlFile xml(file);
  const std::string root = xml.root_name();
  if (root == "mujoco") return read_mjcf(file);
  if (root == "sdf" || root == "gazebo") return read_sdf(file);
  return read_urdf(file);
}

}  // namespace

RobotDescription read_robot_description(const std::filesystem::path& file) {
  RobotDescription robot = read_by_format(file);
  for (const DescribedJoint& joint : robot.joints)
    if (joint.rest && is_out_of_range(joint, *joint.rest))
      robot.remarks.push_back(fmt::format(
          "Left out: that the spring of '{}' is relaxed at {:.6g} {}, beyond its range.",
          joint.name, *joint.rest, turns(joint) ? "rad" : "m"));
  return robot;
}

}  // namespace kinetostat::vjm

#include "kinetostat/vjm/exchange/description_file.h"

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

}  // namespace

RobotDescription read_robot_description(const std::filesystem::path& file) {
  if (is_table(file)) return read_dh_table(file);
  const XmlFile xml(file);
  const std::string root = xml.root_name();
  if (root == "mujoco") return read_mjcf(file);
  if (root == "sdf" || root == "gazebo") return read_sdf(file);
  return read_urdf(file);
}

}  // namespace kinetostat::vjm

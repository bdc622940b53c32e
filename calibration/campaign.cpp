#include "kinetostat/calibration/campaign.h"

#include <cmath>
#include <limits>

#include "kinetostat/calibration/readings_file.h"
#include "kinetostat/files/yaml.h"

namespace kinetostat::calibration {
namespace {

using files::YamlNode;
using spatial::Dimension;
namespace dimension = spatial::dimension;

YamlNode read_top(const std::filesystem::path& file) {
  YamlNode top = files::read_yaml(file);
  files::check_format_version(top);
  top.allow_only({"kinetostat", "campaign", "origin", "robot", "units", "displacement", "zero",
                  "session_frame", "wrench_point", "noise", "readings"});
  return top;
}

double read_deviation(const YamlNode& node, const Dimension& dimension) {
  const double value = node.quantity_with_unit(dimension);
  if (!(value > 0))
    node.fail("'" + node.text() + "' is not positive",
              "Give the standard deviation of one reading, or remove the key when it is not known");
  return value;
}

// One standard deviation for all three axes, or a list of three.
void read_deviations(const YamlNode& node, const Dimension& dimension,
                     Eigen::Ref<spatial::Vector3> noise) {
  if (node.is_scalar()) {
    noise.setConstant(read_deviation(node, dimension));
    return;
  }
  Eigen::Index i = 0;
  for (const YamlNode& item : node.items(3)) noise[i++] = read_deviation(item, dimension);
}

spatial::Vector6 read_noise(const YamlNode& top) {
  spatial::Vector6 noise = spatial::Vector6::Constant(std::numeric_limits<double>::quiet_NaN());
  const auto node = top.find("noise");
  if (!node) return noise;
  node->allow_only({"translation", "rotation"});
  if (const auto given = node->find("translation"))
    read_deviations(*given, dimension::length, noise.head<3>());
  if (const auto given = node->find("rotation"))
    read_deviations(*given, dimension::angle, noise.tail<3>());
  return noise;
}

std::optional<spatial::Vector3> read_wrench_point(const YamlNode& top,
                                                  const spatial::UnitSystem& units) {
  const auto node = top.find("wrench_point");
  if (!node) return std::nullopt;
  if (node->is_scalar()) {
    node->choice({"reference"});
    return spatial::Vector3(spatial::Vector3::Zero());
  }
  return node->vector3(dimension::length, units);
}

}  // namespace

bool Reading::uses(Eigen::Index component) const {
  return !masked && !std::isnan(displacement[component]);
}

std::vector<Eigen::Index> components_in_use(const Reading& reading) {
  std::vector<Eigen::Index> used;
  for (Eigen::Index k = 0; k < 6; ++k)
    if (reading.uses(k)) used.push_back(k);
  return used;
}

std::optional<std::filesystem::path> robot_named_in(const std::filesystem::path& campaign) {
  const YamlNode top = read_top(campaign);
  const auto robot = top.find("robot");
  if (!robot) return std::nullopt;
  return robot->existing_file();
}

Campaign read_campaign(const std::filesystem::path& file, const vjm::Manipulator& manipulator) {
  const YamlNode top = read_top(file);
  const YamlNode units = top.at("units");
  Campaign campaign;
  campaign.file = file;
  campaign.name = top.at("campaign").text();
  if (const auto robot = top.find("robot")) campaign.robot = robot->text();
  campaign.units = files::read_units(units);
  if (top.at("displacement").choice({"difference", "absolute"}) == "absolute")
    campaign.displacement = DisplacementKind::absolute;
  if (const auto zero = top.find("zero"); zero && zero->choice({"known", "estimate"}) == "estimate")
    campaign.zero = ZeroReading::estimated;
  if (const auto frame = top.find("session_frame");
      frame && frame->choice({"known", "estimate"}) == "estimate")
    campaign.session_frame = SessionFrame::estimated;
  campaign.readings_file = top.at("readings").existing_file();
  const ReadingsContext context{.noise = read_noise(top),
                                .wrench_point = read_wrench_point(top, campaign.units),
                                .angle_stated = units.has("angle"),
                                .time_stated = units.has("time")};
  read_readings(files::read_csv(campaign.readings_file), context, manipulator, campaign);
  return campaign;
}

}  // namespace kinetostat::calibration

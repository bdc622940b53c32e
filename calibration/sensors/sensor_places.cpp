#include "kinetostat/calibration/sensors/sensor_places.h"

#include <algorithm>

namespace kinetostat::calibration {
namespace {

std::vector<std::string> places_on(const vjm::Chain& chain) {
  std::vector<std::string> names = {"base"};
  const auto add = [&names](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const vjm::Node& node : chain.nodes()) add(node.name);
  for (const Eigen::Index k : chain.posture_coordinates())
    add(chain.coordinates()[static_cast<std::size_t>(k)].name);
  for (const vjm::Spring& spring : chain.springs())
    if (spring.stiffness.rows() == 6) add(spring.name.substr(0, spring.name.find('.')));
  return names;
}

}  // namespace

std::vector<SensorPlace> sensor_places(const vjm::Manipulator& robot) {
  std::vector<SensorPlace> places;
  for (std::size_t b = 0; b < robot.body_count(); ++b)
    places.push_back({robot.body_names()[b], {.body = static_cast<int>(b)}});
  for (std::size_t c = 0; c < robot.size(); ++c)
    for (const std::string& name : places_on(robot.chains()[c]))
      places.push_back({robot.chains()[c].name() + "." + name, {.chain = c, .place = name}});
  return places;
}

}  // namespace kinetostat::calibration

#include "kinetostat/calibration/campaign/campaign.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

namespace kinetostat::calibration {

std::vector<std::pair<std::string, std::string>> Occasion::stated() const {
  std::vector<std::pair<std::string, std::string>> all = {
      {"date", date}, {"operator", measured_by}, {"instrument", measured_with}, {"serial", serial}};
  std::erase_if(all, [](const auto& item) { return item.second.empty(); });
  return all;
}

bool Reading::uses(Eigen::Index component) const {
  return !masked && !std::isnan(displacement[component]);
}

std::vector<Eigen::Index> components_in_use(const Reading& reading) {
  std::vector<Eigen::Index> used;
  find_components_in_use(reading, used);
  return used;
}

void find_components_in_use(const Reading& reading, std::vector<Eigen::Index>& used) {
  used.clear();
  for (Eigen::Index k = 0; k < reading.displacement.size(); ++k)
    if (reading.uses(k)) used.push_back(k);
}

vjm::Load DisplacementControl::with_force(std::size_t reading, std::size_t configuration,
                                          double newtons) const {
  vjm::Load load = beside[reading];
  load.force += newtons * along[configuration].head<3>();
  load.moment += newtons * along[configuration].tail<3>();
  return load;
}

std::optional<double> Covariate::number(std::size_t reading) const {
  const std::string& text = values[reading];
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

bool Covariate::is_numeric() const {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!values[i].empty() && !number(i)) return false;
  return true;
}

std::vector<Component> platform_components() {
  std::vector<Component> components;
  for (Eigen::Index k = 0; k < 6; ++k)
    components.push_back(
        {.name = component_names[static_cast<std::size_t>(k)],
         .dimension = is_rotation(k) ? spatial::dimension::angle : spatial::dimension::length,
         .axis = k});
  return components;
}

void leave_out_platform(Campaign& campaign) {
  campaign.sensors.erase(campaign.sensors.begin());
  campaign.components.erase(campaign.components.begin(), campaign.components.begin() + 6);
  for (Component& component : campaign.components) --component.sensor;
  for (Sensor& sensor : campaign.sensors)
    if (sensor.minus) --*sensor.minus;
  if (campaign.control) campaign.control->set -= 6, campaign.control->force -= 6;
  campaign.datum_noise = campaign.datum_noise.tail(campaign.size()).eval();
}

std::string Campaign::unit_of(Eigen::Index k) const {
  const spatial::Dimension& of = component(k).dimension;
  if (of == spatial::dimension::angle) return units.angle;
  if (of == spatial::dimension::force) return units.force;
  return of == spatial::dimension::moment ? units.force + " " + units.length : units.length;
}

std::vector<std::vector<Eigen::Index>> component_kinds(const Campaign& campaign) {
  std::vector<std::vector<Eigen::Index>> kinds;
  for (Eigen::Index k = 0; k < campaign.size(); ++k) {
    const auto same = [&](const std::vector<Eigen::Index>& kind) {
      const Component& first = campaign.component(kind.front());
      return first.sensor == campaign.component(k).sensor &&
             first.dimension == campaign.component(k).dimension;
    };
    const auto found = std::find_if(kinds.begin(), kinds.end(), same);
    if (found == kinds.end())
      kinds.push_back({k});
    else
      found->push_back(k);
  }
  return kinds;
}

std::vector<Value> values_in_use(const Campaign& campaign) {
  const auto count = [&](std::size_t sum, const Reading& r) {
    for (Eigen::Index k = 0; k < r.displacement.size(); ++k) sum += r.uses(k) ? 1 : 0;
    return sum;
  };
  std::vector<Value> values;
  values.reserve(
      std::accumulate(campaign.readings.begin(), campaign.readings.end(), std::size_t{0}, count));
  for (std::size_t i = 0; i < campaign.readings.size(); ++i)
    for (Eigen::Index k = 0; k < campaign.readings[i].displacement.size(); ++k)
      if (campaign.readings[i].uses(k)) values.push_back({i, k});
  return values;
}

std::vector<std::size_t> first_values(const std::vector<Value>& values, std::size_t readings) {
  std::vector<std::size_t> first(readings, 0);
  for (std::size_t v = values.size(); v-- > 0;) first[values[v].reading] = v;
  return first;
}

bool has_role(const Campaign& campaign, Role role) {
  return std::any_of(campaign.readings.begin(), campaign.readings.end(),
                     [role](const Reading& r) { return !r.masked && r.role == role; });
}

Campaign only(Campaign campaign, std::initializer_list<Role> roles) {
  for (Reading& reading : campaign.readings)
    if (!reading.masked && std::find(roles.begin(), roles.end(), reading.role) == roles.end()) {
      reading.masked = true;
      reading.mask_reason =
          fmt::format("to {}", role_names[static_cast<std::size_t>(reading.role)]);
    }
  return campaign;
}

}  // namespace kinetostat::calibration

#include "kinetostat/calibration/campaign/campaign.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace kinetostat::calibration {

bool Reading::uses(Eigen::Index component) const {
  return !masked && !std::isnan(displacement[component]);
}

std::vector<Eigen::Index> components_in_use(const Reading& reading) {
  std::vector<Eigen::Index> used;
  for (Eigen::Index k = 0; k < 6; ++k)
    if (reading.uses(k)) used.push_back(k);
  return used;
}

std::vector<Value> values_in_use(const Campaign& campaign) {
  std::vector<Value> values;
  for (std::size_t i = 0; i < campaign.readings.size(); ++i)
    for (const Eigen::Index k : components_in_use(campaign.readings[i])) values.push_back({i, k});
  return values;
}

const std::string& unit_of(const Campaign& campaign, Eigen::Index component) {
  return is_rotation(component) ? campaign.units.angle : campaign.units.length;
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

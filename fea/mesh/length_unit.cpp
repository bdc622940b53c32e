#include "kinetostat/fea/mesh/length_unit.h"

#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/spatial/units.h"

namespace kinetostat::fea {

namespace {

std::string sizes_in_words(const spatial::Vector3& size) {
  return fmt::format(
      "{0:.4g} x {1:.4g} x {2:.4g} m in mm, {3:.4g} x {4:.4g} x {5:.4g} "
      "m in m, {6:.4g} x {7:.4g} x {8:.4g} m in inch",
      size.x() * 1e-3, size.y() * 1e-3, size.z() * 1e-3, size.x(), size.y(), size.z(),
      size.x() * 0.0254, size.y() * 0.0254, size.z() * 0.0254);
}

}  // namespace

double metres_per_unit(const std::filesystem::path& file, const std::string& unit,
                       const std::vector<spatial::Vector3>& points) {
  Eigen::AlignedBox3d box;
  for (const spatial::Vector3& p : points) box.extend(p);
  if (unit.empty())
    throw MissingUnit(
        file,
        "the mesh has no unit of length; its bounding box would be " + sizes_in_words(box.sizes()),
        "State the unit: mm, m or inch");
  try {
    return spatial::parse_quantity("1 " + unit, spatial::dimension::length);
  } catch (const std::invalid_argument& error) {
    throw common::InputError(file, fmt::format("unit '{}': {}", unit, error.what()),
                             "State a unit of length: mm, m or inch");
  }
}

}  // namespace kinetostat::fea

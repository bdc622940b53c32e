#include "kinetostat/calibration/campaign/readings_context.h"

#include <algorithm>

#include <Eigen/Cholesky>
#include <fmt/format.h>

namespace kinetostat::calibration {

std::vector<LoadColumn> load_columns(const ReadingsContext& context) {
  std::vector<LoadColumn> columns;
  for (const Weight& weight : context.weights)
    columns.push_back({"weight", weight.name, spatial::dimension::mass});
  for (const Cylinder& cylinder : context.cylinders)
    columns.push_back({"cylinder", cylinder.name, spatial::dimension::force});
  for (const Torque& torque : context.torques)
    columns.push_back({"torque", torque.name, torque.dimension});
  return columns;
}

bool is_correlation(const spatial::Matrix6& matrix) {
  const Eigen::LLT<spatial::Matrix6> factor(matrix);
  return factor.info() == Eigen::Success &&
         factor.matrixLLT().diagonal().minCoeff() > 1e-6;  // else nearly singular
}

Role role_named(std::string_view name) {
  const auto found = std::find(role_names.begin(), role_names.end(), name);
  return static_cast<Role>(found - role_names.begin());
}

}  // namespace kinetostat::calibration

#include "kinetostat/calibration/kinematics/pose_error.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace kinetostat::calibration {

using Eigen::Index;

void PoseErrors::Sum::add(double error) {
  squares += error * error;
  largest = std::max(largest, std::abs(error));
  ++count;
}

double PoseErrors::Sum::rms() const {
  return count == 0 ? not_a_number : std::sqrt(squares / static_cast<double>(count));
}

double PoseErrors::Sum::most() const { return count == 0 ? not_a_number : largest; }

void PoseErrors::add(const Campaign& campaign, const std::vector<Eigen::VectorXd>& predicted,
                     const Eigen::VectorXd& residual) {
  const std::vector<Value> values = values_in_use(campaign);
  std::map<std::size_t, std::vector<double>> positions;  // of one sensor, by reading
  for (std::size_t v = 0; v < values.size(); ++v) {
    const auto& [reading, component] = values[v];
    const double over_noise = std::abs(residual[static_cast<Index>(v)]);
    if (over_noise > whitened_.largest) worst_reading_ = reading;
    whitened_.add(over_noise);
    squares_[campaign.readings[reading].configuration] += over_noise * over_noise;
    const Component& what = campaign.component(component);
    const double error =
        campaign.readings[reading].displacement[component] - predicted[reading][component];
    if (what.dimension == spatial::dimension::angle) rotation_.add(error);
    if (what.dimension != spatial::dimension::length) continue;
    translation_.add(error);
    if (what.sensor == 0) positions[reading].push_back(error);
  }
  for (const auto& [reading, errors] : positions)
    if (errors.size() == 3) distance_.add(std::hypot(errors[0], errors[1], errors[2]));
}

PoseError PoseErrors::total() const {
  return {.values = whitened_.count,
          .whitened = whitened_.rms(),
          .translation = translation_.rms(),
          .rotation = rotation_.rms(),
          .worst_translation = translation_.most(),
          .worst_rotation = rotation_.most(),
          .distance = distance_.rms(),
          .worst_distance = distance_.most(),
          .worst_reading = worst_reading_};
}

bool is_lower(const PoseErrors& after, const PoseErrors& before) {
  constexpr double standard_errors = 2;
  double sum = 0, squares = 0;
  for (const auto& [pose, error] : before.squares()) {
    const auto other = after.squares().find(pose);
    const double fall = error - (other == after.squares().end() ? 0 : other->second);
    sum += fall;
    squares += fall * fall;
  }
  const auto n = static_cast<double>(before.squares().size());
  return sum > 0 && sum * sum > standard_errors * standard_errors * (squares - sum * sum / n);
}

}  // namespace kinetostat::calibration

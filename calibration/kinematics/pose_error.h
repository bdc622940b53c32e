// How far predicted poses are off, over readings that several fits may have predicted.
#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"

namespace kinetostat::calibration {

/// Measured minus predicted over some readings; NaN where nothing of the kind was measured.
struct PoseError {
  Eigen::Index values = 0;
  double whitened = 0;            // rms over all values, in units of the noise
  double translation = 0;         // rms of one coordinate [m]
  double rotation = 0;            // rms of one coordinate [rad]
  double worst_translation = 0;   // largest of one coordinate [m]
  double worst_rotation = 0;      // largest of one coordinate [rad]
  double distance = 0;            // rms of the distance, where three coordinates were read [m]
  double worst_distance = 0;      // largest [m]
  std::size_t worst_reading = 0;  // of the largest error in units of the noise
};

class PoseErrors {
 public:
  /// Adds the readings in use of a campaign. `predicted`: one entry a reading, SI; `residual`:
  /// their errors in units of the noise, one a value in use.
  void add(const Campaign& campaign, const std::vector<Eigen::VectorXd>& predicted,
           const Eigen::VectorXd& residual);
  PoseError total() const;
  /// Sums of squares in units of the noise, by configuration.
  const std::map<std::size_t, double>& squares() const { return squares_; }

 private:
  struct Sum {
    double squares = 0, largest = 0;
    Eigen::Index count = 0;

    void add(double error);
    double rms() const;  // NaN without any
    double most() const;
  };
  Sum whitened_, translation_, rotation_, distance_;
  std::map<std::size_t, double> squares_;
  std::size_t worst_reading_ = 0;
};

/// Whether errors `after` are smaller than those `before` at the same poses by more than two
/// standard errors of their paired difference.
bool is_lower(const PoseErrors& after, const PoseErrors& before);

}  // namespace kinetostat::calibration

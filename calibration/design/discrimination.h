// How well readings that are not taken yet would distinguish candidate models, or sharpen one of
// them.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace kinetostat::calibration {

/// Forecast of planned values by one model, in units of their noise: the prediction y, and its
/// uncertainty J L from that of the parameters (L L' is their covariance).
struct Forecast {
  Eigen::VectorXd mean;
  Eigen::MatrixXd spread;
  /// Where nothing is known of what the model adds: its changes when that is of another form.
  Eigen::MatrixXd forms = {};
  /// Its changes with where targets sit that are unknown [m or rad].
  Eigen::MatrixXd by_targets = {};
};

/// The separation of two models by any number of planned values, which add up. With the mean V of
/// both predictive covariances (noise, spread of either model, unknowns that both may fit),
///
///     d'^2 = (m_a - m_b)' V^-1 (m_a - m_b),
///
/// the discrimination of Box and Hill (1967, eq. 11) for equal covariances and Buzzi-Ferraris and
/// Forzatti (1983) in its numerator. V is never formed: it is the noise plus few directions.
class Separation {
 public:
  Separation() = default;
  /// `common`: further unknowns of the planned session (zero offsets, frames), by their prior
  /// width.
  Separation(const Forecast& a, const Forecast& b, const Eigen::MatrixXd& common);

  Separation& operator+=(const Separation& other);
  friend Separation operator+(Separation a, const Separation& b) { return a += b; }
  double squared() const;  // d'^2

 private:
  Eigen::MatrixXd gram_;  // K'K of the few directions
  Eigen::VectorXd along_;
  double difference_ = 0;
};

/// Information about a model's parameters, in units of what was known before: I + sum of L'J'JL.
class Knowledge {
 public:
  explicit Knowledge(Eigen::Index directions)
      : gain_(Eigen::MatrixXd::Identity(directions, directions)) {}

  /// Gain by planned values; the part that is confounded with `common` unknowns is no gain.
  static Eigen::MatrixXd gain(const Forecast& forecast, const Eigen::MatrixXd& common);

  void add(const Eigen::MatrixXd& gain) { gain_ += gain; }
  /// Mean square of predictions with this spread, after what is known now.
  double mean_square(const Eigen::MatrixXd& spread) const;
  /// Covariance of the directions.
  Eigen::MatrixXd covariance() const;

 private:
  Eigen::MatrixXd gain_;
};

/// L with L L' = covariance, one column a direction that is not known exactly.
Eigen::MatrixXd root_of(const Eigen::MatrixXd& covariance);

}  // namespace kinetostat::calibration

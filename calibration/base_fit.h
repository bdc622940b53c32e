// Refits what the user declared uncertain, so that a model is not blamed for a parameter that
// nobody claimed to know.
#pragma once

#include <vector>

#include "kinetostat/calibration/noise.h"
#include "kinetostat/calibration/predict.h"

namespace kinetostat::calibration {

/// One measured number: a component of a reading in use.
struct Value {
  std::size_t reading = 0;
  Eigen::Index component = 0;
};

/// All of them, in the order of the readings.
std::vector<Value> values_in_use(const Campaign& campaign);

/// The unknown constant of one session and component [m or rad].
struct Zero {
  std::size_t session = 0;
  Eigen::Index component = 0;
  double value = 0;
  double standard_error = 0;
};

struct ParameterEstimate {
  Parameter parameter;
  double log_factor = 0;
  double standard_error = 0;  // of log_factor, so nearly the relative one of the stiffness
};

/// A model with its parameters and zeros at their best values.
struct BaseFit {
  std::vector<ParameterEstimate> parameters;
  std::vector<Zero> zeros;
  Eigen::MatrixXd covariance;  // of the parameters, then the zeros
  /// Where the standard errors come from; `unknown`: from the residual itself, so they take the
  /// model to be right.
  NoiseSource error_source = NoiseSource::unknown;
  /// One entry a reading: what the table should show, zeros included [m; rad].
  std::vector<spatial::Vector6> predicted;
  double squared_error = 0;  // sum of squares of the whitened residuals in use
  Eigen::Index values = 0;   // how many there are
  int iterations = 0;

  Eigen::Index estimated() const {  // number of parameters and zeros
    return static_cast<Eigen::Index>(parameters.size() + zeros.size());
  }
  Eigen::Index degrees_of_freedom() const { return values - estimated(); }
};

struct BaseFitOptions {
  int max_iterations = 50;
  /// Ends when a step changes the predictions by less than this, relative to the readings.
  double tolerance = 1e-13;
};

/// Weighted least squares by Levenberg-Marquardt on exact implicit derivatives. Without parameters
/// only the zeros are estimated, if the campaign asks for that. Throws files::NotIdentifiable
/// naming the parameters (or the combination) that no reading depends on, files::NoConvergence with
/// the reading that has no equilibrium, or when the iteration stalls; files::InputError when noise
/// is needed to compare translations with rotations and nothing states it.
BaseFit fit_base(const Predictor& predictor, const Campaign& campaign, const Noise& noise,
                 const std::vector<Parameter>& parameters, files::Progress& progress,
                 const BaseFitOptions& options = {});

}  // namespace kinetostat::calibration

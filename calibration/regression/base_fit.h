// Fits the parameters that the user declared uncertain, so that a model is not blamed for a
// parameter that nobody claimed to know.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/noise.h"
#include "kinetostat/calibration/regression/predict.h"
#include "kinetostat/calibration/statistics/least_squares.h"
#include "kinetostat/common/error.h"

namespace kinetostat::calibration {

/// Norm of their readings, each over its noise.
double norm_over_noise(const std::vector<Value>& values, const Campaign& campaign,
                       const Noise& noise);

/// The zero offset of one session and component, SI.
struct Zero {
  std::size_t session = 0;
  Eigen::Index component = 0;
  double value = 0;
  double standard_error = 0;
};

/// Where the measuring frame of one session really was: position [m] and rotation vector [rad] of
/// the stated frame, seen from it. In differences only the rotation matters; the position is NaN. A
/// coordinate that no reading determines keeps its starting value and has no standard error (NaN).
struct FrameEstimate {
  std::size_t session = 0;
  spatial::Vector6 value = spatial::Vector6::Zero(), standard_error = spatial::Vector6::Zero();
};

/// Where that sits which a sensor looks at, seen from where the campaign has it: position [m] in
/// axes of the platform, or of what carries the sensor, and rotation vector [rad]. The rotation is
/// NaN where no reading shows it. A coordinate that the readings do not distinguish from frames, or
/// not at all, stays 0 and has no standard error (NaN).
struct TargetEstimate {
  std::size_t sensor = 0;
  spatial::Vector6 value = spatial::Vector6::Zero(), standard_error = spatial::Vector6::Zero();
};

struct ParameterEstimate {
  Parameter parameter;
  double value = 0;  // of its coordinate: the logarithm of a stiffness factor
  double standard_error = 0;
  BoundHit hit = BoundHit::none;  // then there is no standard error
};

/// A model with its parameters, zero offsets and frames at their best values.
struct BaseFit {
  std::vector<ParameterEstimate> parameters;
  std::vector<Zero> zeros;
  std::vector<FrameEstimate> frames;
  std::vector<TargetEstimate> targets;  // that the campaign asks for
  Eigen::MatrixXd covariance;  // of the parameters, zero offsets, frames and targets, in that order
  /// Where the standard errors come from; `unknown`: from the residual itself, so they take the
  /// model to be right.
  NoiseSource error_source = NoiseSource::unknown;
  std::vector<std::string> weak;  // what the data hardly distinguish, in sentences
  Loss loss = Loss::squares;
  /// One entry a value in use, in the order of values_in_use: how much it counted.
  std::vector<double> weights;
  /// Predicted entries of the table, zero offsets and frames included, SI; one a reading.
  std::vector<Eigen::VectorXd> predicted;
  /// The wrench that works on the platform's displacement, one entry a reading: [force; moment
  /// about what is measured] in the axes of the displacements [N, N m].
  std::vector<spatial::Vector6> work;
  Predictions model;  // at or near the best values, without zero offsets, frames and derivatives
  /// Whitened predicted minus measured of the values in use, and its derivatives with respect to
  /// the parameters, zero offsets and frames, at the best values.
  Linearisation at;
  double squared_error = 0;  // sum of squares of the whitened residuals in use
  Eigen::Index values = 0;   // how many there are
  int iterations = 0;
  bool is_settled = true;  // else the best so far (BaseFitOptions::accept_unsettled)

  /// Number of parameters, zero offsets and frame coordinates that were estimated; one that a bound
  /// holds was not.
  Eigen::Index estimated = 0;
  Eigen::Index degrees_of_freedom() const { return values - estimated; }
};

/// The frame of a session that a fit found, 0 for coordinates that it does not know; nothing where
/// it has none.
std::optional<spatial::Vector6> known_frame(const BaseFit& fit, std::size_t session);
/// The targets that a fit found, without derivatives.
std::vector<TargetOffset> targets_of(const BaseFit& fit);

/// Best values of the parameters, in their order.
Eigen::VectorXd values_of(const BaseFit& fit);

/// The parameters of a fit, each held at its best value and without a prior.
std::vector<Parameter> held_parameters(const BaseFit& fit);

struct BaseFitOptions {
  int max_iterations = 100;
  /// Ends when a step changes the predictions by less than this, relative to the readings.
  double tolerance = 1e-13;
  /// Ends as well when the fifth step in a row promises to lower the squared error by less.
  double least_gain = 0;
  Loss loss = Loss::squares;
  const Predictions* near = nullptr;  // of a similar model, to save time
  /// BaseFit::model of a long table has one state a configuration, which saves most of its memory.
  bool few_states = false;
  bool accept_unsettled = false;  // the best so far, where the iteration does not converge
};

/// Predictions of a fitted model for other readings of its campaign. `others` uses no reading that
/// the fit used. Parameters stay as fitted, and so do zero offsets and frames of sessions that the
/// fit knows. Those of further sessions are estimated from `others` itself.
BaseFit predict_others(const Predictor& predictor, const Campaign& others, const Noise& noise,
                       const BaseFit& fit, common::Progress& progress);

/// Weighted least squares within bounds on exact implicit derivatives. Without parameters only the
/// zero offsets and frames are estimated, as far as the campaign asks for them. Throws
/// common::NotIdentifiable naming the parameters (or the combination) that no reading depends on,
/// or one that diverges; common::NoConvergence with the reading that has no equilibrium, or when
/// the iteration stalls; common::InputError when noise is needed to compare translations with
/// rotations, or for a robust loss, and nothing states it, and naming a value whose error over its
/// noise is too large to compute with.
BaseFit fit_base(const Predictor& predictor, const Campaign& campaign, const Noise& noise,
                 const std::vector<Parameter>& parameters, common::Progress& progress,
                 const BaseFitOptions& options = {});

/// Where a fit would end.
struct CondensedFit {
  Eigen::VectorXd values;  // of its parameters
  double cost = 0;  // squared error and penalties of priors, of which a fit says more exactly
};

/// Where fit_base() would end, in a small share of its time, with a model that has one effect more
/// than a fitted one: a law in one joint, which is exact (`condensed` is the fitted model), as is
/// the stiffness of that joint. What the other parameters change counts as it did in the fit, that
/// of a stiffness k in proportion to 1/k. The first `parameters` are those of the fit; `own` is the
/// stiffness of the joint, where it is among them. nullopt where no start has equilibria.
std::optional<CondensedFit> fit_condensed(const Predictor& predictor, const Campaign& campaign,
                                          const Noise& noise,
                                          const std::vector<Parameter>& parameters,
                                          std::optional<std::size_t> own, const BaseFit& fitted,
                                          const CondensedModel& condensed,
                                          common::Progress& progress);

/// Nothing where a fit finds no equilibrium for some reading, or cannot determine its parameters.
template <class Fit>
std::optional<BaseFit> if_possible(const Fit& fit) {
  try {
    return fit();
  } catch (const common::NoConvergence&) {
    return std::nullopt;
  } catch (const common::NotIdentifiable&) {
    return std::nullopt;
  }
}

/// The same equations at other values of the parameters (and with other parameters), zero offsets
/// and frames as in `fit`. Derivatives are with respect to the last `differentiated` parameters;
/// the columns of the others are zero. `without` (or nullptr): the fitted model, condensed, where
/// this one has one effect more. nullopt where the model has no equilibrium for a reading.
std::optional<Linearisation> linearised_at(const Predictor& predictor, const Campaign& campaign,
                                           const Noise& noise,
                                           const std::vector<Parameter>& parameters,
                                           const Eigen::VectorXd& values, const BaseFit& fit,
                                           Eigen::Index differentiated, common::Progress& progress,
                                           const CondensedModel* without = nullptr);

}  // namespace kinetostat::calibration

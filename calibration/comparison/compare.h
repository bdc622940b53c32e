// Compares a model with measurements: where does it fail, and is that more than noise?
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/pure_error.h"
#include "kinetostat/calibration/comparison/missing_sensor.h"
#include "kinetostat/calibration/comparison/patterns.h"
#include "kinetostat/calibration/regression/base_fit.h"
#include "kinetostat/calibration/statistics/goodness_of_fit.h"

namespace kinetostat::calibration {

/// Residuals (measured - predicted) of one component, SI.
struct ResidualStatistics {
  Eigen::Index component = 0;
  std::optional<std::size_t> session;  // none: over all sessions
  Eigen::Index count = 0;
  double rms = 0;
  double max = 0;                 // largest magnitude
  std::size_t worst_reading = 0;  // where that is
  double bias = 0;                // mean
  double share = 0;               // of the whole whitened sum of squares
};

enum class Adequacy {
  adequate,       // no test finds more than noise
  inadequate,     // a test does, at 5 % shared by the tests that were made
  not_evaluated,  // the noise is known from nothing but the residual itself
  inconclusive    // no test finds more than noise, and a sensor is missing that would find out
};

/// Readings of another role, predicted by a model that was fitted without them.
struct HeldOutReadings {
  Role role = Role::confirm;
  Eigen::Index values = 0;
  Eigen::Index estimated = 0;  // zero offsets and frames of sessions that only they belong to
  double squared_error = 0;    // whitened
  std::vector<ResidualStatistics> by_component;
  /// Test against the noise alone, without the uncertainty of the fitted parameters. Only with a
  /// known noise.
  std::optional<ChiSquareTest> chi_square;
  std::string failure;  // why there is nothing but the number of values; else empty
};

/// A model against the readings, with its zero offsets and (when fitted) its parameters at their
/// best values.
struct Assessment {
  BaseFit fit;
  std::vector<Eigen::VectorXd> residual;  // one a reading, SI; NaN where not measured
  std::vector<Eigen::VectorXd> whitened;  // in units of the noise
  std::vector<ResidualStatistics> by_component;
  std::vector<ResidualStatistics> by_session;  // empty with one session
  std::vector<HeldOutReadings> held_out;       // one a role that some readings have, but `fit`
  Patterns patterns;                           // what the residual depends on
  bool is_exact = false;  // the residual is nothing but rounding of the equilibrium
  /// sqrt(sum of squares / degrees of freedom) [m or rad], when only translations or only rotations
  /// are measured, or one other dimension. A description of the misfit, not an estimate of the
  /// noise.
  std::optional<double> residual_deviation;
  std::optional<ChiSquareTest> chi_square;   // only with a stated noise
  std::optional<LackOfFitTest> lack_of_fit;  // only with replicates
  Adequacy adequacy = Adequacy::not_evaluated;

  /// Root mean square of the whitened residuals.
  double error_over_noise() const {
    return std::sqrt(fit.squared_error / static_cast<double>(fit.values));
  }
};

struct Comparison {
  /// Noise of all readings by which best() was judged, the effect of the noise of the wrenches
  /// included.
  Noise noise;
  Eigen::Index groups = 0;  // distinct states times components
  /// Scatter of the replicates, over the stated noise if there is one, else raw; when they exist.
  std::optional<PureError> replicates;
  /// Does the scatter of the replicates agree with the stated noise? When both exist.
  std::optional<ChiSquareTest> noise_check;
  std::string unit_error;  // unit error or sign error that the readings look like; else empty
  Assessment nominal;
  std::optional<Assessment> fitted;  // when the robot file declares something uncertain
  std::string refit_failure;         // which of it the data cannot determine, and why; else empty
  /// What stays at its nominal value, what to make of fitted stiffnesses, why a test was not made.
  std::vector<std::string> notes;
  /// What would determine the uncertain values that the readings of sensors leave open.
  std::optional<MissingSensor> missing_sensor;

  /// The fitted model where there is one.
  const Assessment& best() const { return fitted ? *fitted : nominal; }
  /// That of best(), unless a sensor is missing: a model whose uncertain values may be anything
  /// explains too much.
  Adequacy adequacy() const {
    const bool open = best().adequacy == Adequacy::adequate && missing_sensor.has_value();
    return open ? Adequacy::inconclusive : best().adequacy;
  }
};

struct CompareOptions {
  Loss loss = Loss::squares;
  bool keep_equations = false;  // BaseFit::at, which are large for a long table
};

/// Throws what Predictor and fit_base throw. A fit that the data cannot determine does not throw:
/// `refit_failure` has the reason, and the nominal assessment is there.
Comparison compare(const vjm::Robot& robot, const Campaign& campaign, int threads,
                   common::Progress& progress, const CompareOptions& options = {});

}  // namespace kinetostat::calibration

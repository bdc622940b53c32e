// Factors on which the residual depends: posture, load, branch, session, time and whatever else the
// table has.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/comparison/load_loops.h"
#include "kinetostat/calibration/regression/base_fit.h"

namespace kinetostat::calibration {

/// Readings that have one thing in common, and the error they hold.
struct PatternGroup {
  std::string label;  // "unloading", "posture (10, 20, 0) mm"
  Eigen::Index values = 0;
  double share = 0;            // of the whitened sum of squares of all groups
  double share_of_values = 0;  // the same share of the values
  double mean = 0;             // whitened residual; along the load where `along_load`
  std::optional<Eigen::Index> component =
      {};  // that holds most of its error, with that share of it
  double component_share = 0;
};

/// A test that the residual does not depend on one thing. Holm's correction is over all tests of
/// one assessment.
struct PatternTest {
  double f = 0;
  Eigen::Index degrees_of_freedom = 0, degrees_of_freedom_within = 0;
  double p_value = 1, holm_p_value = 1;
};

/// Dependence of the residual on one thing.
struct Pattern {
  std::string factor;       // "posture", "reach", "direction of load", ..., or a covariate's name
  bool along_load = false;  // signed residuals are counted along the load
  bool is_trend = false;    // tested as a straight line over a number, not between groups
  std::vector<PatternGroup> groups = {};  // largest share first
  /// Test of the mean of the residual (one-way analysis of variance, each component about its own
  /// mean, or straight line), and test of its magnitude |r|: of sqrt(|r|), which is nearly normal
  /// when the residual is (Hawkins and Wixley 1986). nullopt where the groups allow no test.
  std::optional<PatternTest> bias = {}, size = {};

  double holm_p_value() const;  // the smaller of both
};

/// Residuals of readings under equal and opposite loads.
struct Reversal {
  Eigen::Index pairs = 0;
  double odd_share = 0;  // of their squared error: the part that changes sign with the load
  PatternTest test;      // odd against even part; equal for mere noise
};

struct Patterns {
  std::vector<Pattern> factors;  // most significant first
  std::optional<Reversal> reversal;
  LoadLoops loops;
};

/// `residual` [m; rad], `whitened` and `work` (BaseFit), one entry a reading. `parameters`: how
/// many were fitted.
/// Empty when the residual is nothing but rounding. No figure depends on the order of rows, on
/// units or on the point about which wrenches are stated.
Patterns find_patterns(const Campaign& campaign, const std::vector<Eigen::VectorXd>& residual,
                       const std::vector<Eigen::VectorXd>& whitened,
                       const std::vector<spatial::Vector6>& work, Eigen::Index parameters,
                       const Noise& noise);

/// Adjusts p-values so that the chance of any false alarm among them is bounded (Holm 1979).
std::vector<double> holm(const std::vector<double>& p_values);

}  // namespace kinetostat::calibration

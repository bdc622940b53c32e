// A rival without a form of its own: is there anything smooth in a residual, whatever it is? It can
// say that something is missing and what that depends on, never what it is.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/base_fit.h"
#include "kinetostat/calibration/residual_space.h"

namespace kinetostat::calibration {

struct FreeFormEvidence {
  /// Logarithm of the evidence of a free-form error over that of noise alone. Averaged over
  /// processes whose priors are fixed beforehand, it is a bet against the noise: with nothing
  /// missing its exponential is above 1/p with a probability of at most p (Ville 1939; Gruenwald
  /// et al., J. R. Stat. Soc. B 86, 2024).
  double log = 0;
  std::string depends_on;  // the most probable process: "posture, as a force on the platform does"

  double p_value() const;
};

/// Gaussian processes over what is known of each reading: an unknown function of posture, load,
/// both, the time, the time in a cycle (and load) or the temperature, smooth or straight, that acts
/// on the displacements themselves, as a force on the platform, or as a change of what is
/// uncertain. The amplitude of each has a log-uniform prior; the processes are equally likely.
class FreeForm {
 public:
  /// `by_force`: change of the whitened values with a force on the platform, three columns;
  /// `by_uncertain`: with what every fit changes. Both may have no columns.
  FreeForm(const Campaign& campaign, const std::vector<Value>& values,
           const Eigen::MatrixXd& by_force, const Eigen::MatrixXd& by_uncertain);

  /// In a residual beside all that the space's fit can produce, with flat priors for that
  /// (restricted likelihood). `temper`: as in evidence().
  FreeFormEvidence evidence(const ResidualSpace& space, double temper) const;

 private:
  // What an unknown function may depend on: one row a reading.
  struct Feature {
    std::string name;
    Eigen::MatrixXd of_reading;
    std::vector<double> lengths;  // over which it changes; 0: it is straight
  };
  // What it may act through: one row a value, one column for each function of its own.
  struct Channel {
    std::string name;
    Eigen::MatrixXd columns;
  };
  void add(const std::string& name, Eigen::MatrixXd of_reading, std::vector<double> lengths);
  Eigen::MatrixXd root_of_kernel(const Channel& channel, const Feature& feature,
                                 double length) const;

  std::vector<Feature> features_;
  std::vector<Channel> channels_;
  std::vector<Eigen::Index> reading_;  // of each value
};

}  // namespace kinetostat::calibration

// Is there anything smooth left in a residual, whatever it is? A free-form rival of the effects: it
// can say that something is missing and what that depends on, never what it is.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/base_fit.h"
#include "kinetostat/calibration/residual_space.h"

namespace kinetostat::calibration {

/// Gaussian processes over what is known of each reading. A kernel says which readings would have
/// similar errors if the residual depended smoothly on one thing; the score test of its variance is
/// r'Kr / r'r (Lin 1997). It needs no fit and does not take the noise for granted.
class Structure {
 public:
  Structure(const Campaign& campaign, const std::vector<Value>& values);

  /// "posture", "load", "posture and load together", "time", ..., as far as they vary.
  const std::vector<std::string>& names() const { return names_; }
  /// One statistic a kernel.
  Eigen::VectorXd statistics(const Eigen::VectorXd& residual) const;

 private:
  void add(const std::string& name, const Eigen::MatrixXd& features,
           const std::vector<Value>& values);

  std::vector<std::string> names_;
  std::vector<Eigen::MatrixXd> kernels_;  // their lower triangles
  std::vector<Eigen::Index> rows_;        // values that take part: all, or evenly spread ones
};

/// A test of all kernels at once against residuals of noise alone.
struct StructureTest {
  double p_value = 1;      // for the largest of all
  std::string depends_on;  // the kernel that sees most
  double excess = 0;       // its statistic in standard deviations above noise
};

StructureTest structure_test(const Structure& structure, const ResidualSpace& space, int draws,
                             std::uint64_t seed, int threads);

}  // namespace kinetostat::calibration

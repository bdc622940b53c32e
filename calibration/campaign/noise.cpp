#include "kinetostat/calibration/campaign/noise.h"

#include <Eigen/Cholesky>

namespace kinetostat::calibration {

void Noise::whiten(std::size_t reading, const std::vector<Eigen::Index>& used,
                   Eigen::Ref<Eigen::MatrixXd> rows) const {
  for (std::size_t i = 0; i < used.size(); ++i)
    rows.row(static_cast<Eigen::Index>(i)) /= sigma[reading][used[i]];
  if (correlation.empty() || correlation[reading] == nullptr) return;
  const Eigen::MatrixXd part = (*correlation[reading])(used, used);
  Eigen::LLT<Eigen::MatrixXd>(part).matrixL().solveInPlace(rows);
}

}  // namespace kinetostat::calibration

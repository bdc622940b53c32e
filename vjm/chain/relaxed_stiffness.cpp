#include "kinetostat/vjm/chain/relaxed_stiffness.h"

namespace kinetostat::vjm {

Eigen::MatrixXd relaxed_stiffness(const Chain& chain, const Eigen::VectorXd& x) {
  Eigen::MatrixXd stiffness = chain.stiffness();
  const Eigen::VectorXd relaxed = Eigen::VectorXd::Zero(chain.size());
  for (const auto& [k, law] : chain.laws())
    stiffness(k, k) += chain.value_of(k, *law, x, relaxed, relaxed).tangent;
  return stiffness;
}

}  // namespace kinetostat::vjm

#include "kinetostat/vjm/chain/redundant_passive.h"

#include <algorithm>
#include <cmath>

#include <Eigen/QR>

#include "kinetostat/vjm/chain/robust_factor.h"

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

using PivotedQr = Eigen::ColPivHouseholderQR<Eigen::MatrixXd>;

// The twists of some coordinates, rotations scaled to lengths, columns of unit length.
Eigen::MatrixXd twists_of(const ChainKinematics& kinematics,
                          const std::vector<Index>& coordinates) {
  Eigen::MatrixXd columns = kinematics.jacobian(Eigen::all, coordinates);
  columns.bottomRows<3>() *= kinematics.reach > 0 ? kinematics.reach : 1.0;
  return columns.colwise().normalized();
}

PivotedQr factorised(const Eigen::MatrixXd& twists) {
  PivotedQr qr;
  qr.setThreshold(1e-8);
  qr.compute(twists);
  return qr;
}

// Coordinates in no special position: multiples of an irrational number, spread over one turn or
// over the size of the chain.
VectorXd general_position(const Chain& chain, double size) {
  constexpr double golden = 0.6180339887498949;
  VectorXd x(chain.size());
  for (Index k = 0; k < x.size(); ++k) {
    const double spread = std::fmod(golden * static_cast<double>(k + 1), 1.0) - 0.5;
    const bool turns = is_rotation(chain.coordinates()[static_cast<std::size_t>(k)].motion);
    x[k] = spread * (turns ? 2 * M_PI : size);
  }
  return x;
}

}  // namespace

std::vector<Index> perfect_passive(const Chain& chain) {
  std::vector<Index> found;
  for (Index k = 0; k < chain.size(); ++k) {
    const bool has_law = std::any_of(chain.laws().begin(), chain.laws().end(),
                                     [k](const auto& law) { return law.first == k; });
    if (chain.coordinates()[static_cast<std::size_t>(k)].role == Role::passive &&
        chain.stiffness()(k, k) == 0 && !has_law)
      found.push_back(k);
  }
  return found;
}

std::vector<Index> redundant_passive(const Chain& chain, const ChainKinematics& at) {
  const std::vector<Index> passive = perfect_passive(chain);
  if (passive.size() < 2) return {};
  const Eigen::MatrixXd twists = twists_of(at, passive);
  if (has_clearly_full_row_rank(twists.transpose())) return {};
  ChainKinematics general;
  evaluate(chain, general_position(chain, at.reach > 0 ? at.reach : 1.0), general);
  const Index rank = factorised(twists_of(general, passive)).rank();
  const PivotedQr here = factorised(twists);
  const auto& order = here.colsPermutation().indices();
  std::vector<Index> redundant;
  for (Index i = rank; i < order.size(); ++i)
    redundant.push_back(passive[static_cast<std::size_t>(order[i])]);
  return redundant;
}

}  // namespace kinetostat::vjm

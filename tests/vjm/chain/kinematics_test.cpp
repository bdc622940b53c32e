#include "kinetostat/vjm/chain/kinematics.h"

#include <gtest/gtest.h>

#include "kinetostat/vjm/chain/chain_builder.h"

#include "vjm/random_chain.h"

namespace kinetostat::vjm::kinematics_test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Vector6;

TEST(Kinematics, JacobianIsTheDerivativeOfThePose) {
  samples::RandomChains random(1);
  ChainKinematics at, before, after;
  for (int trial = 0; trial < 50; ++trial) {
    const Chain chain = random.chain(trial % 5);
    const VectorXd x = random.state(chain, 1.0);
    evaluate(chain, x, at);
    const double h = 1e-6;
    for (Eigen::Index k = 0; k < chain.size(); ++k) {
      const VectorXd step = h * VectorXd::Unit(chain.size(), k);
      evaluate(chain, x - step, before);
      evaluate(chain, x + step, after);
      const Vector6 numerical = spatial::pose_difference(before.end, after.end) / (2 * h);
      EXPECT_LT((numerical - at.jacobian.col(k)).norm(), 1e-8) << "trial " << trial << " x" << k;
    }
  }
}

TEST(Kinematics, HessianIsTheDerivativeOfTheGeneralisedForces) {
  samples::RandomChains random(2);
  ChainKinematics at, before, after;
  MatrixXd hessian;
  for (int trial = 0; trial < 50; ++trial) {
    const Chain chain = random.chain(trial % 5);
    const VectorXd x = random.state(chain, 1.0);
    const Vector6 wrench = random.vector6(1.0, 1.0);
    evaluate(chain, x, at);
    hessian.setZero(chain.size(), chain.size());
    add_wrench_hessian(chain, at, {at_end(chain, at, wrench)}, hessian);
    const double h = 1e-6;
    for (Eigen::Index l = 0; l < chain.size(); ++l) {
      const VectorXd step = h * VectorXd::Unit(chain.size(), l);
      evaluate(chain, x - step, before);
      evaluate(chain, x + step, after);
      const VectorXd numerical = (after.jacobian - before.jacobian).transpose() * wrench / (2 * h);
      EXPECT_LT((numerical - hessian.col(l)).norm(), 1e-8) << "trial " << trial << " x" << l;
    }
  }
}

TEST(Kinematics, WrenchesAtNodesHaveExactForcesAndHessians) {
  samples::RandomChains random(4);
  ChainKinematics at, before, after;
  for (int trial = 0; trial < 20; ++trial) {
    const Chain chain = random.chain(trial % 4, true);
    const VectorXd x = random.state(chain, 1.0);
    const Vector6 wrench = random.vector6(1.0, trial % 2);
    const std::size_t node = chain.node_index("elbow");
    const auto force = [&](const VectorXd& state, ChainKinematics& kinematics) {
      evaluate(chain, state, kinematics);
      VectorXd f = VectorXd::Zero(chain.size());
      add_generalised_force(chain, kinematics, at_node(chain, kinematics, node, wrench), f);
      return f;
    };
    const VectorXd f = force(x, at);
    MatrixXd hessian = MatrixXd::Zero(chain.size(), chain.size());
    add_wrench_hessian(chain, at, {at_node(chain, at, node, wrench)}, hessian);
    const double h = 1e-6;
    for (Eigen::Index l = 0; l < chain.size(); ++l) {
      const VectorXd step = h * VectorXd::Unit(chain.size(), l);
      const VectorXd slope = (force(x + step, after) - force(x - step, before)) / (2 * h);
      EXPECT_LT((slope - hessian.col(l)).norm(), 1e-8);
      // The force part alone is the derivative of the node's position.
      if (wrench.tail<3>().isZero()) {
        EXPECT_NEAR((after.nodes[node] - before.nodes[node]).dot(wrench.head<3>()) / (2 * h), f[l],
                    1e-8);
      }
    }
  }
}

TEST(Kinematics, HessianOfAPureForceIsSymmetricAndThatOfAMomentIsNot) {
  samples::RandomChains random(3);
  const Chain chain = random.chain(3);
  ChainKinematics at;
  MatrixXd hessian;
  evaluate(chain, random.state(chain, 1.0), at);
  hessian.setZero(chain.size(), chain.size());
  add_wrench_hessian(chain, at, {at_end(chain, at, random.vector6(1.0, 0.0))}, hessian);
  EXPECT_LT((hessian - hessian.transpose()).norm(), 1e-14);
  hessian.setZero();
  add_wrench_hessian(chain, at, {at_end(chain, at, random.vector6(0.0, 1.0))}, hessian);
  EXPECT_GT((hessian - hessian.transpose()).norm(), 1e-2);
}

TEST(Kinematics, CoupledJointsShareACoordinate) {
  // Parallelogram (JAMRIS09 eq. 22): Ry(q) Tx(L) Ry(-q) translates along a circle without turning.
  const double length = 0.31, q = 0.4;
  ChainBuilder chain("parallelogram");
  chain.passive("q", Motion::ry).offset(spatial::Pose::translation({length, 0, 0}));
  chain.coupled("q", Motion::ry, -1);
  ChainKinematics at;
  evaluate(chain.build(), VectorXd::Constant(1, q), at);
  EXPECT_TRUE(at.end.rotation().isIdentity(1e-15));
  EXPECT_TRUE(at.end.position().isApprox(
      spatial::Vector3(length * std::cos(q), 0, -length * std::sin(q)), 1e-15));
  EXPECT_TRUE(at.jacobian.bottomRows<3>().isZero(1e-15));
}

}  // namespace
}  // namespace kinetostat::vjm::kinematics_test

#include "kinetostat/vjm/statics/fixed_point.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "kinetostat/vjm/statics/chainwise_factor.h"

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Matrix6;
using spatial::Pose;
using spatial::Vector6;

// One chain in the variables of MMT11: theta with springs, q without.
class ChainIteration {
 public:
  ChainIteration(const Chain& chain, const VectorXd& rest, double length)
      : chain_(chain), rest_(rest) {
    for (Index k = 0; k < chain.size(); ++k) {
      const Coordinate& c = chain.coordinates()[static_cast<std::size_t>(k)];
      unit_.conservativeResize(k + 1);
      unit_[k] = is_rotation(c.motion) ? length : 1.0;
      if (chain.stiffness()(k, k) != 0) springs_.push_back(k);
      if (chain.stiffness()(k, k) == 0 && c.role == Role::passive) passive_.push_back(k);
    }
    compliance_ = chain.stiffness()(springs_, springs_)
                      .llt()
                      .solve(MatrixXd::Identity(static_cast<Index>(springs_.size()),
                                                static_cast<Index>(springs_.size())));
    scale_ << Vector6::Ones();
    scale_.tail<3>().setConstant(length);
  }

  // Eq. 10 once; returns how far the coordinates moved, scaled to lengths. Unknown is the change of
  // q, so that redundant passive joints, of which the shortest solution is taken, stay near.
  double step(const Pose& target, VectorXd& x, Vector6& wrench) {
    evaluate(chain_, x, kinematics_);
    const MatrixXd by_springs = scale_.asDiagonal() * kinematics_.jacobian(Eigen::all, springs_);
    const MatrixXd by_passive = scale_.asDiagonal() * kinematics_.jacobian(Eigen::all, passive_);
    const VectorXd deflection = (x - rest_)(springs_);
    const Index n = by_passive.cols();
    const MatrixXd flexibility = by_springs * compliance_ * by_springs.transpose();
    const double size = flexibility.cwiseAbs().maxCoeff();
    MatrixXd matrix = MatrixXd::Zero(6 + n, 6 + n);
    matrix.topLeftCorner<6, 6>() = flexibility / size;
    matrix.topRightCorner(6, n) = by_passive;
    matrix.bottomLeftCorner(n, 6) = by_passive.transpose();
    VectorXd right = VectorXd::Zero(6 + n);
    right.head<6>() = scale_.cwiseProduct(spatial::pose_difference(kinematics_.end, target)) +
                      by_springs * deflection;
    RobustFactor factor;
    factor.compute(matrix);
    const VectorXd solution = factor.solve(right);
    wrench = scale_.cwiseProduct(solution.head<6>() / size);
    VectorXd next = x;
    next(passive_) += solution.tail(n);
    next(springs_) =
        rest_(springs_) +
        compliance_ * (kinematics_.jacobian(Eigen::all, springs_).transpose() * wrench);
    const double moved = (next - x).cwiseProduct(unit_).norm();
    x = next;
    return moved;
  }

 private:
  const Chain& chain_;
  VectorXd rest_, unit_;
  std::vector<Index> springs_, passive_;
  MatrixXd compliance_;
  Vector6 scale_;
  ChainKinematics kinematics_;
};

void refuse_what_the_papers_do_not_treat(const Manipulator& manipulator, const Load& load,
                                         const EquilibriumSystem& system) {
  const auto refuse = [](const char* what) {
    throw std::invalid_argument(fmt::format("the fixed-point iteration does not treat {}", what));
  };
  if (!manipulator.elastic_bodies().empty()) refuse("elastic bodies");
  if (!manipulator.is_parallel()) refuse("bodies between base and platform");
  if (!load.nodes.empty()) refuse("loads at nodes");
  if (!load.joints.empty()) refuse("loads in joints");
  if (system.has_rigid_directions())
    refuse("chains with fewer than six independent springs and passive joints");
  for (const Chain& chain : manipulator.chains()) {
    if (!chain.laws().empty()) refuse("stops");
    if (!chain.masses().empty() && !manipulator.gravity().isZero(0)) refuse("weight");
  }
}

class Iteration {
 public:
  Iteration(const Manipulator& manipulator, const Posture& posture, const Load& load,
            const FixedPointOptions& options)
      : posture_(posture),
        options_(options),
        system_(manipulator, posture),
        state_(system_.relaxed_state()) {
    refuse_what_the_papers_do_not_treat(manipulator, load, system_);
    for (std::size_t c = 0; c < manipulator.size(); ++c)
      chains_.emplace_back(manipulator.chains()[c], posture.rest(manipulator.chains()[c], c),
                           system_.scale().length);
  }

  FixedPoint at_pose(const Pose& target) {
    const Vector6 displacement = spatial::pose_difference(posture_.platform, target);
    return in_steps([&](double alpha) {
      state_.bodies[0] = spatial::displaced(posture_.platform, alpha * displacement);
      result_.changes.clear();
      return hold(&result_.changes);
    });
  }

  FixedPoint under_load(const Load& load) {
    return in_steps([&](double alpha) {
      result_.changes.clear();
      return carry(load.scaled(alpha));
    });
  }

 private:
  // Eq. 10 until all chains stand still at the platform's pose.
  bool hold(std::vector<double>* changes) {
    const double reach = system_.scale().length;
    for (int i = 0; i < options_.max_iterations; ++i) {
      ++result_.iterations;
      double squares = 0;
      for (std::size_t c = 0; c < chains_.size(); ++c) {
        const double moved =
            chains_[c].step(state_.bodies[0], state_.coordinates[c], state_.wrenches[c]);
        squares += moved * moved;
      }
      const double change = std::sqrt(squares) / reach;
      if (changes) changes->push_back(change);
      if (!std::isfinite(change) || change > 1e6) break;
      if (change <= options_.tolerance) return true;
    }
    why_ = "the chains did not come to rest at a given pose (eq. 10)";
    return false;
  }

  // Eq. 11 with eq. 10 inside.
  bool carry(const Load& load) {
    const double reach = system_.scale().length;
    for (int i = 0; i < options_.max_iterations; ++i) {
      if (!hold(nullptr)) return false;
      const EquilibriumResiduals at(system_, state_, load);
      RobustFactor factor;
      const Vector6 length = system_.scale().twist(), force = system_.scale().wrench();
      factor.compute(force.asDiagonal() * ChainwiseFactor(at, false).platform_stiffness() *
                     length.cwiseInverse().asDiagonal());
      const Vector6 missing =
          force.cwiseProduct(load.at_reference_point(state_.bodies[0]) - at.platform_wrench());
      bool consistent = true;
      const Vector6 correction = factor.solve(missing, &consistent);
      result_.changes.push_back(correction.norm() / reach);
      why_ = "the platform did not come to rest (eq. 11)";
      if (!consistent || !std::isfinite(correction.norm()) || correction.norm() > reach)
        return false;
      state_.bodies[0] = spatial::displaced(state_.bodies[0], correction.cwiseQuotient(length));
      if (correction.norm() <= options_.tolerance * reach) return hold(nullptr);
    }
    return false;
  }

  template <class Step>
  FixedPoint in_steps(const Step& step) {
    for (int i = 1; i <= options_.load_steps; ++i) {
      const SystemState last = state_;
      if (!step(static_cast<double>(i) / options_.load_steps)) {
        state_ = last;
        result_.reason = fmt::format("{}, after {} iterations", why_, result_.iterations);
        finish();
        return result_;
      }
      result_.reached = static_cast<double>(i) / options_.load_steps;
    }
    result_.converged = true;
    finish();
    return result_;
  }

  void finish() {
    const EquilibriumResiduals at(system_, state_, Load{});
    result_.platform = state_.bodies[0];
    result_.wrench =
        spatial::Wrench::from_coordinates(at.platform_wrench(), {state_.bodies[0].position()});
    result_.coordinates = state_.coordinates;
  }

  const Posture& posture_;
  const FixedPointOptions& options_;
  const EquilibriumSystem system_;
  SystemState state_;
  std::vector<ChainIteration> chains_;
  FixedPoint result_;
  std::string why_;
};

}  // namespace

FixedPoint fixed_point_at_pose(const Manipulator& manipulator, const Posture& posture,
                               const Pose& pose, const FixedPointOptions& options) {
  return Iteration(manipulator, posture, {}, options).at_pose(pose);
}

FixedPoint fixed_point_under_load(const Manipulator& manipulator, const Posture& posture,
                                  const Load& load, const FixedPointOptions& options) {
  return Iteration(manipulator, posture, load, options).under_load(load);
}

}  // namespace kinetostat::vjm

// Equilibria of robots whose chains run from base to platform: four at a time.
#include <array>
#include <cmath>

#include "kinetostat/vjm/batches/batches.h"
#include "kinetostat/vjm/batches/loaded_chain.h"

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using spatial::Matrix6;
using spatial::Pose;
using spatial::Vector6;

// Of the pivots of the platform's stiffness, before the others are eliminated.
constexpr double clear = 1e-8;

bool may_go_together(const Manipulator& manipulator) {
  if (!manipulator.is_parallel()) return false;
  for (const Chain& chain : manipulator.chains())
    if (!chain.laws().empty() || !LoadedChain(chain).may_be_factorised()) return false;
  return true;
}

bool has_node_moments(const Load& load) {
  return std::any_of(load.nodes.begin(), load.nodes.end(),
                     [](const NodeLoad& node) { return !node.moment.isZero(0); });
}

void set(Vector6Lanes& lanes, int lane, const Vector6& value) {
  for (int i = 0; i < 6; ++i) lanes[i].set(lane, value[i]);
}

Vector6 lane_of(const Vector6Lanes& lanes, int lane) {
  Vector6 value;
  for (int i = 0; i < 6; ++i) value[i] = lanes[i][lane];
  return value;
}

// A general matrix whose symmetric part is clearly positive, factorised without pivots.
class PlatformFactor {
 public:
  void compute(const Matrix6Lanes& matrix) {
    lu_ = matrix;
    for (int k = 0; k < 6; ++k)
      for (int i = k + 1; i < 6; ++i) {
        lu_(i, k) /= lu_(k, k);
        for (int j = k + 1; j < 6; ++j) lu_(i, j) -= lu_(i, k) * lu_(k, j);
      }
  }
  void solve_in_place(Vector6Lanes& x) const {
    for (int i = 0; i < 6; ++i)
      for (int k = 0; k < i; ++k) x[i] -= lu_(i, k) * x[k];
    for (int i = 6; i-- > 0;) {
      for (int k = i + 1; k < 6; ++k) x[i] -= lu_(i, k) * x[k];
      x[i] /= lu_(i, i);
    }
  }

 private:
  Matrix6Lanes lu_;
};

// Where the symmetric part of a matrix is clearly positive.
LaneMask is_clearly_positive(const Matrix6Lanes& matrix) {
  Matrix6Lanes left;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) left(i, j) = 0.5 * (matrix(i, j) + matrix(j, i));
  LaneMask good = LaneMask::all();
  for (int k = 0; k < 6; ++k) {
    const Lanes whole = matrix(k, k);
    good = good & (whole > 0.0) & (left(k, k) > clear * whole);
    for (int j = k + 1; j < 6; ++j) {
      const Lanes factor = left(j, k) / left(k, k);
      for (int i = j; i < 6; ++i) left(i, j) -= factor * left(i, k);
    }
  }
  return good;
}

// Four robots in postures under loads, and Newton's method for them without damping. What is true
// of a lane no other one knows: those that have come to their end, or have failed, stay as they
// are.
class Group {
 public:
  Group(const Manipulator& manipulator, const EquilibriumOptions& options)
      : manipulator_(manipulator), options_(options) {
    chains_.reserve(manipulator.size());
    for (const Chain& chain : manipulator.chains()) chains_.emplace_back(chain);
  }

  void start(const std::vector<Posture>& postures, const std::vector<Load>& loads,
             std::size_t first) {
    for (OfChain& chain : chains_) chain.lanes.reset();
    good_ = LaneMask::all();
    for (int lane = 0; lane < lane_count; ++lane) {
      const std::size_t i = piece_of(first, lane, postures.size());
      loads_[static_cast<std::size_t>(lane)] = &loads[i];
      platforms_[static_cast<std::size_t>(lane)] = postures[i].platform;
      if (has_node_moments(loads[i])) give_up(lane);
      for (std::size_t c = 0; c < chains_.size(); ++c) place(postures[i], c, lane);
    }
  }

  // Newton's method as newton() has it, its whole step taken or the lane given up.
  void run() {
    evaluate();
    find_scales();
    LaneMask active = good_;
    Correction correction, again;  // again: the correction seen from the end of a step
    const Lanes enough = length_ * options_.tolerance;
    for (int i = 0; i < options_.max_iterations && active.any(); ++i) {
      factorise();
      solve(correction);
      const Lanes size = norm(correction);
      good_ = good_ & ((!active) | (size <= length_ * 1e6));
      move(correction, active & good_);
      evaluate();
      solve(again);
      const Lanes left = norm(again);
      good_ = good_ & ((!active) | (left <= size * 0.75) | (size <= enough));
      const LaneMask at_rounding =
          (size <= length_ * 1e-7) & (left <= size * 1e-2) & (left <= enough * 1e3);
      const LaneMask close = active & good_ & ((left <= enough) | at_rounding);
      move(again, close);
      active = active & good_ & !close;
    }
    good_ = good_ & !active;
    evaluate();
    factorise();
    in_lanes([&] { good_ = good_ & is_clearly_positive(tangent_); });
  }

  std::optional<StableEquilibrium> result(int lane) const {
    if (!good_[lane]) return std::nullopt;
    Matrix6 stiffness;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) stiffness(i, j) = stiffness_(i, j)[lane];
    const Pose& platform = platforms_[static_cast<std::size_t>(lane)];
    return StableEquilibrium{platform, spatial::Stiffness6(stiffness, {platform.position()})};
  }

 private:
  struct OfChain {
    explicit OfChain(const Chain& chain) : lanes(chain) {
      for (int i = 0; i < 6; ++i) gap[i] = 0.0;
    }

    LoadedChain lanes;
    Vector6Lanes gap;  // from the chain's end to the platform
  };
  struct Correction {
    Vector6Lanes platform;
    std::vector<std::vector<Lanes>> coordinates;
    std::vector<Vector6Lanes> wrenches;
  };

  void give_up(int lane) {
    LaneMask::Vector yes = good_.vector();
    yes[lane] = 0;
    good_ = LaneMask(yes);
  }

  void place(const Posture& posture, std::size_t c, int lane) {
    LoadedChain& to = chains_[c].lanes;
    const Chain& chain = to.chain();
    const Load& load = *loads_[static_cast<std::size_t>(lane)];
    const VectorXd rest = posture.rest(chain, c),
                   start = chain.rest_for(posture.coordinates_of(chain, c));
    for (Index k = 0; k < chain.size(); ++k) {
      to.x[static_cast<std::size_t>(k)].set(lane, start[k]);
      to.rest[static_cast<std::size_t>(k)].set(lane, rest[k]);
    }
    for (const JointForce& joint : load.joints)
      if (joint.chain == c) {
        Lanes& sum = to.applied[static_cast<std::size_t>(joint.coordinate)];
        sum.set(lane, sum[lane] + joint.force);
      }
    for (const NodeLoad& node : load.nodes)
      if (node.chain == c) to.load_node(node.node, lane, node.force);
    if (manipulator_.gravity().isZero(0)) return;
    for (const PointMass& mass : chain.masses())
      to.load_node(mass.node, lane, load.gravity * mass.mass * manipulator_.gravity());
  }

  void evaluate() {
    for (OfChain& chain : chains_) {
      in_lanes([&] { chain.lanes.evaluate(); });
      for (int lane = 0; lane < lane_count; ++lane) find_gap(chain, lane);
    }
  }

  void find_gap(OfChain& chain, int lane) {
    spatial::Vector3 position;
    spatial::Matrix3 rotation;
    for (int i = 0; i < 3; ++i) {
      position[i] = chain.lanes.end_position()[i][lane];
      for (int j = 0; j < 3; ++j) rotation(i, j) = chain.lanes.end_rotation()(i, j)[lane];
    }
    if (!rotation.allFinite() || !position.allFinite()) give_up(lane);
    if (good_[lane])
      set(chain.gap, lane,
          spatial::pose_difference({rotation, position},
                                   platforms_[static_cast<std::size_t>(lane)]));
  }

  // Those of EquilibriumSystem.
  void find_scales() {
    length_ = 0.0;
    for (const OfChain& chain : chains_) length_ = max(length_, chain.lanes.reach());
    length_ = Lanes::chosen(length_ > 0.0, length_, 1.0);
    double sliding = 0, turning = 0;
    for (const Chain& chain : manipulator_.chains())
      for (Index k = 0; k < chain.size(); ++k) {
        double& largest = is_rotation(chain.coordinates()[static_cast<std::size_t>(k)].motion)
                              ? turning
                              : sliding;
        largest = std::max(largest, chain.stiffness()(k, k));
      }
    stiffest_ = max(Lanes(sliding), turning / (length_ * length_));
  }

  Lanes norm(const Correction& correction) const {
    const Lanes squared_length = length_ * length_;
    Lanes sum(0.0), forces(0.0);
    for (int i = 0; i < 6; ++i)
      sum += correction.platform[i] * correction.platform[i] * (i < 3 ? 1.0 : squared_length);
    for (std::size_t c = 0; c < chains_.size(); ++c) {
      const LoadedChain& chain = chains_[c].lanes;
      for (int i = 0; i < 3; ++i) {
        const Lanes force = correction.wrenches[c][i], moment = correction.wrenches[c][3 + i];
        forces += force * force + moment * moment / squared_length;
      }
      for (std::size_t k = 0; k < chain.order().size(); ++k) {
        const auto coordinate = static_cast<std::size_t>(chain.order()[k]);
        const Lanes x = correction.coordinates[c][k];
        sum += x * x *
               (is_rotation(chain.chain().coordinates()[coordinate].motion) ? squared_length : 1.0);
      }
    }
    return sqrt(sum + forces / (stiffest_ * stiffest_));
  }

  // The matrices at the state that was evaluated last.
  void factorise() {
    in_lanes([&] {
      for (int k = 0; k < 36; ++k) stiffness_.data()[k] = 0.0;
      for (OfChain& chain : chains_) {
        good_ = good_ & chain.lanes.factorise();
        const Matrix6Lanes symmetric = chain.lanes.stiffness();
        const Matrix3Lanes half = chain.lanes.half_moment();
        for (int k = 0; k < 36; ++k) stiffness_.data()[k] += symmetric.data()[k];
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) stiffness_(3 + i, 3 + j) -= half(i, j);
      }
    });
    tangent_ = stiffness_;
    for (int lane = 0; lane < lane_count; ++lane) {
      const auto l = static_cast<std::size_t>(lane);
      const Matrix6 by_load = loads_[l]->derivative(platforms_[l]);
      for (int i = 3; i < 6; ++i)
        for (int j = 3; j < 6; ++j) tangent_(i, j).set(lane, tangent_(i, j)[lane] - by_load(i, j));
    }
    in_lanes([&] { factor_.compute(tangent_); });
  }

  // By the matrices factorised last.
  void solve(Correction& correction) {
    correction.coordinates.resize(chains_.size());
    correction.wrenches.resize(chains_.size());
    Vector6Lanes& platform = correction.platform;
    for (int lane = 0; lane < lane_count; ++lane) {
      const auto l = static_cast<std::size_t>(lane);
      set(platform, lane, loads_[l]->at_reference_point(platforms_[l]));
    }
    in_lanes([&] {
      for (std::size_t c = 0; c < chains_.size(); ++c) {
        chains_[c].lanes.solve(chains_[c].gap, correction.coordinates[c], correction.wrenches[c]);
        for (int i = 0; i < 6; ++i)
          platform[i] -= chains_[c].lanes.wrench[i] + correction.wrenches[c][i];
      }
      factor_.solve_in_place(platform);
      for (std::size_t c = 0; c < chains_.size(); ++c) {
        Vector6Lanes short_of;
        for (int i = 0; i < 6; ++i) short_of[i] = chains_[c].gap[i] + platform[i];
        chains_[c].lanes.solve(short_of, correction.coordinates[c], correction.wrenches[c]);
      }
    });
  }

  void move(const Correction& correction, LaneMask where) {
    for (int lane = 0; lane < lane_count; ++lane) {
      if (!where[lane]) continue;
      Pose& platform = platforms_[static_cast<std::size_t>(lane)];
      platform = spatial::displaced(platform, lane_of(correction.platform, lane));
    }
    const auto add = [where](Lanes& to, Lanes change) {
      to = Lanes::chosen(where, to + change, to);
    };
    for (std::size_t c = 0; c < chains_.size(); ++c) {
      LoadedChain& chain = chains_[c].lanes;
      for (int i = 0; i < 6; ++i) add(chain.wrench[i], correction.wrenches[c][i]);
      for (std::size_t k = 0; k < chain.order().size(); ++k)
        add(chain.x[static_cast<std::size_t>(chain.order()[k])], correction.coordinates[c][k]);
    }
  }

  const Manipulator& manipulator_;
  const EquilibriumOptions& options_;
  std::vector<OfChain> chains_;
  std::array<const Load*, lane_count> loads_{};
  std::array<Pose, lane_count> platforms_;
  LaneMask good_;
  Lanes length_, stiffest_;
  Matrix6Lanes stiffness_, tangent_;  // of the chains; with what the load adds as it turns
  PlatformFactor factor_;
};

}  // namespace

std::vector<std::optional<StableEquilibrium>> stable_equilibria(
    const Manipulator& manipulator, const std::vector<Posture>& postures,
    const std::vector<Load>& loads, const EquilibriumOptions& options) {
  std::vector<std::optional<StableEquilibrium>> results(postures.size());
  if (postures.empty() || !may_go_together(manipulator)) return results;
  Group group(manipulator, options);
  for (std::size_t first = 0; first < postures.size(); first += lane_count) {
    group.start(postures, loads, first);
    group.run();
    for (std::size_t i = first; i < std::min(first + lane_count, postures.size()); ++i)
      results[i] = group.result(static_cast<int>(i - first));
  }
  return results;
}

}  // namespace kinetostat::vjm

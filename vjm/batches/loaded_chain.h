// One chain under load in several states at once: its balance and the matrix of that, factorised.
// Internal to this module.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "kinetostat/vjm/batches/frames.h"
#include "kinetostat/vjm/chain/chain.h"

namespace kinetostat::vjm {

/// The equations of ChainEquations without its scales, for a chain without laws whose nodes take
/// forces alone. With b what the end is short of and [m]x the moment at the end as a cross product,
///
///     [ K-G   -J' ] [dx ]   [ unbalanced ]
///     [ -J     0  ] [dF*] = [     -b     ],    dF = dF* - [0; m x b_w] / 2,
///
/// where G is symmetric: what is not, J_w'[m]x J_w / 2, is moved into dF*. Its factors D have the
/// signs + - + for springs, wrench and joints without a spring, in this order, where the chain with
/// its end held is stable: then LDL' goes without pivots.
class LoadedChain {
 public:
  explicit LoadedChain(const Chain& chain) : chain_(&chain) {
    const auto has_spring = [&](Eigen::Index k) { return chain.stiffness()(k, k) != 0; };
    order_ = chain.free_coordinates();
    springs_ = std::stable_partition(order_.begin(), order_.end(), has_spring) - order_.begin();
    row_.assign(chain.coordinates().size(), -1);
    for (std::size_t k = 0; k < order_.size(); ++k)
      row_[static_cast<std::size_t>(order_[k])] = index(row_at(k));
    x.resize(row_.size());
    rest.resize(row_.size());
    applied.resize(row_.size());
    node_forces_.resize(chain.nodes().size());
    twists_.resize(chain.joints().size());
    jacobian_.resize(row_.size());
    points_.resize(chain.nodes().size());
    diagonal_.resize(size());
    matrix_.resize(size() * size());
    reset();
  }

  Vector6Lanes wrench;  // at the end, base axes
  /// Of all coordinates of the chain: values, rest values, and forces in joints beside the springs.
  std::vector<Lanes> x, rest, applied;

  const Chain& chain() const { return *chain_; }
  /// Coordinates that move, in the order of solutions.
  const std::vector<Eigen::Index>& order() const { return order_; }
  /// With fewer springs than a wrench has components the chain is rigid against some.
  bool may_be_factorised() const { return springs_ >= 6; }

  /// Takes all loads and the wrench away.
  void reset() {
    for (Lanes& force : applied) force = 0.0;
    for (Vector3Lanes& force : node_forces_)
      for (int i = 0; i < 3; ++i) force[i] = 0.0;
    for (int i = 0; i < 6; ++i) wrench[i] = 0.0;
    loaded_.clear();
  }
  /// Adds a force in base axes.
  void load_node(std::size_t node, int lane, const spatial::Vector3& force) {
    for (int i = 0; i < 3; ++i)
      node_forces_[node][i].set(lane, node_forces_[node][i][lane] + force[i]);
    if (std::find(loaded_.begin(), loaded_.end(), node) == loaded_.end()) loaded_.push_back(node);
  }

  /// Kinematics and balance at the state.
  void evaluate() {
    find_joints();
    find_twists();
    find_balance();
  }
  const Matrix3Lanes& end_rotation() const { return rotation_; }
  const Vector3Lanes& end_position() const { return position_; }
  /// Largest distance of a joint from the end.
  Lanes reach() const { return reach_; }

  /// The matrix at the state that was evaluated last; where its factors are clearly as they must
  /// be.
  LaneMask factorise() {
    fill_matrix();
    for (int i = 0; i < 3; ++i) moment_[i] = wrench[3 + i];
    const std::size_t n = size(), s = static_cast<std::size_t>(springs_);
    LaneMask good = LaneMask::all();
    for (std::size_t k = 0; k < n; ++k) {
      if (k == 0 || k == s || k == s + 6)
        for (std::size_t i = k; i < n; ++i) diagonal_[i] = at(i, i);
      const double sign = k >= s && k < s + 6 ? -1 : 1;
      const Lanes pivot = at(k, k);
      good = good & (sign * pivot > clear * (sign * diagonal_[k])) & (sign * pivot > 0.0);
      const Lanes inverse = 1.0 / pivot;
      at(k, k) = inverse;
      const Lanes* column = &at(0, k);
      for (std::size_t j = k + 1; j < n; ++j) {
        const Lanes factor = column[j] * inverse;
        Lanes* to = &at(0, j);
        for (std::size_t i = j; i < n; ++i) to[i] -= column[i] * factor;
      }
      for (std::size_t i = k + 1; i < n; ++i) at(i, k) *= inverse;
    }
    return good;
  }

  /// The stiffness at the end by dF*, symmetric, in both triangles.
  Matrix6Lanes stiffness() const {
    const std::size_t n = size(), s = static_cast<std::size_t>(springs_);
    std::vector<Vector6Lanes> solved(n - s);  // L^-1 of the unit columns of the wrench
    for (std::size_t i = s; i < n; ++i)
      for (std::size_t j = 0; j < 6; ++j) {
        Lanes sum = i == s + j ? 1.0 : 0.0;
        for (std::size_t k = s + j; k < i; ++k) sum -= at(i, k) * solved[k - s][index(j)];
        solved[i - s][index(j)] = sum;
      }
    Matrix6Lanes result;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j <= i; ++j) {
        Lanes sum(0.0);
        for (std::size_t k = s + static_cast<std::size_t>(i); k < n; ++k)
          sum -= solved[k - s][i] * solved[k - s][j] * at(k, k);
        result(i, j) = result(j, i) = sum;
      }
    return result;
  }
  /// [m]x / 2 of the state that was factorised, as it lowers that stiffness in rows and columns 3
  /// to 5 for moments that are constant in base axes.
  Matrix3Lanes half_moment() const {
    Matrix3Lanes m;
    const Lanes zero(0.0);
    const Lanes a = moment_[0] * 0.5, b = moment_[1] * 0.5, c = moment_[2] * 0.5;
    const Lanes entries[9] = {zero, c, -b, -c, zero, a, b, -a, zero};  // column by column
    for (int k = 0; k < 9; ++k) m.data()[k] = entries[k];
    return m;
  }

  /// Changes of the coordinates that move and of the wrench, for what is unbalanced at the state
  /// evaluated last and for what the end is short of, by the matrix factorised last.
  void solve(const Vector6Lanes& short_of, std::vector<Lanes>& change, Vector6Lanes& force) const {
    const std::size_t n = size(), s = static_cast<std::size_t>(springs_);
    std::vector<Lanes> z(n);
    for (std::size_t k = 0; k < order_.size(); ++k) z[row_at(k)] = unbalanced_[k];
    for (std::size_t i = 0; i < 6; ++i) z[s + i] = -short_of[index(i)];
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t i = k + 1; i < n; ++i) z[i] -= at(i, k) * z[k];
    for (std::size_t k = n; k-- > 0;) {
      Lanes sum = z[k] * at(k, k);
      for (std::size_t i = k + 1; i < n; ++i) sum -= at(i, k) * z[i];
      z[k] = sum;
    }
    change.resize(order_.size());
    for (std::size_t k = 0; k < order_.size(); ++k) change[k] = z[row_at(k)];
    const Matrix3Lanes half = half_moment();
    for (int i = 0; i < 3; ++i) {
      force[i] = z[s + static_cast<std::size_t>(i)];
      force[3 + i] = z[s + 3 + static_cast<std::size_t>(i)];
      for (int k = 0; k < 3; ++k) force[3 + i] -= half(i, k) * short_of[3 + k];
    }
  }

 private:
  // Of the pivot of a block before the others of the block are eliminated.
  static constexpr double clear = 1e-8;

  static Eigen::Index index(std::size_t i) { return static_cast<Eigen::Index>(i); }
  std::size_t size() const { return order_.size() + 6; }
  std::size_t row_at(std::size_t k) const {
    return k < static_cast<std::size_t>(springs_) ? k : k + 6;
  }
  Lanes& at(std::size_t i, std::size_t j) { return matrix_[j * size() + i]; }
  const Lanes& at(std::size_t i, std::size_t j) const { return matrix_[j * size() + i]; }

  void go_on(const spatial::Pose& pose) {
    const Matrix3Lanes rotation = rotation_;
    const Vector3Lanes position = position_;
    lead(rotation, position, pose.rotation(), pose.position(), rotation_, position_);
  }

  // Origins and axes of the joints, the loaded nodes, and the end.
  void find_joints() {
    for (int k = 0; k < 9; ++k) rotation_.data()[k] = k % 4 == 0 ? 1.0 : 0.0;
    for (int i = 0; i < 3; ++i) position_[i] = 0.0;
    const auto place_nodes = [&](std::size_t joints) {
      for (const std::size_t node : loaded_) {
        const Node& there = chain_->nodes()[node];
        if (there.joints != index(joints)) continue;
        for (int i = 0; i < 3; ++i)
          points_[node][i] = position_[i] + rotation_(i, 0) * there.position[0] +
                             rotation_(i, 1) * there.position[1] +
                             rotation_(i, 2) * there.position[2];
      }
    };
    for (std::size_t j = 0; j < twists_.size(); ++j) {
      place_nodes(j);
      const Joint& joint = chain_->joints()[j];
      if (!joint.before_is_identity) go_on(joint.before);
      const int axis = axis_index(joint.motion);
      const Lanes value = x[static_cast<std::size_t>(joint.coordinate)] * joint.factor;
      twists_[j].v = position_;
      for (int i = 0; i < 3; ++i) twists_[j].w[i] = rotation_(i, axis);
      if (is_rotation(joint.motion))
        turn(axis, value, rotation_);
      else
        for (int i = 0; i < 3; ++i) position_[i] += value * rotation_(i, axis);
    }
    place_nodes(twists_.size());
    go_on(chain_->tail());
  }

  // From origins and axes: the twists at the end, joint by joint and coordinate by coordinate.
  void find_twists() {
    for (Twist& column : jacobian_)
      for (int i = 0; i < 3; ++i) column.v[i] = column.w[i] = 0.0;
    Lanes reach(0.0);
    for (std::size_t j = 0; j < twists_.size(); ++j) {
      const Joint& joint = chain_->joints()[j];
      Vector3Lanes arm, direction;
      for (int i = 0; i < 3; ++i) {
        arm[i] = position_[i] - twists_[j].v[i];
        direction[i] = twists_[j].w[i] * joint.factor;
      }
      reach = max(reach, dot(arm, arm));
      const bool turns = is_rotation(joint.motion);
      twists_[j].v = turns ? cross(direction, arm) : direction;
      Twist& column = jacobian_[static_cast<std::size_t>(joint.coordinate)];
      for (int i = 0; i < 3; ++i) {
        twists_[j].w[i] = turns ? direction[i] : Lanes(0.0);
        column.v[i] += twists_[j].v[i];
        column.w[i] += twists_[j].w[i];
      }
    }
    reach_ = sqrt(reach);
  }

  void find_balance() {
    std::vector<Lanes> force = applied;
    for (std::size_t k = 0; k < force.size(); ++k)
      for (int i = 0; i < 3; ++i)
        force[k] += jacobian_[k].v[i] * wrench[i] + jacobian_[k].w[i] * wrench[3 + i];
    for (const Spring& spring : chain_->springs())
      for (Eigen::Index l = 0; l < spring.stiffness.cols(); ++l) {
        const auto column = static_cast<std::size_t>(spring.first + l);
        const Lanes deflection = x[column] - rest[column];
        for (Eigen::Index k = 0; k < spring.stiffness.rows(); ++k)
          force[static_cast<std::size_t>(spring.first + k)] -= deflection * spring.stiffness(k, l);
      }
    for (const std::size_t node : loaded_) {
      const Vector3Lanes from_end = from_end_to(node);
      for (Eigen::Index j = 0; j < chain_->nodes()[node].joints; ++j) {
        const auto joint = static_cast<std::size_t>(j);
        const Vector3Lanes turned = cross(twists_[joint].w, from_end);
        Lanes& sum = force[static_cast<std::size_t>(chain_->joints()[joint].coordinate)];
        for (int i = 0; i < 3; ++i)
          sum += node_forces_[node][i] * (twists_[joint].v[i] + turned[i]);
      }
    }
    unbalanced_.resize(order_.size());
    for (std::size_t k = 0; k < order_.size(); ++k)
      unbalanced_[k] = force[static_cast<std::size_t>(order_[k])];
  }

  Vector3Lanes from_end_to(std::size_t node) const {
    Vector3Lanes arm;
    for (int i = 0; i < 3; ++i) arm[i] = points_[node][i] - position_[i];
    return arm;
  }

  void fill_matrix() {
    for (Lanes& entry : matrix_) entry = 0.0;
    const std::size_t s = static_cast<std::size_t>(springs_);
    for (const Spring& spring : chain_->springs())
      for (Eigen::Index l = 0; l < spring.stiffness.cols(); ++l)
        for (Eigen::Index k = l; k < spring.stiffness.rows(); ++k) {
          const Eigen::Index i = row_[static_cast<std::size_t>(spring.first + k)];
          const Eigen::Index j = row_[static_cast<std::size_t>(spring.first + l)];
          if (i < 0 || j < 0) continue;
          at(static_cast<std::size_t>(std::max(i, j)), static_cast<std::size_t>(std::min(i, j))) +=
              spring.stiffness(k, l);
        }
    for (std::size_t k = 0; k < order_.size(); ++k) {
      const Twist& twist = jacobian_[static_cast<std::size_t>(order_[k])];
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t row = row_at(k);
        (row < s ? at(s + i, row) : at(row, s + i)) = -twist.v[index(i)];
        (row < s ? at(s + 3 + i, row) : at(row, s + 3 + i)) = -twist.w[index(i)];
      }
    }
    subtract_wrench_hessian();
  }

  // As add_wrench_hessian() has it, its symmetric part.
  void subtract_wrench_hessian() {
    Vector3Lanes force, moment;
    Matrix3Lanes turning;  // sum of r f' - r.f I
    for (int k = 0; k < 9; ++k) turning.data()[k] = 0.0;
    for (int i = 0; i < 3; ++i) {
      force[i] = wrench[i];
      moment[i] = wrench[3 + i];
    }
    for (std::size_t j = twists_.size(); j-- > 0;) {
      for (const std::size_t node : loaded_) {
        if (chain_->nodes()[node].joints != index(j) + 1) continue;
        const Vector3Lanes r = from_end_to(node);
        const Lanes work = dot(r, node_forces_[node]);
        for (int i = 0; i < 3; ++i) {
          force[i] += node_forces_[node][i];
          turning(i, i) -= work;
          for (int k = 0; k < 3; ++k) turning(i, k) += r[i] * node_forces_[node][k];
        }
      }
      const Eigen::Index row = row_[coordinate_of(j)];
      if (row < 0) continue;
      const Vector3Lanes by_force = cross(twists_[j].v, force);
      const Vector3Lanes by_moment = cross(twists_[j].w, moment);
      Vector3Lanes on_itself, on_others;
      for (int i = 0; i < 3; ++i) {
        on_itself[i] = by_force[i] + turning(i, 0) * twists_[j].w[0] +
                       turning(i, 1) * twists_[j].w[1] + turning(i, 2) * twists_[j].w[2];
        on_others[i] = on_itself[i] + by_moment[i] * 0.5;
      }
      at(static_cast<std::size_t>(row), static_cast<std::size_t>(row)) -=
          dot(twists_[j].w, on_itself);
      for (std::size_t i = 0; i < j; ++i) {
        const Eigen::Index other = row_[coordinate_of(i)];
        if (other < 0) continue;
        const Lanes both = dot(twists_[i].w, on_others);
        at(static_cast<std::size_t>(std::max(row, other)),
           static_cast<std::size_t>(std::min(row, other))) -= row == other ? both * 2.0 : both;
      }
    }
  }
  std::size_t coordinate_of(std::size_t joint) const {
    return static_cast<std::size_t>(chain_->joints()[joint].coordinate);
  }

  struct Twist {
    Vector3Lanes v, w;
  };

  const Chain* chain_;
  std::vector<Eigen::Index> order_;  // coordinates that move, those with springs first
  std::ptrdiff_t springs_ = 0;
  std::vector<Eigen::Index> row_;    // of each coordinate in the matrix; -1: it stays
  std::vector<std::size_t> loaded_;  // nodes
  Matrix3Lanes rotation_;            // of the end
  Vector3Lanes position_;
  Lanes reach_;
  Vector3Lanes moment_;  // at the end, of the state that was factorised
  std::vector<Twist> twists_, jacobian_;
  std::vector<Vector3Lanes> node_forces_;
  std::vector<Vector3Lanes> points_;      // of the loaded nodes
  std::vector<Lanes> unbalanced_;         // in the order of solutions
  std::vector<Lanes> diagonal_, matrix_;  // by columns, below the diagonal L, on it 1 / D
};

}  // namespace kinetostat::vjm

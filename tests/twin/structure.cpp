#include "structure.h"

#include <algorithm>
#include <cmath>

namespace twin {
namespace {

using Matrix12 = Eigen::Matrix<double, 12, 12>;
using Vector12 = Eigen::Matrix<double, 12, 1>;
using Triplets = std::vector<Eigen::Triplet<double>>;

void add_block(Triplets& triplets, int row_body, int column_body, const Matrix6& block) {
  if (row_body == ground || column_body == ground) return;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      if (block(i, j) != 0)
        triplets.emplace_back(6 * row_body + i, 6 * column_body + j, block(i, j));
}

}  // namespace

// One coupling where it stands. Motions are ordered [u_a, w_a, u_b, w_b].
struct Structure::Local {
  Vector3 arm_a, arm_b, r;  // from bodies to points, and from point to point; base axes
  Eigen::Matrix<double, 6, 12> B;
  Vector6 force;  // dE/de
  Matrix6 slope;
  Vector3 F, M;  // force and moment on b, base axes
  double energy = 0;

  // Change of the gradient as B turns with the bodies: exact where the ends are parallel.
  Matrix12 turning() const {
    Matrix12 result;
    for (int k = 0; k < 12; ++k) {
      Vector3 ua = Vector3::Zero(), wa = ua, ub = ua, wb = ua;
      (k < 3 ? ua : k < 6 ? wa : k < 9 ? ub : wb)[k % 3] = 1;
      const Vector3 w = 0.5 * (wa + wb), dF = w.cross(F);
      const Vector3 d_arm_a = wa.cross(arm_a), d_arm_b = wb.cross(arm_b);
      const Vector3 dr = ub + d_arm_b - ua - d_arm_a;
      const Vector3 d_moment = dr.cross(F) + r.cross(dF);
      const Vector3 dM = w.cross(M + 0.5 * r.cross(F)) - 0.5 * d_moment;
      result.col(k) << -dF, -dM - d_moment - d_arm_a.cross(F) - arm_a.cross(dF), dF,
          dM + d_arm_b.cross(F) + arm_b.cross(dF);
    }
    return result;
  }
};

int Structure::add_body(const Pose& pose, double mass) {
  poses_.push_back(pose);
  mass_.push_back(mass);
  return bodies() - 1;
}

int Structure::add(Coupling coupling) {
  couplings_.push_back(std::move(coupling));
  return static_cast<int>(couplings_.size()) - 1;
}

Mark Structure::mark(int body, const Pose& pose) const {
  if (body == ground) return {ground, pose};
  return {body, poses_[static_cast<std::size_t>(body)].inverse() * pose};
}

Pose Structure::pose_of(const Mark& mark) const {
  return mark.body == ground ? mark.at : poses_[static_cast<std::size_t>(mark.body)] * mark.at;
}

Structure::Local Structure::local(const Coupling& c) const {
  const Pose a = pose_of(c.a), b = pose_of(c.b);
  Local result;
  const auto arm = [this](const Mark& m) {
    return m.body == ground ? Vector3(Vector3::Zero())
                            : Vector3(poses_[static_cast<std::size_t>(m.body)].R * m.at.x);
  };
  result.arm_a = arm(c.a);
  result.arm_b = arm(c.b);
  result.r = b.x - a.x;
  const Vector3 theta = vector_of(a.R.transpose() * b.R);
  const Matrix3 E = a.R * rotation_of(theta / 2), inverse = left_jacobian_inverse(theta);
  const Matrix3 turn = inverse * a.R.transpose();                 // of w_b - w_a into d theta
  const Matrix3 A = 0.5 * a.R * left_jacobian(theta / 2) * turn;  // into the spin of E beyond w_a
  const Matrix3 X = cross_matrix(result.r), Et = E.transpose();
  result.B.setZero();
  result.B.topRows<3>() << -Et, Et * (cross_matrix(result.arm_a) + X * (Matrix3::Identity() - A)),
      Et, Et * (X * A - cross_matrix(result.arm_b));
  result.B.bottomRows<3>() << Matrix3::Zero(), -turn, Matrix3::Zero(), turn;

  Vector6 e;
  e << Et * result.r, theta;
  e -= c.rest;
  result.force = c.stiffness * e;
  result.slope = c.stiffness;
  if (c.law) {
    const Reaction reaction = c.law->at(e[c.axis]);
    result.force[c.axis] += reaction.force;
    result.slope(c.axis, c.axis) += reaction.tangent;
  }
  result.energy = 0.5 * e.dot(c.stiffness * e);
  result.F = E * result.force.head<3>();
  result.M = turn.transpose() * result.force.tail<3>() - A.transpose() * result.r.cross(result.F);
  return result;
}

std::vector<DeadLoad> Structure::with_weights(const std::vector<DeadLoad>& loads) const {
  std::vector<DeadLoad> all = loads;
  for (int i = 0; i < bodies(); ++i)
    if (const double mass = mass_[static_cast<std::size_t>(i)]; mass != 0)
      all.push_back({{i, {}}, mass * gravity_, Vector3::Zero()});
  return all;
}

double Structure::energy(const std::vector<DeadLoad>& loads) const {
  double sum = 0;
  for (const Coupling& c : couplings_) sum += local(c).energy;
  for (const Strut& s : struts_)
    sum += 0.5 * s.k * std::pow((pose_of(s.b).x - pose_of(s.a).x).norm() - s.free_length, 2);
  for (const DeadLoad& load : with_weights(loads)) sum -= load.force.dot(pose_of(load.at).x);
  return sum;
}

std::vector<Structure::Local> Structure::locals() const {
  std::vector<Local> all;
  all.reserve(couplings_.size());
  for (const Coupling& c : couplings_) all.push_back(local(c));
  return all;
}

Eigen::VectorXd Structure::gradient(const std::vector<DeadLoad>& loads) const {
  return gradient(loads, locals());
}

Eigen::VectorXd Structure::gradient(const std::vector<DeadLoad>& loads,
                                    const std::vector<Local>& couplings) const {
  Eigen::VectorXd g = Eigen::VectorXd::Zero(6 * bodies());
  const auto push = [&](const Mark& m, const Vector3& force, const Vector3& moment) {
    if (m.body == ground) return;
    g.segment<3>(6 * m.body) += force;
    g.segment<3>(6 * m.body + 3) +=
        moment + (poses_[static_cast<std::size_t>(m.body)].R * m.at.x).cross(force);
  };
  for (std::size_t i = 0; i < couplings_.size(); ++i) {
    const Coupling& c = couplings_[i];
    const Vector12 force = couplings[i].B.transpose() * couplings[i].force;
    if (c.a.body != ground) g.segment<6>(6 * c.a.body) += force.head<6>();
    if (c.b.body != ground) g.segment<6>(6 * c.b.body) += force.tail<6>();
  }
  for (const Strut& s : struts_) {
    const Vector3 line = pose_of(s.b).x - pose_of(s.a).x;
    const Vector3 pull = s.k * (1 - s.free_length / line.norm()) * line;
    push(s.a, -pull, Vector3::Zero());
    push(s.b, pull, Vector3::Zero());
  }
  for (const DeadLoad& load : with_weights(loads)) push(load.at, -load.force, -load.moment);
  return g;
}

Structure::Tangent Structure::tangent(const std::vector<DeadLoad>& loads,
                                      const std::vector<Local>& couplings) const {
  Triplets triplets;
  const auto add_pair = [&](int a, int b, const Matrix12& k) {
    add_block(triplets, a, a, k.topLeftCorner<6, 6>());
    add_block(triplets, a, b, k.topRightCorner<6, 6>());
    add_block(triplets, b, a, k.bottomLeftCorner<6, 6>());
    add_block(triplets, b, b, k.bottomRightCorner<6, 6>());
  };
  for (std::size_t i = 0; i < couplings_.size(); ++i) {
    const Coupling& c = couplings_[i];
    const Local& l = couplings[i];
    const Matrix12 k = l.B.transpose() * l.slope * l.B + l.turning();
    add_pair(c.a.body, c.b.body, 0.5 * (k + k.transpose()));
  }
  for (const Strut& s : struts_) {
    const Vector3 line = pose_of(s.b).x - pose_of(s.a).x, n = line.normalized();
    const Matrix3 k = s.k * n * n.transpose() + s.k * (1 - s.free_length / line.norm()) *
                                                    (Matrix3::Identity() - n * n.transpose());
    Eigen::Matrix<double, 3, 12> B = Eigen::Matrix<double, 3, 12>::Zero();
    const auto fill = [&](const Mark& m, int column, double sign) {
      if (m.body == ground) return;
      B.middleCols<3>(column) = sign * Matrix3::Identity();
      B.middleCols<3>(column + 3) =
          -sign * cross_matrix(poses_[static_cast<std::size_t>(m.body)].R * m.at.x);
    };
    fill(s.a, 0, -1);
    fill(s.b, 6, 1);
    add_pair(s.a.body, s.b.body, B.transpose() * k * B);
  }
  for (const DeadLoad& load : with_weights(loads)) {
    if (load.at.body == ground) continue;
    const Vector3 arm = poses_[static_cast<std::size_t>(load.at.body)].R * load.at.at.x;
    const Matrix3 k = cross_matrix(load.force) * cross_matrix(arm);
    Matrix6 block = Matrix6::Zero();
    block.bottomRightCorner<3, 3>() = -0.5 * (k + k.transpose());
    add_block(triplets, load.at.body, load.at.body, block);
  }
  Tangent result(6 * bodies(), 6 * bodies());
  result.setFromTriplets(triplets.begin(), triplets.end());
  return result;
}

void Structure::move(const Eigen::VectorXd& step) {
  for (int i = 0; i < bodies(); ++i) {
    Pose& pose = poses_[static_cast<std::size_t>(i)];
    pose.x += step.segment<3>(6 * i);
    pose.R = rotation_of(step.segment<3>(6 * i + 3)) * pose.R;
  }
}

namespace {

bool same_pattern(const Eigen::SparseMatrix<double>& a, const Eigen::SparseMatrix<double>& b) {
  return a.cols() == b.cols() && a.nonZeros() == b.nonZeros() &&
         std::equal(a.outerIndexPtr(), a.outerIndexPtr() + a.outerSize(), b.outerIndexPtr()) &&
         std::equal(a.innerIndexPtr(), a.innerIndexPtr() + a.nonZeros(), b.innerIndexPtr());
}

}  // namespace

bool Structure::settle(const std::vector<DeadLoad>& loads, int more) {
  if (!search(loads)) return false;
  for (int i = 0; i < more; ++i) {
    const std::vector<Local> couplings = locals();
    const auto factor = std::make_shared<Factor>(tangent(loads, couplings));
    if (factor->info() != Eigen::Success) return false;
    move(-factor->solve(gradient(loads, couplings)));
    factor_ = factor;
  }
  return true;
}

bool Structure::search(const std::vector<DeadLoad>& loads) {
  constexpr int most = 120;
  constexpr double largest = 0.02, small = 1e-12, rounding = 1e-8;  // of a step [m or rad]
  double before = 0;
  const auto factor = std::make_shared<Factor>();
  factor_ = factor;
  Tangent matrix;
  for (int i = 0; i < most; ++i) {
    const std::vector<Local> couplings = locals();
    Tangent next = tangent(loads, couplings);
    if (!same_pattern(next, matrix)) factor->analyzePattern(next);
    matrix.swap(next);
    factor->factorize(matrix);
    if (factor->info() != Eigen::Success) return false;
    Eigen::VectorXd step = -factor->solve(gradient(loads, couplings));
    const double size = step.cwiseAbs().maxCoeff();
    if (!std::isfinite(size)) return false;
    if (size > largest) step *= largest / size;
    // A Newton step that overshoots a corner of a joint law comes back the same way: halve it then.
    if (i > 12) step *= i > 40 ? 0.25 : 0.5;
    move(step);
    if (size < small) return true;
    // Steps that no longer shrink are rounding of the stiff directions.
    if (i > 2 && size < rounding && size > 0.5 * before) return true;
    before = size;
  }
  return false;
}

void Structure::accept(double seconds) {
  for (Coupling& c : couplings_) {
    if (!c.law) continue;
    const Pose a = pose_of(c.a), b = pose_of(c.b);
    const Vector3 theta = vector_of(a.R.transpose() * b.R);
    const double e = c.axis < 3 ? (rotation_of(-theta / 2) * a.R.transpose() * (b.x - a.x))[c.axis]
                                : theta[c.axis - 3];
    c.law->accept(e - c.rest[c.axis], seconds);
  }
}

Eigen::VectorXd Structure::group_force(int group) const {
  Eigen::VectorXd g = Eigen::VectorXd::Zero(6 * bodies());
  for (const Coupling& c : couplings_) {
    if (c.group != group) continue;
    Coupling own = c;
    // A joint's stiff directions do not scatter: only the axis of its law belongs to the group.
    if (c.law) own.stiffness.setZero();
    const Local l = local(own);
    const Vector12 force = l.B.transpose() * l.force;
    if (c.a.body != ground) g.segment<6>(6 * c.a.body) += force.head<6>();
    if (c.b.body != ground) g.segment<6>(6 * c.b.body) += force.tail<6>();
  }
  return g;
}

Vector6 Structure::motion_of(const Mark& mark, const Eigen::VectorXd& change) const {
  const Vector3 u = change.segment<3>(6 * mark.body), w = change.segment<3>(6 * mark.body + 3);
  Vector6 motion;
  motion << u + w.cross(poses_[static_cast<std::size_t>(mark.body)].R * mark.at.x), w;
  return motion;
}

Eigen::MatrixXd Structure::sensitivity(const Mark& mark, int groups) const {
  Eigen::MatrixXd result(6, groups);
  for (int group = 0; group < groups; ++group)
    result.col(group) = motion_of(mark, -factor_->solve(group_force(group)));
  return result;
}

Eigen::Matrix<double, 6, 3> Structure::compliance(const Mark& mark) const {
  Eigen::Matrix<double, 6, 3> result;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::VectorXd force = Eigen::VectorXd::Zero(6 * bodies());
    const Vector3 arm = poses_[static_cast<std::size_t>(mark.body)].R * mark.at.x;
    force.segment<3>(6 * mark.body) = Vector3::Unit(axis);
    force.segment<3>(6 * mark.body + 3) = arm.cross(Vector3::Unit(axis));
    result.col(axis) = motion_of(mark, factor_->solve(force));
  }
  return result;
}

}  // namespace twin

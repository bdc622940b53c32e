#include "vjm/statics/routes.h"

#include <cmath>
#include <stdexcept>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using spatial::Matrix6;
using spatial::Vector6;

// Pivots below this, relative to the largest of a matrix in comparable units, are rounding.
constexpr double rounding = 1e-11;

Vector6 twist_scale(double length) {
  Vector6 scale = Vector6::Ones();
  scale.tail<3>().setConstant(length);
  return scale;
}

// The same model with rotations times the length; stiffness matrices of it are scaled back by
// unscaled().
VirtualJointModel scaled(const VirtualJointModel& model) {
  VirtualJointModel result = model;
  const Vector6 scale = twist_scale(model.length);
  result.springs = scale.asDiagonal() * model.springs;
  result.passive = scale.asDiagonal() * model.passive;
  return result;
}

Matrix6 unscaled(const Matrix6& stiffness, double length) {
  const Vector6 scale = twist_scale(length);
  const Matrix6 matrix = scale.asDiagonal() * stiffness * scale.asDiagonal();
  return 0.5 * (matrix + matrix.transpose());
}

Matrix6 compliance_of(const VirtualJointModel& model) {
  return model.springs * model.stiffness.llt().solve(model.springs.transpose());
}

Matrix6 inverse_or_throw(const Matrix6& matrix, const char* message) {
  const Eigen::FullPivLU<Matrix6> lu(matrix);
  const auto pivots = lu.matrixLU().diagonal().cwiseAbs();
  if (!(pivots.minCoeff() > rounding * pivots.maxCoeff())) throw std::domain_error(message);
  return lu.inverse();
}

constexpr char few_springs[] =
    "the chain has fewer than six independent springs: with its passive joints locked it is rigid";

Matrix6 locked(const VirtualJointModel& scaled_model) {
  return inverse_or_throw(compliance_of(scaled_model), few_springs);
}

// Unit vector along a column; joints that move the end point far and little count alike.
Vector6 unit(const Vector6& column) {
  const double norm = column.norm();
  return norm > 0 ? Vector6(column / norm) : column;
}

// An orthonormal basis of the motions that the passive joints allow.
MatrixXd independent_columns(const Matrix6X& passive) {
  if (passive.cols() == 0) return passive;
  MatrixXd columns = passive;
  for (Index k = 0; k < columns.cols(); ++k) columns.col(k) = unit(columns.col(k));
  Eigen::ColPivHouseholderQR<MatrixXd> qr;
  qr.setThreshold(1e-10);
  qr.compute(columns);
  const MatrixXd q = qr.householderQ();
  return q.leftCols(qr.rank());
}

}  // namespace

VirtualJointModel virtual_joint_model(const Chain& chain, const ChainKinematics& kinematics) {
  VirtualJointModel model{.length = kinematics.reach > 0 ? kinematics.reach : 1.0};
  std::vector<Index> springs, passive;
  for (Index k = 0; k < chain.size(); ++k) {
    if (chain.stiffness()(k, k) != 0) {
      springs.push_back(k);
    } else if (chain.coordinates()[static_cast<std::size_t>(k)].role == Role::passive) {
      passive.push_back(k);
    }
  }
  model.springs = kinematics.jacobian(Eigen::all, springs);
  model.stiffness = chain.stiffness()(springs, springs);
  model.passive = kinematics.jacobian(Eigen::all, passive);
  return model;
}

Matrix6 salisbury_stiffness(const Matrix6& jacobian, const MatrixXd& stiffness) {
  const Matrix6 inverse = inverse_or_throw(jacobian, "the Jacobian is singular in this posture");
  return inverse.transpose() * stiffness * inverse;
}

Matrix6 gosselin_stiffness(const Eigen::Matrix<double, Eigen::Dynamic, 6>& inverse_jacobian,
                           const MatrixXd& stiffness) {
  return inverse_jacobian.transpose() * stiffness * inverse_jacobian;
}

Matrix6 locked_stiffness(const VirtualJointModel& model) {
  return unscaled(locked(scaled(model)), model.length);
}

Matrix6 block_inverse_stiffness(const VirtualJointModel& model) {
  const VirtualJointModel s = scaled(model);
  const MatrixXd passive = independent_columns(s.passive);
  const Matrix6 compliance = compliance_of(s);
  // Compliance and Jacobian made of one size, so that pivots can be compared.
  const double size = compliance.cwiseAbs().maxCoeff();
  if (!(size > 0) && passive.cols() < 6) throw std::domain_error("the chain has no spring");
  MatrixXd matrix = MatrixXd::Zero(6 + passive.cols(), 6 + passive.cols());
  if (size > 0) matrix.topLeftCorner<6, 6>() = compliance / size;
  matrix.topRightCorner(6, passive.cols()) = passive;
  matrix.bottomLeftCorner(passive.cols(), 6) = passive.transpose();
  const Eigen::FullPivLU<MatrixXd> lu(matrix);
  const auto pivots = lu.matrixLU().diagonal().cwiseAbs();
  if (!(pivots.minCoeff() > rounding * pivots.maxCoeff()))
    throw std::domain_error("a wrench that the passive joints transmit meets no spring");
  const Matrix6 upper = lu.inverse().topLeftCorner<6, 6>();
  return unscaled(upper / (size > 0 ? size : 1.0), model.length);
}

Matrix6 two_term_stiffness(const VirtualJointModel& model) {
  const VirtualJointModel s = scaled(model);
  const Matrix6 first = locked(s);
  const MatrixXd passive = independent_columns(s.passive);
  if (passive.cols() == 0) return unscaled(first, model.length);
  const MatrixXd image = first * passive;
  const Matrix6 second =
      image * (passive.transpose() * image).llt().solve(image.transpose().eval());
  return unscaled(first - second, model.length);
}

Matrix6 with_passive_joint(const Matrix6& stiffness, const Vector6& passive, double redundant) {
  const Vector6 u = stiffness * passive;
  const double mu = passive.dot(u);
  if (!(mu > redundant)) return stiffness;
  return stiffness - u * u.transpose() / mu;
}

Matrix6 recursive_stiffness(const VirtualJointModel& model) {
  const VirtualJointModel s = scaled(model);
  Matrix6 stiffness = locked(s);
  std::vector<Vector6> columns;
  std::vector<double> alone;  // what each joint would release if it were the only one
  for (Index k = 0; k < s.passive.cols(); ++k) {
    columns.push_back(unit(s.passive.col(k)));
    alone.push_back(columns.back().dot(stiffness * columns.back()));
  }
  // The order is free (IROS11, proposition). The joint that releases most comes next, so that
  // nearly redundant ones cost no accuracy; a redundant one releases rounding.
  std::vector<bool> done(columns.size(), false);
  for (std::size_t step = 0; step < columns.size(); ++step) {
    std::size_t next = 0;
    double most = -1;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const double share = columns[k].dot(stiffness * columns[k]) / alone[k];
      if (done[k] || !(share > most)) continue;
      most = share;
      next = k;
    }
    if (most < 1e-9) break;
    done[next] = true;
    stiffness = with_passive_joint(stiffness, columns[next], 0);
  }
  return unscaled(stiffness, model.length);
}

Matrix6 with_trivial_joint(const Matrix6& stiffness, int axis) {
  const double pivot = stiffness(axis, axis);
  if (pivot == 0) return stiffness;
  Matrix6 result = stiffness - stiffness.col(axis) * stiffness.row(axis) / pivot;
  result.row(axis).setZero();
  result.col(axis).setZero();
  return result;
}

Matrix6 loaded_serial_stiffness(const Matrix6& jacobian, const MatrixXd& stiffness,
                                const MatrixXd& stiffness_by_load) {
  return salisbury_stiffness(jacobian, stiffness - stiffness_by_load);
}

Matrix6 aggregated_stiffness(const std::vector<ChainAtPoint>& chains,
                             const spatial::Vector3& reference_point) {
  Matrix6 sum = Matrix6::Zero();
  for (const ChainAtPoint& chain : chains) {
    // Translation of the chain's end for a twist taken at the reference point: t + w x (end - ref).
    Matrix6 to_end = Matrix6::Identity();
    to_end.topRightCorner<3, 3>() = spatial::skew(reference_point - chain.end);
    sum += to_end.transpose() * chain.stiffness * to_end;
  }
  return sum;
}

}  // namespace kinetostat::vjm

#include "kinetostat/vjm/manipulator/free_motion.h"

#include <cmath>

#include <fmt/format.h>

#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::vjm {
namespace {

using spatial::Matrix3;
using spatial::Vector3;
using spatial::Vector6;
using Matrix3X = Eigen::Matrix<double, 3, Eigen::Dynamic>;
using Matrix6X = Eigen::Matrix<double, 6, Eigen::Dynamic>;

constexpr double small = 1e-6;

double clean(double value, double scale) { return std::abs(value) < small * scale ? 0.0 : value; }

// Axis directions have no sign: the first component that counts is made positive.
Vector3 canonical(Vector3 direction) {
  for (int i = 0; i < 3; ++i) direction[i] = clean(direction[i], 1);
  direction.normalize();
  for (int i = 0; i < 3; ++i) {
    if (direction[i] == 0) continue;
    return direction[i] < 0 ? Vector3(-direction) : direction;
  }
  return direction;
}

std::string direction_text(const Vector3& direction) {
  static const char* names[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i)
    if (std::abs(std::abs(direction[i]) - 1) < small) return names[i];
  return fmt::format("({:.4g}, {:.4g}, {:.4g})", direction.x(), direction.y(), direction.z());
}

std::string point_text(const Vector3& point, double length) {
  const auto mm = [&](double v) { return 1e3 * clean(v, length); };
  return fmt::format("({:.6g}, {:.6g}, {:.6g}) mm", mm(point.x()), mm(point.y()), mm(point.z()));
}

// A wrench is a screw like a twist: a force along an axis stands where a rotation about it does, a
// couple where a translation does.
enum class Kind { motion, wrench };

std::string screw_text(const ScrewMotion& screw, double length, Kind kind) {
  const bool motion = kind == Kind::motion;
  if (screw.is_translation)
    return (motion ? "free translation along " : "rigid against a couple about ") +
           direction_text(screw.direction);
  const std::string axis =
      fmt::format("the axis through {} along {}", point_text(screw.point, length),
                  direction_text(screw.direction));
  if (clean(screw.pitch, length) == 0)
    return (motion ? "free rotation about " : "rigid against a force along ") + axis;
  return fmt::format("{} {} with {:.4g} mm {}",
                     motion ? "free screw motion about" : "rigid against a wrench along", axis,
                     1e3 * screw.pitch, motion ? "of advance per radian" : "of couple per force");
}

// The null space split into pure translations and a rotating remainder v = map(w).
struct TwistSpace {
  Matrix3X translations;  // orthonormal
  Matrix3X rotations;     // orthonormal directions of rotation
  Matrix3X velocities;    // of the reference point, one per rotation, free of the translations
};

TwistSpace split(const Matrix6X& twists, double length) {
  const spatial::SingularValues svd =
      spatial::singular_value_decomposition(length * twists.bottomRows<3>());
  const Eigen::Index rotating = (svd.values.array() > small).count();
  const Matrix6X turned = twists * svd.v;
  TwistSpace space;
  const Matrix3X sliding = turned.topRightCorner(3, twists.cols() - rotating);
  if (sliding.cols() > 0) {
    space.translations = spatial::singular_value_decomposition(sliding).u.leftCols(
        std::min<Eigen::Index>(3, sliding.cols()));
  } else {
    space.translations.resize(3, 0);
  }
  space.rotations.resize(3, rotating);
  space.velocities.resize(3, rotating);
  for (Eigen::Index i = 0; i < rotating; ++i) {
    const double speed = turned.col(i).tail<3>().norm();
    space.rotations.col(i) = turned.col(i).tail<3>() / speed;
    const Vector3 v = turned.col(i).head<3>() / speed;
    space.velocities.col(i) = v - space.translations * (space.translations.transpose() * v);
  }
  return space;
}

// Is there one point about which all the rotations turn? v = c x w for every pair, up to the free
// translations.
bool common_point(const TwistSpace& space, double length, Vector3& point) {
  const Eigen::Index n = space.rotations.cols();
  Eigen::MatrixXd system(3 * n, 3);
  Eigen::VectorXd right(3 * n);
  const Matrix3 fixed = Matrix3::Identity() - space.translations * space.translations.transpose();
  for (Eigen::Index i = 0; i < n; ++i) {
    system.middleRows<3>(3 * i) = -fixed * spatial::skew(space.rotations.col(i));
    right.segment<3>(3 * i) = space.velocities.col(i);
  }
  point = spatial::shortest_least_squares_solution(system, right, small);
  return (system * point - right).norm() < small * length;
}

ScrewMotion screw_of(const Vector3& w, const Vector3& v) {
  return {.is_translation = false, .direction = w, .point = w.cross(v), .pitch = w.dot(v)};
}

// Principal screws: orthogonal axes on which the pitch is stationary.
std::vector<ScrewMotion> principal_screws(const TwistSpace& space) {
  const Eigen::MatrixXd map = space.rotations.transpose() * space.velocities;
  const Eigen::MatrixXd mixes = spatial::symmetric_eigen(0.5 * (map + map.transpose())).vectors;
  std::vector<ScrewMotion> screws;
  for (Eigen::Index i = 0; i < map.cols(); ++i) {
    const Eigen::VectorXd mix = mixes.col(i);
    screws.push_back(screw_of(space.rotations * mix, space.velocities * mix));
  }
  return screws;
}

std::string pencil_text(const TwistSpace& space, const Vector3& point, double length, Kind kind) {
  std::string text = (kind == Kind::motion ? "every rotation about the point "
                                           : "rigid against every force through the point ") +
                     point_text(point, length);
  if (space.rotations.cols() == 2) {
    const Vector3 normal = canonical(space.rotations.col(0).cross(space.rotations.col(1)));
    text += " normal to " + direction_text(normal);
  }
  return kind == Kind::motion ? text + " is free" : text;
}

FreeMotions describe(const Matrix6X& twists, const spatial::Frame& frame, double length,
                     Kind kind) {
  FreeMotions result;
  result.rank = 6 - static_cast<int>(twists.cols());
  if (twists.cols() == 0) return result;
  Matrix6X in_base(6, twists.cols());
  in_base.topRows<3>() = frame.axes * twists.topRows<3>();
  in_base.bottomRows<3>() = frame.axes * twists.bottomRows<3>();
  const TwistSpace space = split(in_base, length);

  for (Eigen::Index i = 0; i < space.translations.cols(); ++i)
    result.motions.push_back(
        {.is_translation = true, .direction = canonical(space.translations.col(i))});
  if (space.translations.cols() == 3) {
    result.sentences.push_back(kind == Kind::motion ? "every translation is free"
                                                    : "rigid against every couple");
  } else {
    for (const ScrewMotion& motion : result.motions)
      result.sentences.push_back(screw_text(motion, length, kind));
  }

  const Eigen::Index rotations = space.rotations.cols();
  if (rotations == 0) return result;
  Vector3 point = Vector3::Zero();
  if (rotations > 1 && common_point(space, length, point)) {
    for (Eigen::Index i = 0; i < rotations; ++i) {
      // For a full pencil any three axes will do: those of the base read best.
      const Vector3 axis =
          rotations == 3 ? Vector3(Vector3::Unit(i)) : canonical(space.rotations.col(i));
      result.motions.push_back({.direction = axis, .point = frame.point + point});
    }
    result.sentences.push_back(pencil_text(space, frame.point + point, length, kind));
    return result;
  }
  for (ScrewMotion screw : principal_screws(space)) {
    screw.direction = canonical(screw.direction);
    screw.point += frame.point;
    result.motions.push_back(screw);
    result.sentences.push_back(screw_text(screw, length, kind));
  }
  return result;
}

// Eigenvectors of a positive semi-definite matrix whose eigenvalues count as zero, scaled back.
Matrix6X null_vectors(const spatial::Matrix6& matrix, const Vector6& scale, double tolerance) {
  const spatial::Matrix6 scaled =
      scale.asDiagonal() * (0.5 * (matrix + matrix.transpose())) * scale.asDiagonal();
  const spatial::SymmetricEigen eigen = spatial::symmetric_eigen(scaled);
  const double limit = tolerance * eigen.values.cwiseAbs().maxCoeff();
  Eigen::Index zero = 0;
  while (zero < 6 && eigen.values[zero] <= limit) ++zero;
  return scale.asDiagonal() * eigen.vectors.leftCols(zero);
}

Vector6 rotation_scale(double factor) {
  Vector6 scale = Vector6::Ones();
  scale.tail<3>().setConstant(factor);
  return scale;
}

}  // namespace

FreeMotions describe_twists(const Matrix6X& twists, const spatial::Frame& frame, double length) {
  return describe(twists, frame, length, Kind::motion);
}

FreeMotions free_motions(const spatial::Stiffness6& stiffness, double length, double tolerance) {
  return describe(null_vectors(stiffness.matrix(), rotation_scale(1 / length), tolerance),
                  stiffness.frame(), length, Kind::motion);
}

FreeMotions rigid_wrenches(const spatial::Compliance6& compliance, double length,
                           double tolerance) {
  const Matrix6X wrenches = null_vectors(compliance.matrix(), rotation_scale(length), tolerance);
  Matrix6X screws(6, wrenches.cols());
  screws << wrenches.bottomRows<3>(), wrenches.topRows<3>();
  return describe(screws, compliance.frame(), length, Kind::wrench);
}

}  // namespace kinetostat::vjm

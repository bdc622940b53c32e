#include "kinetostat/vjm/posture.h"

#include <cmath>
#include <stdexcept>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "kinetostat/spatial/spelling.h"
#include "kinetostat/vjm/kinematics.h"

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Pose;
using spatial::Vector6;

// A system of equations error(z) = 0 with its Jacobian, z in comparable units.
struct Residual {
  VectorXd error;
  MatrixXd jacobian;
};

// Levenberg-Marquardt; evaluate(z, residual) fills both members. Returns the last accepted z.
template <class Evaluate>
VectorXd solve_least_squares(VectorXd z, const Evaluate& evaluate, double tolerance,
                             int max_iterations) {
  Residual now, next;
  evaluate(z, now);
  double damping = 1e-6;
  for (int i = 0; i < max_iterations && now.error.lpNorm<Eigen::Infinity>() > tolerance; ++i) {
    const VectorXd gradient = now.jacobian.transpose() * now.error;
    MatrixXd normal = now.jacobian.transpose() * now.jacobian;
    normal.diagonal().array() += damping * std::max(1e-12, normal.diagonal().maxCoeff());
    const VectorXd step = -normal.ldlt().solve(gradient);
    const VectorXd candidate = z + step;
    evaluate(candidate, next);
    if (next.error.squaredNorm() < now.error.squaredNorm()) {
      z = candidate;
      std::swap(now, next);
      damping = std::max(damping * 0.1, 1e-15);
    } else {
      damping = std::max(damping * 10, 1e-12);
      if (damping > 1e8) break;
    }
  }
  return z;
}

double chain_scale(const Chain& chain, ChainKinematics& kinematics, const VectorXd& x) {
  evaluate(chain, x, kinematics);
  return kinematics.reach > 0 ? kinematics.reach : 1.0;
}

// Error of a pose with rotation turned into a length.
Vector6 scaled_difference(const Pose& from, const Pose& to, double length) {
  Vector6 e = spatial::pose_difference(from, to);
  e.tail<3>() *= length;
  return e;
}

// A point of the van der Corput sequence: a deterministic scatter over (-1, 1).
double scatter(int index, int dimension) {
  static constexpr int primes[] = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37};
  const int base = primes[dimension % 12];
  double value = 0, digit = 1.0 / base;
  for (int i = index + dimension / 12; i > 0; i /= base, digit /= base) value += digit * (i % base);
  return 2 * value - 1;
}

VectorXd starting_point(const Chain& chain, int start, double length) {
  VectorXd x = chain.home();
  if (start == 0) return x;
  int dimension = 0;
  for (const Index k : chain.posture_coordinates()) {
    const bool turns = is_rotation(chain.coordinates()[static_cast<std::size_t>(k)].motion);
    x[k] += (turns ? 3.0 : length) * scatter(start, dimension++);
  }
  return x;
}

// Inverse kinematics of one chain.
class ChainPostureSolver {
 public:
  ChainPostureSolver(const Chain& chain, const Pose& target, const PostureOptions& options)
      : chain_(chain), target_(target), options_(options) {
    length_ = chain_scale(chain, kinematics_, chain.home());
  }

  // The first start that reaches the target, else the one that comes nearest.
  VectorXd solve() {
    VectorXd best = chain_.home();
    double best_error = std::numeric_limits<double>::infinity();
    for (int start = 0; start <= options_.restarts; ++start) {
      const VectorXd x = solve_from(starting_point(chain_, start, length_));
      const double e = error(x).lpNorm<Eigen::Infinity>();
      if (e < best_error) {
        best = x;
        best_error = e;
      }
      if (best_error <= accepted()) break;
    }
    return best;
  }

  Vector6 error(const VectorXd& x) {
    evaluate(chain_, x, kinematics_);
    return scaled_difference(kinematics_.end, target_, length_);
  }
  // Rounding of the pose itself bounds what can be reached.
  double accepted() const {
    return std::max(options_.tolerance, 1e-13 * (length_ + target_.position().norm()));
  }
  double length() const { return length_; }

 private:
  VectorXd solve_from(const VectorXd& start) {
    const auto& free = chain_.posture_coordinates();
    const auto n = static_cast<Index>(free.size());
    VectorXd x = start, unit = VectorXd::Ones(n), z(n);
    for (Index k = 0; k < n; ++k) {
      const Index c = free[static_cast<std::size_t>(k)];
      if (is_rotation(chain_.coordinates()[static_cast<std::size_t>(c)].motion)) unit[k] = length_;
      z[k] = x[c] * unit[k];
    }
    const auto set = [&](const VectorXd& values) {
      for (Index k = 0; k < n; ++k) x[free[static_cast<std::size_t>(k)]] = values[k] / unit[k];
    };
    z = solve_least_squares(
        z,
        [&](const VectorXd& values, Residual& residual) {
          set(values);
          residual.error = error(x);
          residual.jacobian.resize(6, n);
          for (Index k = 0; k < n; ++k)
            residual.jacobian.col(k) =
                -kinematics_.jacobian.col(free[static_cast<std::size_t>(k)]) / unit[k];
          residual.jacobian.bottomRows<3>() *= length_;
        },
        0.1 * accepted(), options_.max_iterations);
    set(z);
    return x;
  }

  const Chain& chain_;
  Pose target_;
  PostureOptions options_;
  ChainKinematics kinematics_;
  double length_ = 1;
};

std::string miss_text(const std::string& chain, const Vector6& error) {
  return fmt::format(
      "chain '{}' cannot reach the pose: the nearest it comes is {:.4g} mm and {:.4g} deg away",
      chain, 1e3 * error.head<3>().norm(), error.tail<3>().norm() * 180 / M_PI);
}

struct JointName {
  std::size_t chain;
  Index coordinate;
};

JointName find_joint(const Manipulator& manipulator, const std::string& name) {
  std::vector<JointName> found;
  std::vector<std::string> known;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const Chain& chain = manipulator.chains()[c];
    for (const Index k : chain.posture_coordinates()) {
      const std::string& joint = chain.coordinates()[static_cast<std::size_t>(k)].name;
      known.push_back(chain.name() + "." + joint);
      if (manipulator.size() == 1) known.push_back(joint);
      if (name == joint || name == chain.name() + "." + joint) found.push_back({c, k});
    }
  }
  if (found.size() == 1) return found[0];
  if (found.size() > 1)
    throw std::invalid_argument(
        fmt::format("the joint '{}' is in several chains: write <chain>.{}", name, name));
  const std::string near = spatial::nearest_spelling(name, known);
  throw std::invalid_argument(fmt::format("there is no joint '{}'{}", name,
                                          near.empty() ? "" : " (did you mean '" + near + "'?)"));
}

// Passive joints of all chains and the platform pose, solved together.
PostureResult close_loops(const Manipulator& manipulator, Posture posture,
                          const PostureOptions& options) {
  struct Unknown {
    std::size_t chain;
    Index coordinate;
    double unit;
  };
  std::vector<ChainKinematics> kinematics(manipulator.size());
  double length = 0;
  for (std::size_t c = 0; c < manipulator.size(); ++c)
    length = std::max(length,
                      chain_scale(manipulator.chains()[c], kinematics[c], posture.coordinates[c]));
  posture.platform = kinematics[0].end;
  std::vector<Unknown> unknowns;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const Chain& chain = manipulator.chains()[c];
    for (const Index k : chain.posture_coordinates()) {
      const Coordinate& coordinate = chain.coordinates()[static_cast<std::size_t>(k)];
      if (coordinate.role == Role::passive)
        unknowns.push_back({c, k, is_rotation(coordinate.motion) ? length : 1.0});
    }
  }
  const auto n = static_cast<Index>(unknowns.size());
  const auto m = static_cast<Index>(6 * manipulator.size());
  const Pose origin = posture.platform;
  const auto set = [&](const VectorXd& z) {
    for (Index k = 0; k < n; ++k) {
      const Unknown& u = unknowns[static_cast<std::size_t>(k)];
      posture.coordinates[u.chain][u.coordinate] = z[6 + k] / u.unit;
    }
    Vector6 displacement = z.head<6>();
    displacement.tail<3>() /= length;
    posture.platform = spatial::displaced(origin, displacement);
  };
  VectorXd z = VectorXd::Zero(6 + n);
  for (Index k = 0; k < n; ++k) {
    const Unknown& u = unknowns[static_cast<std::size_t>(k)];
    z[6 + k] = posture.coordinates[u.chain][u.coordinate] * u.unit;
  }
  const auto evaluate_loops = [&](const VectorXd& values, Residual& residual) {
    set(values);
    residual.error.resize(m);
    residual.jacobian.setZero(m, 6 + n);
    for (std::size_t c = 0; c < manipulator.size(); ++c) {
      evaluate(manipulator.chains()[c], posture.coordinates[c], kinematics[c]);
      const auto row = static_cast<Index>(6 * c);
      residual.error.segment<6>(row) =
          scaled_difference(kinematics[c].end, posture.platform, length);
      residual.jacobian.block<6, 6>(row, 0).setIdentity();
    }
    for (Index k = 0; k < n; ++k) {
      const Unknown& u = unknowns[static_cast<std::size_t>(k)];
      const auto row = static_cast<Index>(6 * u.chain);
      residual.jacobian.block<6, 1>(row, 6 + k) =
          -kinematics[u.chain].jacobian.col(u.coordinate) / u.unit;
      residual.jacobian.block<3, 1>(row + 3, 6 + k) *= length;
    }
  };
  const double accepted = std::max(options.tolerance, 1e-12 * length);
  z = solve_least_squares(z, evaluate_loops, 0.1 * accepted, options.max_iterations);

  Residual residual;
  evaluate_loops(z, residual);
  PostureResult result;
  result.posture = posture;
  result.reached = residual.error.lpNorm<Eigen::Infinity>() <= accepted;
  Index worst = 0;
  residual.error.cwiseAbs().maxCoeff(&worst);
  result.error = residual.error.segment<6>(worst - worst % 6);
  result.error.tail<3>() /= length;
  if (!result.reached)
    result.reason =
        "the loops cannot be closed with these joint values: " +
        miss_text(manipulator.chains()[static_cast<std::size_t>(worst / 6)].name(), result.error);
  return result;
}

}  // namespace

PostureResult posture_at(const Manipulator& manipulator, const Pose& target,
                         const PostureOptions& options) {
  PostureResult result;
  result.reached = true;
  result.error.setZero();
  result.posture.platform = target;
  for (const Chain& chain : manipulator.chains()) {
    ChainPostureSolver solver(chain, target, options);
    result.posture.coordinates.push_back(solver.solve());
    const Vector6 scaled = solver.error(result.posture.coordinates.back());
    if (scaled.lpNorm<Eigen::Infinity>() <= solver.accepted()) continue;
    result.reached = false;
    Vector6 error = scaled;
    error.tail<3>() /= solver.length();
    if (result.reason.empty() || error.norm() > result.error.norm()) {
      result.error = error;
      result.reason = miss_text(chain.name(), error);
    }
  }
  return result;
}

PostureResult posture_from_joints(const Manipulator& manipulator,
                                  const std::map<std::string, double>& coordinates,
                                  const PostureOptions& options) {
  Posture posture;
  for (const Chain& chain : manipulator.chains()) posture.coordinates.push_back(chain.home());
  for (const auto& [name, value] : coordinates) {
    const JointName joint = find_joint(manipulator, name);
    posture.coordinates[joint.chain][joint.coordinate] = value;
  }
  if (manipulator.size() > 1) return close_loops(manipulator, std::move(posture), options);
  PostureResult result;
  ChainKinematics kinematics;
  evaluate(manipulator.chains()[0], posture.coordinates[0], kinematics);
  posture.platform = kinematics.end;
  result.reached = true;
  result.error.setZero();
  result.posture = std::move(posture);
  return result;
}

}  // namespace kinetostat::vjm

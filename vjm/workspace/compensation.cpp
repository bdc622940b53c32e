#include "kinetostat/vjm/workspace/compensation.h"

#include <algorithm>
#include <map>
#include <vector>

#include <fmt/format.h>

#include "kinetostat/spatial/decomposition.h"
#include "kinetostat/vjm/chain/kinematics.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Vector6;

// Of the largest change by a command: less is not controlled.
constexpr double least_share = 1e-6;

struct Actuator {
  std::size_t chain;
  Index coordinate;
  double unit;  // commands times this are lengths
};

double reach_of(const Manipulator& manipulator, const Posture& posture) {
  double reach = 0;
  ChainKinematics kinematics;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    evaluate(manipulator.chains()[c], posture.coordinates[c], kinematics);
    reach = std::max(reach, kinematics.reach);
  }
  return reach > 0 ? reach : 1.0;
}

std::vector<Actuator> actuators_of(const Manipulator& manipulator, double reach) {
  std::vector<Actuator> actuators;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const auto& coordinates = manipulator.chains()[c].coordinates();
    for (std::size_t k = 0; k < coordinates.size(); ++k)
      if (coordinates[k].role == Role::actuated)
        actuators.push_back(
            {c, static_cast<Index>(k), is_rotation(coordinates[k].motion) ? reach : 1.0});
  }
  return actuators;
}

// Correction of the commands of one target.
class Compensator {
 public:
  Compensator(const Manipulator& manipulator, const TargetPose& target,
              const CompensationOptions& options)
      : manipulator_(manipulator), target_(target), options_(options) {}

  Compensation run() {
    const PostureResult nominal = posture_holding(manipulator_, target_.platform, target_.held);
    if (!nominal.reached) return fail(CompensationStatus::unreachable, nominal.reason);
    result_.nominal = result_.corrected = nominal.posture;
    reach_ = reach_of(manipulator_, nominal.posture);
    actuators_ = actuators_of(manipulator_, reach_);
    if (!find_error(result_.error)) return result_;
    result_.residual = result_.error;
    MatrixXd jacobian = nominal_jacobian();
    if (result_.status == CompensationStatus::unreachable) return result_;
    choose_components(jacobian);
    iterate(selected_rows(jacobian));
    return result_;
  }

 private:
  Compensation fail(CompensationStatus status, const std::string& reason) {
    result_.status = status;
    result_.reason = reason;
    return result_;
  }

  Vector6 scaled(Vector6 error) const {
    error.tail<3>() *= reach_;
    return error;
  }

  // Posture with commands changed by `change` [m]; passive joints follow from where they are.
  PostureResult commanded(const Posture& from, const VectorXd& change) const {
    std::vector<VectorXd> coordinates = from.coordinates;
    for (std::size_t a = 0; a < actuators_.size(); ++a)
      coordinates[actuators_[a].chain][actuators_[a].coordinate] +=
          change[static_cast<Index>(a)] / actuators_[a].unit;
    std::map<std::string, double> values;
    for (std::size_t c = 0; c < manipulator_.size(); ++c) {
      const Chain& chain = manipulator_.chains()[c];
      for (const Index k : chain.posture_coordinates())
        values[chain.name() + "." + chain.coordinates()[static_cast<std::size_t>(k)].name] =
            coordinates[c][k];
    }
    return posture_from_joints(manipulator_, values);
  }

  // What is left at the corrected commands; false when the load cannot be carried there.
  bool find_error(Vector6& error) {
    const Equilibrium e =
        equilibrium_under_load(manipulator_, result_.corrected, target_.load, options_.equilibrium);
    if (e.status != EquilibriumStatus::converged) {
      fail(CompensationStatus::no_equilibrium, e.reason);
      return false;
    }
    if (!e.free.stable()) {
      fail(CompensationStatus::no_equilibrium,
           "the equilibrium under this load is unstable: the manipulator would leave it");
      return false;
    }
    error = spatial::pose_difference(target_.platform, e.platform);
    return true;
  }

  // Of the relaxed platform with respect to the commands, by central differences.
  MatrixXd nominal_jacobian() {
    const auto n = static_cast<Index>(actuators_.size());
    const double step = 1e-5 * reach_;
    MatrixXd jacobian(6, n);
    for (Index j = 0; j < n; ++j) {
      VectorXd change = VectorXd::Zero(n);
      change[j] = step;
      const PostureResult ahead = commanded(result_.nominal, change);
      const PostureResult behind = commanded(result_.nominal, -change);
      if (!ahead.reached || !behind.reached) {
        fail(CompensationStatus::unreachable, "the commands cannot be varied around the target: " +
                                                  (ahead.reached ? behind.reason : ahead.reason));
        return jacobian;
      }
      jacobian.col(j) =
          scaled(spatial::pose_difference(behind.posture.platform, ahead.posture.platform)) /
          (2 * step);
    }
    return jacobian;
  }

  void choose_components(const MatrixXd& jacobian) {
    result_.components = {true, true, true, true, true, true};
    if (options_.components) {
      result_.components = *options_.components;
      return;
    }
    if (spatial::rank_of(jacobian, least_share) == 6) return;
    const VectorXd lengths = jacobian.rowwise().norm();
    for (Index i = 0; i < 6; ++i)
      result_.components[static_cast<std::size_t>(i)] =
          i < 3 && lengths[i] > least_share * lengths.head<3>().maxCoeff();
  }

  template <class Rows>
  MatrixXd selected_rows(const Rows& all) const {
    MatrixXd rows(std::count(result_.components.begin(), result_.components.end(), true),
                  all.cols());
    Index row = 0;
    for (Index i = 0; i < 6; ++i)
      if (result_.components[static_cast<std::size_t>(i)]) rows.row(row++) = all.row(i);
    return rows;
  }

  // Broyden's method, in the directions that the commands control: beside these what rounding makes
  // of the updates would look like control. The correction, not the error, must vanish.
  void iterate(const MatrixXd& nominal) {
    const MatrixXd controlled = spatial::range_of(nominal, least_share).transpose();
    MatrixXd jacobian = controlled * nominal;
    const auto left_of = [&](const Vector6& residual) {
      return (controlled * selected_rows(scaled(residual))).eval();
    };
    VectorXd error = left_of(result_.residual);
    for (int i = 1; i <= options_.max_iterations; ++i) {
      const VectorXd change =
          -spatial::shortest_least_squares_solution(jacobian, error, least_share);
      const PostureResult next = commanded(result_.corrected, change);
      if (!next.reached) {
        fail(CompensationStatus::unreachable, next.reason);
        return;
      }
      result_.corrected = next.posture;
      result_.iterations = i;
      if (!find_error(result_.residual)) return;
      const VectorXd left = left_of(result_.residual);
      if (change.norm() <= options_.tolerance * reach_) {
        result_.status = CompensationStatus::converged;
        return;
      }
      jacobian += (left - error - jacobian * change) * change.transpose() / change.squaredNorm();
      error = left;
    }
    fail(CompensationStatus::not_converged,
         fmt::format("after {} corrections {:.3g} mm and {:.3g} deg were left",
                     options_.max_iterations, 1e3 * result_.residual.head<3>().norm(),
                     result_.residual.tail<3>().norm() * 180 / M_PI));
  }

  const Manipulator& manipulator_;
  const TargetPose& target_;
  const CompensationOptions& options_;
  double reach_ = 1;
  std::vector<Actuator> actuators_;
  Compensation result_;
};

}  // namespace

Compensation compensate(const Manipulator& manipulator, const TargetPose& target,
                        const CompensationOptions& options) {
  return Compensator(manipulator, target, options).run();
}

}  // namespace kinetostat::vjm

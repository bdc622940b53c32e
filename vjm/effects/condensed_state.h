// A loaded manipulator as its joints feel it, one at a time: static condensation. All that laws in
// a joint can do to the rest of the manipulator is to put the joint elsewhere; how the rest then
// stands, and with which force it holds the joint, does not depend on the laws.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "kinetostat/spatial/pose.h"
#include "kinetostat/vjm/manipulator/joint_place.h"

namespace kinetostat::vjm {

/// The rest of a manipulator with one joint held, everything else in equilibrium.
class CondensedJoint {
 public:
  /// Where the joint stands, x from where it is in equilibrium [m or rad]: the force of all but
  /// its own spring and laws on it [N or N m], and how the pose that is read has moved
  /// [translation; rotation vector], base axes.
  using Values = Eigen::Matrix<double, 7, 1>;
  struct Sample {
    double x = 0;
    Values values, by_x;
  };

  /// From what is known at equilibrium (x = 0, no motion) and on both sides of it: the polynomial
  /// of fifth degree that has all the values and derivatives. `stiffness`: of the joint against a
  /// force on it [N/m or N m/rad]. nullopt where samples do not lie on one smooth curve.
  static std::optional<CondensedJoint> through(const Sample& here, const Sample& below,
                                               const Sample& above, double stiffness);

  /// Between the outer samples it is known.
  double lower() const { return ends_[0]; }
  double upper() const { return ends_[1]; }
  Sample at(double x) const;
  /// The force of it alone, and its derivative.
  struct Force {
    double value = 0, slope = 0;
  };
  Force force_at(double x) const;

 private:
  template <class Coefficients, class Value>
  void evaluate(const Coefficients& coefficients, double x, Value& value, Value& slope) const;

  std::array<double, 2> ends_{};
  Eigen::Matrix<double, 7, 6> coefficients_;  // Newton's, nodes 0, 0, below, below, above, above
};

/// One equilibrium, with the joints of which that was asked.
struct CondensedState {
  struct Joint {
    JointPlace place;
    double stiffness = 0;  // against a force on it [N/m or N m/rad]
    CondensedJoint rest;
  };
  spatial::Pose platform;                    // base axes
  spatial::Pose observed;                    // pose that is read, base axes
  std::vector<Eigen::VectorXd> coordinates;  // all of each chain [m or rad]
  std::vector<Eigen::VectorXd> commands;     // the same where nothing is loaded
  std::vector<Joint> joints;                 // that could be condensed
  /// Histories of the model's effects, before this equilibrium and after it; empty where none has
  /// any.
  std::vector<Eigen::VectorXd> before = {}, after = {};

  const Joint* find(const JointPlace& place) const;
};

}  // namespace kinetostat::vjm

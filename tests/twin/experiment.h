// A measuring campaign on a twin: what is loaded how and when, and what is read.
#pragma once

#include <string>
#include <vector>

#include "hidden_effect.h"
#include "random.h"

namespace twin {

/// Loads and postures of an experiment.
struct Plan {
  bool absolute = false;   // poses in a session frame that nobody knows, or differences
  bool rotations = false;  // read beside translations
  std::vector<Posture> postures;
  std::vector<Row> rows;  // cycle by cycle
};

/// Load cycles at a few postures along every axis: up, down, reverse, back. Differences.
Plan cycle_plan(const RobotSpec& robot, Random& random);
/// Only up, never back: what cannot show friction.
Plan one_way_plan(const RobotSpec& robot, Random& random);
/// A push and a release, then a pull, at a few postures along every axis. Differences.
Plan push_plan(const RobotSpec& robot, Random& random);
/// Two weights hung on and taken off at a dozen postures. Differences.
Plan weight_plan(const RobotSpec& robot, Random& random);
/// Poses at many postures under no load and two loads, over two days with their warmth. Absolute.
Plan pose_plan(const RobotSpec& robot, Random& random);
Plan plan_named(const std::string& name, const RobotSpec& robot, Random& random);

/// Readings without noise; 6 rows [m; rad], one column a reading.
struct Responses {
  Eigen::Matrix<double, 6, Eigen::Dynamic> read;
  Eigen::Matrix<double, 6, Eigen::Dynamic> elastic;  // the part of it that the load causes
  std::vector<Eigen::MatrixXd> by_springs;           // 6 x springs of each, to their logarithms
  std::vector<Vector3> positions;                    // of the platform
};

struct World {
  RobotSpec robot;
  std::vector<double> factors;  // on the nominal stiffness of each spring
  std::vector<HiddenEffect> effects;
  int elements = 6;
};

/// Throws std::runtime_error when there is no equilibrium.
Responses respond(const World& world, const Plan& plan, bool with_derivatives);

/// Standard deviations of the readings: of a tracker worse along its line of sight, and of a load
/// cell of 0.75 %. 6 rows, one column a reading.
Eigen::Matrix<double, 6, Eigen::Dynamic> stated_noise(const RobotSpec& robot,
                                                      const Responses& base);
constexpr double wrench_noise = 0.0075;

/// Whitened difference between worlds, after everything that the product fits has been taken out:
/// spring stiffnesses, and in absolute readings the frame of each session.
class Whitened {
 public:
  Whitened(const Plan& plan, const Responses& base,
           const Eigen::Matrix<double, 6, Eigen::Dynamic>& noise);
  /// Residual of the difference to the base; its length is the detectability d'.
  Eigen::VectorXd mark_of(const Responses& other) const;

 private:
  Eigen::VectorXd whiten(const Eigen::Matrix<double, 6, Eigen::Dynamic>& values) const;

  int components_;
  const Responses& base_;
  Eigen::Matrix<double, 6, Eigen::Dynamic> noise_;
  Eigen::MatrixXd basis_;
};

}  // namespace twin

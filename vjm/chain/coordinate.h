// Coordinates of a chain and the springs over them.
#pragma once

#include <array>
#include <optional>
#include <string>

#include <Eigen/Core>

namespace kinetostat::vjm {

/// Elementary motion along or about an axis of the moving frame.
enum class Motion { tx, ty, tz, rx, ry, rz };

inline constexpr Motion all_motions[] = {Motion::tx, Motion::ty, Motion::tz,
                                         Motion::rx, Motion::ry, Motion::rz};
inline bool is_rotation(Motion motion) { return motion >= Motion::rx; }
/// 0, 1, 2 for x, y, z.
inline int axis_index(Motion motion) { return static_cast<int>(motion) % 3; }
/// "Tx" ... "Rz".
std::string to_string(Motion motion);

/// Who decides the value of a coordinate.
enum class Role {
  actuated,  // the controller: a command, to which the joint's spring (if any) adds its deflection
  passive,   // nobody, or a spring with a given rest value
  elastic    // a virtual spring of a link; rest value 0
};

/// One generalised coordinate x_k of a chain [m or rad].
struct Coordinate {
  std::string name;  // "rho", "u1.Rz", "leg.Ty"
  Role role = Role::passive;
  Motion motion = Motion::tx;
  double home = 0;  // where the search for a posture starts
  /// Where its command may lie, least and largest; none: not stated.
  std::optional<std::array<double, 2>> range = {};
};

/// A linear spring over one coordinate, or over the six of a link: force = -stiffness (x - rest).
/// For an actuated coordinate the rest value is the command and comes with the posture.
struct Spring {
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;

  std::string name;
  Eigen::Index first = 0;  // first coordinate; the others follow
  Matrix stiffness;        // symmetric positive definite
  double series = 0;       // of a single coordinate: compliance in series that scaling leaves alone

  /// dK/dlog k0 over K: 1 - K c, where a compliance c in series does not scale (1/K = 1/k0 + c).
  double share_that_scales() const { return series > 0 ? 1 - stiffness(0, 0) * series : 1; }
};

}  // namespace kinetostat::vjm

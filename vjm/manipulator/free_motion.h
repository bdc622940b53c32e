// Which motions of a platform meet no resistance, in words.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "kinetostat/spatial/stiffness.h"

namespace kinetostat::vjm {

/// A one-parameter motion: translation along `direction`, or a rotation about the axis through
/// `point` along `direction` that advances by `pitch` [m/rad].
struct ScrewMotion {
  bool is_translation = false;
  spatial::Vector3 direction = spatial::Vector3::UnitX();
  spatial::Vector3 point = spatial::Vector3::Zero();  // of the axis, nearest the reference point
  double pitch = 0;
};

/// The null space of a Cartesian stiffness matrix.
struct FreeMotions {
  int rank = 6;
  std::vector<ScrewMotion> motions;    // 6 - rank of them, spanning the null space
  std::vector<std::string> sentences;  // the same in words; lengths in mm
};

/// Rank and null motions of a symmetric stiffness; `length` [m] makes rotations comparable with
/// translations (the size of the robot). A direction is free when its stiffness is below
/// `tolerance` times the largest.
FreeMotions free_motions(const spatial::Stiffness6& stiffness, double length,
                         double tolerance = 1e-9);

/// Wrenches to which a compliance does not yield: its null space, as forces along axes
/// ("rotations") and couples ("translations").
FreeMotions rigid_wrenches(const spatial::Compliance6& compliance, double length,
                           double tolerance = 1e-9);

/// The free motions given as a basis of twists (columns [v; w] at frame.point in frame.axes).
FreeMotions describe_twists(const Eigen::Matrix<double, 6, Eigen::Dynamic>& twists,
                            const spatial::Frame& frame, double length);

}  // namespace kinetostat::vjm

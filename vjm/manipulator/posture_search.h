// What all searches for the posture of a chain share. Internal to this module.
#pragma once

#include <string>

#include "kinetostat/vjm/chain/kinematics.h"
#include "kinetostat/vjm/manipulator/posture_result.h"

namespace kinetostat::vjm {

/// Error of closed loops that counts as none, over the reach.
inline constexpr double closed_loop_error = 1e-11;

/// Errors [m] of a chain of this length [m] that a search for a pose stops at, and that count as
/// reached: rounding of the pose itself bounds the first, and what closed loops have led to, which
/// is over-constrained, comes no nearer than the second.
struct PostureAccuracy {
  double sought, accepted;
};
PostureAccuracy posture_accuracy(double length, const spatial::Pose& target,
                                 const PostureOptions& options);

/// The reach of a chain, by which a search makes rotations comparable [m]; 1 where it has none.
double search_length(const Chain& chain, const Eigen::VectorXd& x, ChainKinematics& kinematics);

/// Coordinates from which a search starts: home first (0), then scattered ones, always the same.
Eigen::VectorXd starting_point(const Chain& chain, int start, double length);

/// What is said of a chain that misses a pose by an error [m; rad].
std::string miss_text(const std::string& chain, const spatial::Vector6& error);
/// That a chain misses the pose by an error [m; rad]. The largest miss is the one that is reported.
void note_miss(const Chain& chain, const spatial::Vector6& error, PostureResult& result);

}  // namespace kinetostat::vjm

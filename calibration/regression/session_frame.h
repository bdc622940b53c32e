// The frame in which the readings of one session are given, when nobody knows where it stands.
#pragma once

#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"

namespace kinetostat::calibration {

/// A displacement as seen from a frame, and how that changes.
struct SeenFromFrame {
  spatial::Vector6 displacement;     // [m; rad]
  spatial::Matrix6 by_displacement;  // derivative with respect to the displacement before
  spatial::Matrix6 by_frame;         // with respect to `frame`
};

/// `frame`: position [m] and rotation vector [rad] of the measuring frame that the campaign states,
/// seen from the one that the session really had; 0: the same. Absolute poses are moved and turned
/// by it; differences are turned only, so that its position does not matter. The result has the
/// rotation vector nearest to `measured` among equivalent ones.
SeenFromFrame seen_from(const spatial::Vector6& frame, const spatial::Vector6& displacement,
                        DisplacementKind kind, const spatial::Vector6& measured);
/// The same for many displacements from one frame.
class MeasuringFrame {
 public:
  explicit MeasuringFrame(const spatial::Vector6& frame);
  const spatial::Matrix3& turn() const { return turn_; }
  SeenFromFrame seen(const spatial::Vector6& displacement, DisplacementKind kind,
                     const spatial::Vector6& measured) const;

 private:
  spatial::Vector3 position_;
  spatial::Matrix3 turn_, increment_;  // of the turn, by its vector
};

/// Components that one sensor reads in the frame of the instrument, with their axes in the order of
/// component_names.
struct FramedComponents {
  std::vector<Eigen::Index> axes, rows;
};
/// One a sensor that is read so.
std::vector<FramedComponents> framed_components(const Campaign& campaign);

/// The frame that brings predicted positions nearest to measured ones (Umeyama 1991, without
/// scale): where a fit starts. Zero where there are fewer than three positions.
spatial::Vector6 frame_between(const std::vector<spatial::Vector3>& predicted,
                               const std::vector<spatial::Vector3>& measured);

/// A position that is measured of a target on a body.
struct PlacedPosition {
  std::size_t frame = 0;       // of those that are sought
  spatial::Vector3 predicted;  // of the body, in the stated frame [m]
  spatial::Matrix3 axes;       // of the body, in the same frame
  spatial::Vector3 measured;   // of the target, in the frame that is sought [m]
};

/// Frames as frame_between() has them, and a target in the axes of the body.
struct FramesAndTarget {
  std::vector<spatial::Vector6> frames;
  spatial::Vector3 target = spatial::Vector3::Zero();
};

/// Brings the positions of the target nearest to those measured, by turns: the frames to the target
/// as it is, then the target to the frames (linear least squares, of smallest norm where the body
/// hardly turns). Where a fit of both starts.
FramesAndTarget frames_and_target(const std::vector<PlacedPosition>& positions, std::size_t frames);

}  // namespace kinetostat::calibration

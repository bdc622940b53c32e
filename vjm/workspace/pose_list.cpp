#include "kinetostat/vjm/workspace/pose_list.h"

namespace kinetostat::vjm {

PostureResult posture_to(const Manipulator& manipulator, const TargetPose& target) {
  if (target.is_by_joints) return posture_from_joints(manipulator, target.held);
  return posture_holding(manipulator, target.platform, target.held);
}

}  // namespace kinetostat::vjm

#include "kinetostat/vjm/manipulator/redundancy.h"

#include "kinetostat/vjm/chain/kinematics.h"
#include "kinetostat/vjm/manipulator/joint_place.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::vjm {
namespace {

// Small beside the robot, large beside the accuracy of postures.
double little(const Manipulator& manipulator, const Posture& posture, const JointPlace& place) {
  constexpr double part = 1e-3;
  if (is_rotation(coordinate_at(manipulator, place).motion)) return part;
  ChainKinematics kinematics;
  evaluate(manipulator.chains()[place.chain], posture.coordinates[place.chain], kinematics);
  return part * (kinematics.reach > 0 ? kinematics.reach : 1);
}

}  // namespace

bool may_move_at(const Manipulator& manipulator, const spatial::Pose& target,
                 const std::map<std::string, double>& held, const std::string& joint) {
  const JointPlace place = find_joint(manipulator, joint);
  const PostureResult standing = posture_holding(manipulator, target, held);
  if (!standing.reached) return false;
  const double value = standing.posture.coordinates[place.chain][place.coordinate];
  const double step = little(manipulator, standing.posture, place);
  std::map<std::string, double> moved = held;
  for (const double side : {step, -step}) {
    moved[full_name(manipulator, place)] = value + side;
    if (posture_holding(manipulator, target, moved).reached) return true;
  }
  return false;
}

std::vector<std::string> redundant_joints(const Manipulator& manipulator,
                                          const spatial::Pose& target,
                                          const std::map<std::string, double>& held) {
  std::vector<std::string> names;
  for (const JointPlace& place : actuated_joints(manipulator))
    if (may_move_at(manipulator, target, held, full_name(manipulator, place)))
      names.push_back(full_name(manipulator, place));
  return names;
}

}  // namespace kinetostat::vjm

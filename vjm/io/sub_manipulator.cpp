#include "kinetostat/vjm/io/sub_manipulator.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/Eigenvalues>

#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/stiffness.h"

namespace kinetostat::vjm {
namespace {

using spatial::Matrix6;
using spatial::Pose;
using spatial::Vector6;

constexpr double negligible = 1e-9;  // of the largest eigenvalue

// Values of joints in the units of the file that names them.
std::map<std::string, double> read_joints(const io::YamlNode& node, const Manipulator& of,
                                          const spatial::UnitSystem& units) {
  std::map<std::string, double> values;
  for (const auto& [name, value] : node.members()) {
    bool turns = true;
    for (const Chain& chain : of.chains())
      for (const Coordinate& c : chain.coordinates())
        if (name == c.name || name == chain.name() + "." + c.name) turns = is_rotation(c.motion);
    values[name] =
        value.quantity(turns ? spatial::dimension::angle : spatial::dimension::length, units);
  }
  return values;
}

Posture read_posture(const io::YamlNode& node, const Manipulator& manipulator,
                     const spatial::UnitSystem& units) {
  const auto joints = node.find("joints");
  if (const auto at = node.find("at")) {
    if (joints) joints->fail("a posture follows from 'at' or from 'joints', not from both");
    const PostureResult result = posture_at(manipulator, io::read_pose(*at, units));
    if (!result.reached) at->fail(result.reason);
    return result.posture;
  }
  try {
    const PostureResult result =
        posture_from_joints(manipulator, joints ? read_joints(*joints, manipulator, units)
                                                : std::map<std::string, double>{});
    if (result.reached) return result.posture;
    (joints ? *joints : node).fail(result.reason);
  } catch (const std::invalid_argument& error) {
    (joints ? *joints : node).fail(error.what());
  }
}

// A free translation that is not normal to the axis of a screw takes its pitch away: both together
// are a rotation about another axis.
void remove_pitch(ScrewMotion& screw, const std::vector<ScrewMotion>& motions) {
  if (screw.is_translation || screw.pitch == 0) return;
  const spatial::Vector3& axis = screw.direction;
  for (const ScrewMotion& other : motions) {
    if (!other.is_translation || std::abs(axis.dot(other.direction)) < 1e-6) continue;
    const spatial::Vector3 velocity =
        screw.point.cross(axis) + screw.pitch * axis -
        screw.pitch / axis.dot(other.direction) * other.direction;  // of the origin
    screw.point = axis.cross(velocity);
    screw.pitch = 0;
    return;
  }
}

}  // namespace

LinkPart part_with_free_motions(const Pose& offset, const Matrix6& stiffness, double length) {
  Vector6 scale = Vector6::Ones();
  scale.tail<3>().setConstant(1 / length);
  const Matrix6 scaled = scale.asDiagonal() * stiffness * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(0.5 * (scaled + scaled.transpose()));
  const double largest = eigen.eigenvalues()[5];
  if (!(largest > 0) || eigen.eigenvalues()[0] < -negligible * largest)
    throw std::invalid_argument("the stiffness is not positive semi-definite");

  LinkPart part{.offset = offset};
  part.free_motions = free_motions(spatial::Stiffness6(stiffness), length, negligible).motions;
  for (ScrewMotion& motion : part.free_motions) {
    remove_pitch(motion, part.free_motions);
    if (std::abs(motion.pitch) < 1e-6 * length) motion.pitch = 0;
  }
  Vector6 raised = eigen.eigenvalues();
  for (double& value : raised)
    if (value <= negligible * largest) value = largest;
  const Matrix6 regular =
      eigen.eigenvectors() * raised.asDiagonal() * eigen.eigenvectors().transpose();
  const Vector6 back = scale.cwiseInverse();
  part.compliance = spatial::Stiffness6(back.asDiagonal() * regular * back.asDiagonal()).inverse();
  return part;
}

namespace {

std::filesystem::path robot_file_of(const io::YamlNode& name, const LinkOptions& options) {
  std::filesystem::path file = std::filesystem::weakly_canonical(name.existing_file());
  if (std::find(options.within.begin(), options.within.end(), file) != options.within.end())
    name.fail("this robot file is part of itself", "Name another one");
  return file;
}

}  // namespace

LinkModel read_sub_manipulator(const io::YamlNode& node, const spatial::UnitSystem& units,
                               const LinkOptions& options, const ReadManipulator& read) {
  node.allow_only({"manipulator", "at", "joints"});
  const io::YamlNode name = node.at("manipulator");
  const std::filesystem::path file = robot_file_of(name, options);
  const Manipulator manipulator = read(file, options);
  const Posture posture = read_posture(node, manipulator, units);
  const UnloadedStiffness unloaded = unloaded_stiffness(manipulator, posture);
  if (!unloaded.stiffness)
    name.fail("the manipulator is rigid in some direction and has no stiffness matrix",
              "Give its actuators a stiffness");
  const spatial::Frame end{posture.platform.position(), posture.platform.rotation()};
  try {
    return {.parts = {part_with_free_motions(posture.platform, unloaded.stiffness->in(end).matrix(),
                                             unloaded.length)},
            .file = file};
  } catch (const std::invalid_argument& error) {
    name.fail(error.what());
  }
}

}  // namespace kinetostat::vjm

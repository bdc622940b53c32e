// Robots described in URDF, as far as a stiffness model needs them.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/spatial/pose.h"

namespace kinetostat::vjm {

struct UrdfInertia {
  double mass = 0;                                     // [kg]
  spatial::Vector3 center = spatial::Vector3::Zero();  // [m], link frame
  /// ixx ixy ixz iyy iyz izz about the centre [kg m^2], in the axes of <origin>.
  std::array<double, 6> moments{};
};

struct UrdfLink {
  std::string name;
  int line = 0;
  std::optional<UrdfInertia> inertia = {};
  std::vector<std::string> meshes = {};  // visual first, as written
};

enum class UrdfJointType { fixed, revolute, continuous, prismatic };

struct UrdfJoint {
  std::string name;
  int line = 0;
  UrdfJointType type = UrdfJointType::fixed;
  std::string parent, child;                          // names of links
  spatial::Pose origin = {};                          // of the child in the parent, at zero
  spatial::Vector3 axis = spatial::Vector3::UnitX();  // unit vector, child frame
  std::optional<std::array<double, 2>> limits = {};   // [m or rad]
  std::string mimics = {};                            // name of a joint, or empty
  double mimic_factor = 1, mimic_offset = 0;
};

bool turns(const UrdfJoint& joint);

struct UrdfModel {
  std::filesystem::path file;
  std::string name;
  std::vector<UrdfLink> links;
  std::vector<UrdfJoint> joints;
};

/// Throws common::InputError with file and line when the file is not XML, not URDF (a xacro file
/// that was not expanded), names a link or joint twice or one that is not there, or has a joint of
/// a type that a stiffness model cannot have (floating, planar).
UrdfModel read_urdf(const std::filesystem::path& file);

/// The chain between two links; fixed joints are part of it.
struct UrdfChain {
  std::string base, tip;
  std::vector<std::size_t> joints;  // numbers in the model, from base to tip
};

/// `base` empty: the root. `tip` empty: the only link without children. Throws common::InputError
/// when there are several candidates (they are listed), or no way from base to tip.
UrdfChain find_chain(const UrdfModel& model, const std::string& base, const std::string& tip);

/// Data of a stiffness model that URDF lacks.
struct MissingStiffness {
  std::string key;   // place in the robot file: "links.upper_arm"
  std::string what;  // in words
};

struct ImportedRobot {
  std::string text;  // of the robot file
  std::vector<MissingStiffness> missing;
  std::vector<UrdfJoint> drives;  // the joints that have one, from base to tip
};

/// A robot file (docs/reference/robot-file.md) in m, N, rad: every joint that moves becomes an
/// actuator about or along an axis of its own frame, every link between two of them a rigid link
/// with the mass of all that is fixed to it. `stiffness` of the drives [N m/rad or N/m], in their
/// order; empty: to be added by hand. Joints that mimic one leader are coupled
/// to the first of them in the chain, which is driven; the leader itself may be elsewhere. Throws
/// common::InputError for a mimic joint that follows none, or itself, and for a chain without
/// joints that move.
ImportedRobot import_robot(const UrdfModel& model, const UrdfChain& chain,
                           const std::vector<double>& stiffness = {});

}  // namespace kinetostat::vjm

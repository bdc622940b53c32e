// Robots as other programs describe them, as far as a stiffness model needs that: a tree of links
// and joints, whatever the format.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/spatial/pose.h"

namespace kinetostat::vjm {

struct DescribedInertia {
  double mass = 0;                                     // [kg]
  spatial::Vector3 center = spatial::Vector3::Zero();  // [m], link frame
  spatial::Matrix3 tensor =
      spatial::Matrix3::Zero();  // [kg m^2] about the centre, axes of the link
  bool is_assumed = false;       // by the format: the file says nothing
};

/// A body given by numbers, its centre at the origin, round about z.
struct PrimitiveSolid {
  enum class Kind { box, cylinder, capsule };
  Kind kind = Kind::box;
  spatial::Vector3 edges = spatial::Vector3::Zero();  // [m] of a box
  double radius = 0, length = 0;  // [m]; length between the half balls of a capsule: 0 for a ball

  bool has_volume() const;
};

/// What a link looks like, or a part of that.
struct DescribedShape {
  std::string file = {};  // of a mesh, as written; empty: the solid
  PrimitiveSolid solid = {};
  spatial::Pose pose = {};                            // in the link
  spatial::Vector3 scale = spatial::Vector3::Ones();  // of its coordinates, to metres
  bool is_collision = false;                          // else to look at

  bool is_empty() const { return file.empty() && !solid.has_volume(); }
  /// "arm.dae", without folders, or "a box".
  std::string name() const;
};

struct DescribedLink {
  std::string name;
  int line = 0;
  std::optional<DescribedInertia> inertia = {};
  std::vector<DescribedShape> shapes = {};
  bool is_mark = false;  // a frame that carries nothing, as a site of MJCF
};

enum class JointType { fixed, revolute, continuous, prismatic };

struct DescribedJoint {
  std::string name;
  int line = 0;
  JointType type = JointType::fixed;
  std::string parent = {}, child = {};                // names of links
  spatial::Pose origin = {};                          // of the child in the parent, at zero
  spatial::Vector3 axis = spatial::Vector3::UnitX();  // unit vector, child frame
  std::optional<std::array<double, 2>> limits = {};   // [m or rad]
  std::string mimics = {};                            // name of a joint, or empty
  double mimic_factor = 1, mimic_offset = 0;
  std::optional<double> effort = {};     // largest [N or N m]
  std::optional<double> stiffness = {};  // of a spring of the joint [N/m or N m/rad]
  std::optional<double> rest = {};       // where that is relaxed, where stated [m or rad]
};

bool turns(const DescribedJoint& joint);
/// Whether a coordinate [m or rad] is beyond the limits of the joint.
bool is_out_of_range(const DescribedJoint& joint, double coordinate);

struct RobotDescription {
  std::filesystem::path file;
  std::string format;  // "URDF"
  std::string name;
  std::vector<DescribedLink> links = {};
  std::vector<DescribedJoint> joints = {};
  spatial::Vector3 gravity{0, 0, -9.80665};  // [m/s^2], axes of the root
  std::vector<std::string> remarks = {};     // what the file says and this does not hold, in words
};

/// The joint that carries a link, or nullptr.
const DescribedJoint* carrier_of(const RobotDescription& robot, const std::string& link);

/// Throws common::InputError where names are used twice, a joint names a link that is not there, or
/// a link is the child of two joints.
void check_names(const RobotDescription& robot);

/// The chain between two links; fixed joints are part of it.
struct DescribedChain {
  std::string base, tip;
  std::vector<std::size_t> joints;  // numbers in the description, from base to tip
};

/// `base` empty: the root. `tip` empty: the only link without children. Throws common::InputError
/// when there are several candidates (they are listed), or no way from base to tip.
DescribedChain find_chain(const RobotDescription& robot, const std::string& base,
                          const std::string& tip);

}  // namespace kinetostat::vjm

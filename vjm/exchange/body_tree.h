// A serial robot in a posture as simulators of rigid bodies take it: bodies with joints.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::vjm {

/// What moves together from one joint to the next. SI units; the frame of a body is behind its
/// joint.
struct TreeBody {
  std::string name;   // of its joint; never "world", which simulators keep for themselves
  bool turns = true;  // its joint; else it slides
  int axis = 2;       // about or along x, y or z of its frame: 0, 1, 2
  spatial::Pose
      origin;        // its frame where its joint stands at zero, in the frame of the body before
  double value = 0;  // of the joint in the posture [m or rad]
  // Of a joint that moves with one of a body before: that body, and its motion for one of the other
  // [m or rad, of m or rad]. It has no spring of its own.
  struct Coupling {
    std::size_t leader = 0;
    double factor = 1;
  };
  std::optional<Coupling> coupling = {};
  std::optional<double> stiffness = {};                 // of its spring [N/m or N m/rad]
  double rest = 0;                                      // where the spring is relaxed [m or rad]
  double damping = 0;                                   // [N s/m or N m s/rad]
  std::optional<std::array<double, 2>> range = {};      // of its joint, where stated [m or rad]
  double mass = 0;                                      // [kg]
  spatial::Vector3 center = spatial::Vector3::Zero();   // [m] in its frame
  spatial::Matrix3 inertia = spatial::Matrix3::Zero();  // [kg m^2] about the centre, its axes
};

struct BodyTree {
  std::string name;
  spatial::Vector3 gravity = spatial::Vector3::Zero();  // [m/s^2] base axes
  std::vector<TreeBody> bodies;   // from the base on; the first is on the base
  spatial::Pose tool;             // in the frame of the last body
  std::vector<std::string> lost;  // what no tree of bodies can hold, in words
};

/// The body as simulators want it, which take none without mass, or without inertia about an axis:
/// 2e-6 kg at least, and a billionth more inertia than it has, or 1e-9 kg m^2 more where it lacks
/// some or has less than that mass.
TreeBody with_least_inertia(TreeBody body);

/// Effects whose laws are more than a linear model of the robot has, in words: not a further
/// compliance of a joint, which is in its spring.
std::vector<std::string> lost_effects(const Robot& robot);

/// All that a file lacks, in words: `own` of its format, that bodies have no more than the least
/// inertia where it `has_least_inertia`, and what no tree can hold.
std::vector<std::string> lost_in_file(std::vector<std::string> own, const BodyTree& tree,
                                      bool has_least_inertia);

/// A name for something of the file beside those of the bodies: `wanted`, with underscores behind
/// it until neither a body nor its "..._link" is called so.
std::string free_name(std::string wanted, const BodyTree& tree);

struct TreeOptions {
  /// A damper beside every spring, so that the joint alone, all others held in the posture, has
  /// this ratio to critical damping: 2 ratio sqrt(k m).
  double damping_ratio = 0;
};

/// A body for every joint that moves, with the masses behind it (particles.h); links are rigid;
/// drives without a spring are fixed at their command. Of joints that share a coordinate the first
/// has its spring, and the others follow it. Throws std::invalid_argument for a robot of several
/// chains.
BodyTree body_tree(const Robot& robot, const Posture& posture, const TreeOptions& options = {});

/// A text in an attribute or as content of XML.
std::string xml_escaped(const std::string& text);

/// Three numbers with blanks between, without the sign of a zero.
std::string xml_words(const spatial::Vector3& v);

/// Roll, pitch and yaw of a rotation [rad]: the inverse of spatial::rotation_from_rpy().
spatial::Vector3 roll_pitch_yaw(const spatial::Matrix3& rotation);

/// Comment lines, each after `start`, that say what the file does not hold.
std::string lost_comment(const std::vector<std::string>& lost, const std::string& start,
                         const std::string& end = "");

}  // namespace kinetostat::vjm

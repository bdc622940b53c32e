// From the description of a robot to the text of a robot file.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "kinetostat/vjm/exchange/robot_description.h"

namespace kinetostat::vjm {

/// Data of a stiffness model that the description lacks.
struct MissingStiffness {
  std::string key;   // place in the robot file: "links.upper_arm"
  std::string what;  // in words
};

/// What moves together between two joints: a link of the robot file, whose start frame is behind
/// the joint before it and whose end frame is before the next joint, or at the tip.
struct ImportedBody {
  std::string name;
  spatial::Pose end = {};                                   // in the start frame
  spatial::Vector3 start_axis = spatial::Vector3::UnitZ();  // of the joint before, start frame
  std::optional<spatial::Vector3> end_axis = {};            // of the next one, start frame
  std::vector<DescribedShape> shapes = {};                  // poses in the start frame
  double mass = 0;                                          // [kg]
};

/// A link with a mass that moves beside the chain.
struct LeftOutLink {
  std::string name;
  double mass = 0;  // [kg]
};
/// "Left out, as it moves on a branch beside the chain: 'finger' (0.1 kg)."
std::string in_words(const std::vector<LeftOutLink>& left_out);

struct ImportedRobot {
  std::string text;  // of the robot file
  std::vector<MissingStiffness> missing;
  std::vector<DescribedJoint> drives;  // the joints that have one, from base to tip
  std::vector<ImportedBody> bodies;    // from base to tip
  std::vector<LeftOutLink> left_out;
};

struct ImportOptions {
  /// Of drives by their names [N m/rad or N/m]. Of others the one that the description has, else
  /// it is to be added by hand.
  std::map<std::string, double> stiffness = {};
  /// By the name of a body: its lines in the robot file in the place of `rigid: ...`, each with its
  /// line end and without indentation, with the end frame of the body.
  std::map<std::string, std::string> links = {};
  /// By the name of a body: why it has none.
  std::map<std::string, std::string> reasons = {};
  std::vector<std::string> notes = {};  // comments at the top of the file
};

/// A robot file (docs/reference/robot-file.md) in m, N, rad: every joint that moves becomes an
/// actuator about or along an axis of its own frame, every link between two of them a rigid link,
/// unless `options` have another, with mass, centre of mass and inertia of all that is fixed to it.
/// Joints that mimic one leader are coupled to the first of them in the chain, which is driven; the
/// leader itself may be elsewhere. Throws common::InputError for a mimic joint that follows none,
/// or itself, and for a chain without joints that move.
ImportedRobot import_robot(const RobotDescription& robot, const DescribedChain& chain,
                           const ImportOptions& options = {});

}  // namespace kinetostat::vjm

// The robots of the twin: what is known of them (and written into a robot file), and the structure
// of bodies and springs that one of them really is in a posture.
#pragma once

#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "structure.h"

namespace twin {

inline constexpr double degree = std::numbers::pi / 180;  // [rad]

/// A slender prismatic beam (Euler-Bernoulli) along x of its own axes, y and z its principal axes.
struct Beam {
  double length = 0;                       // [m]
  double area = 0, Iy = 0, Iz = 0, J = 0;  // [m^2], [m^4]
  double E = 0, G = 0, density = 0;        // [Pa], [kg/m^3]
  Vector3 direction = Vector3::UnitX();    // in the frame where it starts

  /// x along the beam, z as near as can be to the z of the frame where it starts.
  Matrix3 axes() const;
  double mass() const { return density * area * length; }
};

/// An element of a chain.
struct Item {
  enum Kind { actuator, passive, link, offset } kind = offset;
  std::string name;
  std::vector<int> axes = {};  // 0 1 2 along x y z, 3 4 5 about them
  double stiffness = 0;        // of an actuator [N/m or N m/rad]
  double home = 0;             // [m or rad]
  Beam beam = {};
  Vector3 reach = Vector3::Zero();  // of an offset
};

struct ChainSpec {
  std::string name;
  Pose base, on_platform;  // where it starts; its last frame in platform axes
  std::vector<Item> items;
};

struct RobotSpec {
  std::string name;
  std::vector<ChainSpec> chains;
  bool serial = true;
  double largest_force = 0;  // [N] bends it by about half a millimetre
  // Of a parallel robot: where its platform is at home, and how far it goes to either side [m].
  Vector3 centre = Vector3::Zero(), reach = Vector3::Constant(0.07);
  bool links_known = false;  // the stiffness of drives scatters only
  bool planar = false;       // moves and is loaded in the plane of x and y

  /// Places of the stiffnesses that scatter, in order: actuators and, unless known, links, "x.rho"
  /// or "q1".
  std::vector<std::string> springs() const;
  std::string place(const ChainSpec& chain, const Item& item) const;
  /// Number of joint coordinates of a chain.
  static int coordinates(const ChainSpec& chain);
  bool scatters(const Item& item) const {
    return item.kind == Item::actuator || (item.kind == Item::link && !links_known);
  }
};

RobotSpec bench();
RobotSpec arm_3r();
RobotSpec arm_6r();
RobotSpec orthoglide();
RobotSpec frame();  // a plate on a tube that is bolted to a wall
// Trial robots: nothing in the product was tuned on them.
RobotSpec scara();
RobotSpec arm_7r();
RobotSpec gantry();  // three slides, the bridge a beam
RobotSpec planar_3rrr();
RobotSpec hexapod();  // six legs, universal joint, drive, spherical joint
RobotSpec delta();    // arms that turn, each with one rod between universal joints

/// Throws std::invalid_argument when there is none.
RobotSpec robot_named(const std::string& name);

/// Coordinates of every chain, then the platform's pose when nothing is loaded.
struct Posture {
  std::vector<Eigen::VectorXd> q;
  Pose platform;
};
/// Posture of a serial robot.
Posture posture_of(const RobotSpec& robot, const Eigen::VectorXd& q);
/// Posture of any robot, platform parallel to the base, by Gauss and Newton from home. Throws
/// std::runtime_error out of reach.
Posture posture_at(const RobotSpec& robot, const Vector3& point);

/// A robot built in a posture, unloaded as far as it was not built with errors.
struct Built {
  Structure structure;
  Mark platform;
  std::map<std::string, int> joints;                     // place of an actuator -> its coupling
  std::map<std::string, std::vector<int>> links;         // place -> couplings of its elements
  std::map<std::string, std::vector<int>> beams_bodies;  // place -> bodies along it
  std::map<std::string, Mark> link_starts;
  std::vector<int> mounts, ends;  // coupling of each chain to the ground, and to the platform
};

struct BuildOptions {
  std::vector<double> factors;  // on the stiffness of each of springs(); empty: 1
  int elements = 8;             // of a beam
  double rigid = 1;             // factor on the stiff directions that hold joints
};

Built build(const RobotSpec& robot, const Posture& posture, const BuildOptions& options);

/// The robot file that the product is shown. `factors` on its stiffnesses: what is believed.
std::string robot_file(const RobotSpec& robot, const std::vector<double>& believed);

}  // namespace twin

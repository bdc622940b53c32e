// A serial chain of the virtual joint method: joints, links with springs, tool.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "kinetostat/spatial/pose.h"
#include "kinetostat/spatial/stiffness.h"

namespace kinetostat::vjm {

/// Elementary motion along or about an axis of the moving frame.
enum class Motion { tx, ty, tz, rx, ry, rz };

inline constexpr Motion all_motions[] = {Motion::tx, Motion::ty, Motion::tz,
                                         Motion::rx, Motion::ry, Motion::rz};
inline bool is_rotation(Motion motion) { return motion >= Motion::rx; }
/// 0, 1, 2 for x, y, z.
inline int axis_index(Motion motion) { return static_cast<int>(motion) % 3; }
/// "Tx" ... "Rz".
std::string to_string(Motion motion);

/// Who decides the value of a coordinate.
enum class Role {
  actuated,  // the controller: a command, to which the joint's spring (if any) adds its deflection
  passive,   // nobody, or a spring with a given rest value
  elastic    // a virtual spring of a link; rest value 0
};

/// One generalised coordinate x_k of a chain [m or rad].
struct Coordinate {
  std::string name;  // "rho", "u1.Rz", "leg.Ty"
  Role role = Role::passive;
  Motion motion = Motion::tx;
  double home = 0;  // where the search for a posture starts
  /// Where its command may lie, least and largest; none: not stated.
  std::optional<std::array<double, 2>> range = {};
};

/// A linear spring over one coordinate, or over the six of a link: force = -stiffness (x - rest).
/// For an actuated coordinate the rest value is the command and comes with the posture.
struct Spring {
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;

  std::string name;
  Eigen::Index first = 0;  // first coordinate; the others follow
  Matrix stiffness;        // symmetric positive definite
  double series = 0;       // of a single coordinate: compliance in series that scaling leaves alone
};

/// A force on one coordinate beside the linear springs: a stop, a gap, a hardening spring.
/// Immutable.
class CoordinateLaw {
 public:
  struct JointState {
    double position = 0;    // x [m or rad]
    double deflection = 0;  // x from its rest value: the command, where actuated
    double stiffness = 0;   // of the linear spring beside the law [N/m or N m/rad]
    double travel = 0;      // x from the command itself, wherever the drive leads it (RestShift)
  };
  struct Value {
    double energy = 0;   // [J]
    double force = 0;    // derivative of the energy: what the law resists with [N or N m]
    double tangent = 0;  // derivative of the force with respect to x
    double force_by_stiffness = 0;  // derivative of the force with respect to JointState::stiffness
  };
  virtual ~CoordinateLaw() = default;
  virtual Value at(const JointState& joint) const = 0;
  /// The law sits between the two bodies of the joint (a stop, friction), not in the drive: it does
  /// not change with the rest value when the joint stands still.
  virtual bool is_beside_drive() const { return false; }
  /// Whether the force bends within a step from a state so that its tangent there says little of
  /// where the step ends. `step` [m or rad] may be made shorter: to where the force is steep, when
  /// it is flat on both sides of that.
  virtual bool kinks(const JointState& /*from*/, double& /*step*/) const { return false; }
};

/// A joint that may move freely between two stops and meets a contact spring beyond them.
class StopLaw : public CoordinateLaw {
 public:
  /// Bounds [m or rad], contact stiffness [N/m or N m/rad]. Throws std::invalid_argument unless
  /// lower < upper and the stiffness is positive.
  StopLaw(double lower, double upper, double stiffness);
  Value at(const JointState& joint) const override;
  bool is_beside_drive() const override { return true; }

  /// Between the stops, or at the only one.
  double middle() const;
  double stiffness() const { return stiffness_; }

 private:
  double lower_, upper_, stiffness_;
};

/// A drive that leads its joint elsewhere than commanded: to u + shift + cosine cos(order u) +
/// sine sin(order u) for the command u [m or rad].
struct TransmissionError {
  Eigen::Index coordinate = 0;
  double shift = 0, cosine = 0, sine = 0, order = 0;

  double at(double command) const;
};

/// A small displacement [translation; rotation vector] of everything behind a place of a chain, by
/// which the built chain differs from the nominal one. Those at one place add up, so that their
/// order does not matter.
struct ChainDisplacement {
  std::string place;        // "base", "end", or an element: right behind it
  bool in_front = false;    // of the element's own motion instead: where its rigid part ends
  Eigen::Index joints = 0;  // that lead to the place
  spatial::Vector6 value = spatial::Vector6::Zero();  // in the axes of the place [m; rad]
};

/// A point that moves with the chain: position [m] in the frame that the first `joints` joints have
/// led to.
struct Node {
  std::string name;
  Eigen::Index joints = 0;
  spatial::Vector3 position = spatial::Vector3::Zero();
};

/// A mass [kg] at a node, of a link or of a mass that stands alone; empty where an effect put it.
struct PointMass {
  std::size_t node = 0;
  double mass = 0;
  std::string element = {};
};

/// One elementary joint in the product of transformations: `before`, then `motion` by
/// factor * x[coordinate]. Several joints may share a coordinate (a parallelogram, JAMRIS09 eq.
/// 22).
struct Joint {
  spatial::Pose before;          // with the geometric errors
  spatial::Pose nominal_before;  // without
  bool before_is_identity = true;
  Motion motion = Motion::tx;
  Eigen::Index coordinate = 0;
  double factor = 1;  // [1, or m/rad where a turn slides, rad/m where a slide turns]
};

/// Constant description of a chain, built from base to end in the order of JAMRIS09 eq. 1:
///
///     Chain chain("x", base);
///     chain.actuator("rho", Motion::tx, 1e8).link("foot", offset, spring).passive("u1.Rz",
///     Motion::rz);
///
/// Everything is given in the local frame that the elements before have led to. Builders throw
/// std::invalid_argument on non-positive stiffness, names used twice and unknown names.
class Chain {
 public:
  explicit Chain(std::string name, const spatial::Pose& base = {});

  /// A constant offset: a rigid link, a flange, a tool.
  Chain& offset(const spatial::Pose& pose);
  /// An actuated joint. Stiffness [N/m or N m/rad]; none: it holds its command rigidly.
  Chain& actuator(const std::string& name, Motion motion, std::optional<double> stiffness,
                  double home = 0);
  /// Where the command of an actuated joint may lie [m or rad].
  Chain& range(const std::string& name, double least, double largest);
  /// A perfect passive joint.
  Chain& passive(const std::string& name, Motion motion, double home = 0);
  /// A passive joint with a spring that is relaxed at `rest` [m or rad] (MMT11 eq. 2).
  Chain& passive(const std::string& name, Motion motion, double stiffness, double rest,
                 double home);
  /// A further joint that moves by `factor` times the coordinate of an earlier actuated or passive
  /// one. One may turn and the other slide, as in a screw or a rack: the factor is then in m/rad,
  /// or in rad/m.
  Chain& coupled(const std::string& name, Motion motion, double factor);
  /// A flexible link: `offset` to its end, then the virtual joint Tx Ty Tz Rx Ry Rz there
  /// (JAMRIS09 eq. 1). The compliance is taken at the link's end in the axes of the end frame; its
  /// own frame() is ignored: bring it there with Compliance6::in.
  Chain& link(const std::string& name, const spatial::Pose& offset,
              const spatial::Compliance6& compliance);

  /// A geometric error: an offset that the built chain has and the nominal one has not. Postures
  /// are found for the nominal chain (without_errors()).
  Chain& error(const spatial::Pose& pose);
  /// A further law on an earlier actuated or passive joint.
  Chain& law(const std::string& name, std::shared_ptr<const CoordinateLaw> law);
  /// A named point here, for loads; throws when the name is taken.
  Chain& node(const std::string& name, const spatial::Vector3& position = spatial::Vector3::Zero());
  /// A mass here, at a position in the current frame. `element`: the link that it is a part of;
  /// empty: it stands alone, under its own name.
  Chain& mass(const std::string& name, double mass, const spatial::Vector3& position,
              const std::string& element = {});
  /// The chain ends here; `to_reference` leads on to the reference point of the body that it ends
  /// on. Errors and displacements of the "end" are those of the chain, in front of that.
  Chain& attach(const spatial::Pose& to_reference);

  /// Changes of a built chain by effects. `element` is "base", "end", a joint or a link; all throw
  /// std::invalid_argument for another name.
  ///
  /// A compliance in series with the spring of a joint; several add up.
  Chain& add_series_compliance(const std::string& joint, double compliance);
  /// A spring of this compliance right behind an element, in its axes, named `name`; a second one
  /// of the name is in series with the first. Coordinates are appended, so that postures of the
  /// chain without it stay good. Where the compliance is lost in the rounding of the stiffest
  /// spring nothing is inserted.
  Chain& add_compliance_behind(const std::string& element, const std::string& name, Motion motion,
                               double compliance);
  Chain& add_displacement(const std::string& element, bool in_front,
                          const spatial::Vector6& displacement);
  Chain& add_transmission_error(const TransmissionError& shift);
  /// A mass [kg] in the frame that the first `joints` joints lead to.
  Chain& add_mass(const std::string& name, double mass, Eigen::Index joints,
                  const spatial::Vector3& position);

  const std::string& name() const { return name_; }
  const spatial::Pose& base() const { return base_; }  // where the chain starts
  const std::vector<Coordinate>& coordinates() const { return coordinates_; }
  const std::vector<Joint>& joints() const { return joints_; }
  const std::vector<Spring>& springs() const { return springs_; }
  const spatial::Pose& tail() const { return tail_; }  // after the last joint, to the reference
  const spatial::Pose& attachment() const { return attachment_; }  // its part on the body
  const std::vector<Node>& nodes() const { return nodes_; }
  /// Their numbers, nearest the base first.
  const std::vector<std::size_t>& nodes_by_joints() const { return nodes_by_joints_; }
  const std::vector<PointMass>& masses() const { return masses_; }
  /// Laws beside the springs, with the coordinate that each acts on.
  const std::vector<std::pair<Eigen::Index, std::shared_ptr<const CoordinateLaw>>>& laws() const {
    return laws_;
  }
  const std::vector<ChainDisplacement>& displacements() const { return displacements_; }
  const std::vector<TransmissionError>& transmission_errors() const { return transmission_errors_; }
  Eigen::Index size() const { return static_cast<Eigen::Index>(coordinates_.size()); }

  /// How many joints lead to the frame right behind an element.
  Eigen::Index joints_to(const std::string& element) const;
  /// The first elementary joint of a joint or link: the rigid part before it ends there.
  Eigen::Index first_joint_of(const std::string& element) const;
  bool has_coordinate(const std::string& name) const;
  /// Rest values that a vector of commands leads to.
  Eigen::VectorXd rest_for(const Eigen::VectorXd& commands) const;
  /// Index of a node. Throws std::invalid_argument with did-you-mean.
  std::size_t node_index(const std::string& node) const;
  /// Index of a coordinate. Throws std::invalid_argument with did-you-mean.
  Eigen::Index index_of(const std::string& coordinate) const;
  /// The springs' stiffness as one size() x size() matrix (zero rows for coordinates without).
  const Eigen::MatrixXd& stiffness() const { return stiffness_; }
  /// The value of a law at coordinates x with these deflections from rest.
  CoordinateLaw::Value value_of(Eigen::Index coordinate, const CoordinateLaw& law,
                                const Eigen::VectorXd& x, const Eigen::VectorXd& deflection,
                                const Eigen::VectorXd& travel) const {
    return law.at({x[coordinate], deflection[coordinate], stiffness_(coordinate, coordinate),
                   travel[coordinate]});
  }
  /// Coordinates that move in equilibrium: all but actuated joints without a spring.
  const std::vector<Eigen::Index>& free_coordinates() const { return free_; }
  /// Coordinates that a posture chooses: actuated and passive.
  const std::vector<Eigen::Index>& posture_coordinates() const { return posture_; }
  /// Rest values: given ones for passive springs, 0 for links and (to be overwritten by the
  /// posture) for actuators.
  const Eigen::VectorXd& default_rest() const { return rest_; }
  Eigen::VectorXd home() const;

  bool has_errors() const { return has_errors_; }
  Chain without_errors() const;

  /// The same chain with a spring's stiffness multiplied; compliances in series with it stay what
  /// they are. Throws std::invalid_argument for an
  /// unknown spring, or a factor that is not positive.
  Chain with_scaled_spring(const std::string& spring, double factor) const;

 private:
  Eigen::Index add_coordinate(const Coordinate& coordinate);
  void add_joint(Motion motion, Eigen::Index coordinate, double factor);
  void add_spring(const std::string& name, Eigen::Index first, const Spring::Matrix& stiffness);

  Eigen::Index add_elastic(const std::string& name, Motion motion, double compliance);
  void add_node(const Node& node);
  void insert_joint(Eigen::Index joints, Motion motion, Eigen::Index coordinate);
  void move_place(const ChainDisplacement& place, const spatial::Pose& change);
  ChainDisplacement& displacement_at(const std::string& element, bool in_front);

  std::string name_;
  spatial::Pose base_;
  std::vector<Coordinate> coordinates_;
  std::vector<Joint> joints_;
  std::vector<Spring> springs_;
  spatial::Pose tail_, nominal_tail_, attachment_;
  bool has_errors_ = false;
  std::vector<ChainDisplacement> displacements_;
  std::vector<TransmissionError> transmission_errors_;
  std::vector<Node> nodes_;
  std::vector<std::size_t> nodes_by_joints_;
  std::vector<PointMass> masses_;
  std::vector<std::pair<Eigen::Index, std::shared_ptr<const CoordinateLaw>>> laws_;
  Eigen::MatrixXd stiffness_;
  Eigen::VectorXd rest_;
  std::vector<Eigen::Index> free_, posture_;
};

}  // namespace kinetostat::vjm

// A serial chain of the virtual joint method: joints, links with springs, tool.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "kinetostat/spatial/pose.h"
#include "kinetostat/vjm/chain/coordinate.h"
#include "kinetostat/vjm/chain/coordinate_law.h"

namespace kinetostat::vjm {

/// A drive that leads its joint elsewhere than commanded: to u + shift + cosine cos(order u) +
/// sine sin(order u) + ratio (v - from) for its command u and the command v of `leader` [m or rad].
struct TransmissionError {
  Eigen::Index coordinate = 0;
  double shift = 0, cosine = 0, sine = 0, order = 0;
  Eigen::Index leader = 0;
  double ratio = 0, from = 0;

  /// `commands`: of all coordinates of the chain.
  double at(const Eigen::VectorXd& commands) const;
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
/// led to, and axes there.
struct Node {
  std::string name;
  Eigen::Index joints = 0;
  spatial::Vector3 position = spatial::Vector3::Zero();
  spatial::Matrix3 axes = spatial::Matrix3::Identity();
};

/// A mass [kg] at a node, of a link or of a mass that stands alone; empty where an effect put it.
struct PointMass {
  std::size_t node = 0;
  double mass = 0;
  std::string element = {};
  /// [kg m^2] in the axes of the frame that the joints of the node lead to: of a mass that stands
  /// alone about its node, of a half of a part of a link half that of the part about the middle
  /// between both halves. Zero: none is given.
  spatial::Matrix3 inertia = spatial::Matrix3::Zero();
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

/// A chain from its base to its end, in the order of JAMRIS09 eq. 1. Immutable: ChainBuilder makes
/// one, ChainModifier another from it.
class Chain {
 public:
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
  /// The same into a vector that is kept.
  void find_rest(const Eigen::VectorXd& commands, Eigen::VectorXd& rest) const;
  /// Index of a node. Throws std::invalid_argument with did-you-mean.
  std::size_t node_index(const std::string& node) const;
  /// Index of a coordinate. Throws std::invalid_argument with did-you-mean.
  Eigen::Index index_of(const std::string& coordinate) const;
  /// The springs' stiffness as one size() x size() matrix (zero rows for coordinates without).
  const Eigen::MatrixXd& stiffness() const { return stiffness_; }
  /// What a law on a coordinate is a function of.
  CoordinateLaw::JointState joint_state(Eigen::Index coordinate, const Eigen::VectorXd& x,
                                        const Eigen::VectorXd& deflection,
                                        const Eigen::VectorXd& travel) const {
    return {x[coordinate], deflection[coordinate], stiffness_(coordinate, coordinate),
            travel[coordinate]};
  }
  /// The value of a law at coordinates x with these deflections from rest.
  CoordinateLaw::Value value_of(Eigen::Index coordinate, const CoordinateLaw& law,
                                const Eigen::VectorXd& x, const Eigen::VectorXd& deflection,
                                const Eigen::VectorXd& travel) const {
    return law.at(joint_state(coordinate, x, deflection, travel));
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

 private:
  friend class ChainBuilder;
  friend class ChainModifier;
  Chain(std::string name, const spatial::Pose& base);

  Eigen::Index add_coordinate(const Coordinate& coordinate);
  void add_joint(Motion motion, Eigen::Index coordinate, double factor);
  void add_spring(const std::string& name, Eigen::Index first, const Spring::Matrix& stiffness);
  void add_node(const Node& node);
  /// Throws when the name of the node or mass is taken, or the mass negative.
  void add_node_at_end(const std::string& name, const spatial::Vector3& position);
  void add_mass_at_end(const std::string& name, double mass, const spatial::Vector3& position,
                       const std::string& element,
                       const spatial::Matrix3& inertia = spatial::Matrix3::Zero());

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

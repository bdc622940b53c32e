// Laws of force on a coordinate of a chain.
#pragma once

namespace kinetostat::vjm {

/// A force on one coordinate beside the linear springs: a stop, a gap, a hardening spring.
/// Immutable.
class CoordinateLaw {
 public:
  struct JointState {
    double position = 0;    // x [m or rad]
    double deflection = 0;  // x from its rest value: the command, where actuated
    double stiffness = 0;   // of the linear spring beside the law [N/m or N m/rad]
    double travel =
        0;  // x from the command itself, wherever the drive leads it (TransmissionError)
  };
  struct Value {
    double force = 0;    // derivative of the energy: what the law resists with [N or N m]
    double tangent = 0;  // derivative of the force with respect to x
    double force_by_stiffness = 0;  // derivative of the force with respect to JointState::stiffness
  };
  virtual ~CoordinateLaw() = default;
  virtual Value at(const JointState& joint) const = 0;
  /// [J]; reported, not solved with.
  virtual double energy(const JointState& joint) const = 0;
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
  double energy(const JointState& joint) const override;
  bool is_beside_drive() const override { return true; }

  /// Between the stops, or at the only one.
  double middle() const;
  double stiffness() const { return stiffness_; }

 private:
  double beyond(double x) const;

  double lower_, upper_, stiffness_;
};

}  // namespace kinetostat::vjm

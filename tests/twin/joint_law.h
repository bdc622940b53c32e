// Force of a joint against its deflection: smooth forms, on purpose other ones than the product's.
#pragma once

#include <memory>
#include <vector>

namespace twin {

struct Reaction {
  double force, tangent;  // [N or N m], [N/m or N m/rad]
};

/// Force with which a joint resists its deflection d [m or rad]. May remember its past.
class JointLaw {
 public:
  virtual ~JointLaw() = default;
  virtual Reaction at(double d) const = 0;
  /// d is where a load step ended; `seconds` have passed since the step before.
  virtual void accept(double d, double seconds) {
    (void)d;
    (void)seconds;
  }
};

using JointLawPointer = std::shared_ptr<JointLaw>;

/// k d.
JointLawPointer linear_law(double k);
/// k d0 sinh(d / d0): all odd powers.
JointLawPointer hardening_law(double k, double d0);
/// Play: soft contact k w [log(1 + e^((d-g)/w)) - log(1 + e^(-(d+g)/w))] with w = 0.15 g.
JointLawPointer clearance_law(double k, double gap);
/// Slope k up to deflection d1, ratio k beyond, turned over a fifth of d1 by a logistic curve.
JointLawPointer two_slope_law(double k, double ratio, double d1);
/// Slope k up to deflection d1, k / (1 + looser) beyond, on that side only: a bolt that opens.
/// Turned over a fifth of d1 by a logistic curve.
JointLawPointer lifting_law(double k, double looser, double d1);
/// k (d - slack), the slack creeping by two Kelvin elements of compliance c/2 each, with
/// relaxation times tau/2 and 3 tau/2.
JointLawPointer creep_law(double k, double c, double tau);
/// Bouc-Wen friction beside another law: F z with dz/dd = [1 - |z|^1.5 (0.6 sgn(z dd) + 0.4)] / s.
JointLawPointer friction_law(JointLawPointer beside, double force, double s);
/// Dahl's friction beside another law: F z with dz/dd = (1 - z sgn(dd)) / s.
JointLawPointer dahl_law(JointLawPointer beside, double force, double s);
/// Dahl's friction whose limit is a share of the force of the law beside it: a gear's efficiency.
JointLawPointer gear_loss_law(JointLawPointer beside, double share, double s);
/// A strain-wave gear: k [d + (ratio - 1) (d - d0 atan(d / d0))], softest in the middle.
JointLawPointer arctangent_law(double k, double ratio, double d0);
/// A position loop without integrator whose droop grows with the root of the load: the deflection d
/// is e + droop sqrt(d0) e / (e^2 + (d0/20)^2)^(1/4), force k e. In no catalogue of the product.
JointLawPointer servo_droop_law(double k, double droop, double d0);

}  // namespace twin

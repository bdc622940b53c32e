// Physical effects: named terms of the equations of equilibrium beside springs and weights.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/spatial/units.h"
#include "kinetostat/vjm/equilibrium.h"
#include "kinetostat/vjm/kinematics.h"

namespace kinetostat::vjm {

/// What an effect acts on.
enum class EffectPlace { joint, link, platform };

/// One number of an effect; SI inside.
struct EffectParameter {
  std::string name;
  spatial::Dimension linear, angular;  // on a joint that slides (or no joint), on one that turns
  double lower = 0, upper = 0;         // physical range, in SI; the value must lie in it
  double prior_sd = 0;                 // how large it usually is, in SI; 0: nothing is claimed
  double none = 0;                     // the value at which there is no effect
  bool required = true;                // otherwise `none` when not given
};

/// The state at which an effect is differentiated.
struct EffectState {
  const Chain& chain;                 // with all effects applied
  const Eigen::VectorXd& x;           // all coordinates [m or rad]
  const Eigen::VectorXd& deflection;  // the same from their rest values
  const ChainKinematics& kinematics;
  spatial::Vector3 gravity;  // [m/s^2], base axes, as far as it acts
};

/// A kind of effect: one file in vjm/effects/, listed in effect_kinds().
struct EffectKind {
  std::string name;
  std::string summary;    // one line
  std::string law;        // the formula
  std::string source;     // where it comes from
  std::string signature;  // how it shows in measurements
  std::string confuser;   // the effect that looks most like it
  EffectPlace place = EffectPlace::joint;
  std::vector<EffectParameter> parameters;
  /// The chain with the effect at `element` (joint or link; empty for the platform), values in the
  /// order of `parameters`. Throws std::invalid_argument when it cannot act there.
  Chain (*applied)(const Chain& chain, const std::string& element, const Eigen::VectorXd& values);
  /// Derivative of the generalised forces on all coordinates [N or N m], one column per parameter.
  /// Exact.
  Eigen::MatrixXd (*force_derivatives)(const EffectState& state, const std::string& element,
                                       const Eigen::VectorXd& values);
};

/// The catalogue. Its order is that in which effects of one robot are applied, whatever the order
/// in which they are given: changes of springs first.
const std::vector<EffectKind>& effect_kinds();
/// Throws std::invalid_argument with did-you-mean.
const EffectKind& effect_kind(const std::string& name);
std::string to_string(EffectPlace place);

/// An effect at a place, with its values [SI] in the order of the kind's parameters.
struct Effect {
  const EffectKind* kind = nullptr;
  std::size_t chain = 0;
  std::string element;
  Eigen::VectorXd values;
  Eigen::VectorXd deviations = {};  // their standard deviations; NaN where not stated

  std::string place(const Manipulator& manipulator) const;  // "x.rho", "platform"
};

/// The manipulator with the effects in its equations of equilibrium. The same in whatever order
/// they are given. Throws std::invalid_argument when one cannot act where it is put.
Manipulator with_effects(const Manipulator& manipulator, const std::vector<Effect>& effects);

/// Derivatives of the platform displacement [m; rad] (base axes) at an equilibrium of
/// with_effects(...) under `load` with respect to every value of every effect, in their order, by
/// implicit differentiation of the equations of equilibrium: one column each.
Matrix6X displacement_by_effects(const Manipulator& with_effects, const Posture& posture,
                                 const Load& load, const Equilibrium& equilibrium,
                                 const std::vector<Effect>& effects);

}  // namespace kinetostat::vjm

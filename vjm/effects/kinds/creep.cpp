// A joint goes on yielding under a load that stays.
#include <cmath>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace creep_kind {
namespace {

enum Value { c, tau, settled };
// [m or rad]; force in the drive at the reading before, and the one that had acted for long before
// the cycle [N or N m].
enum History { crept, load, weight };
constexpr Eigen::Index before = settled + 1;  // where the history stands among the inputs
constexpr Eigen::Index inputs = before + 3;

// What the weight of a cycle's posture has moved is a part of where the cycle starts.
bool settles(const EffectInput& input) {
  return input.values[settled] > 0.5 && input.conditions.unloaded;
}

// What has crept since the reading before, whose load acted until shortly before this one.
struct Step {
  double left, crept_now;

  explicit Step(const EffectInput& input)
      : left(std::exp(-input.conditions.elapsed / input.values[tau])),
        crept_now(left * input.history[crept] +
                  (1 - left) * input.values[c] * (input.history[load] - input.history[weight])) {}
  // Derivatives by values and history.
  using Gradient = Eigen::Matrix<double, inputs, 1>;
  Gradient gradient(const EffectInput& input) const {
    const double t = input.values[tau], acts = input.history[load] - input.history[weight];
    const double left_by_tau = left * input.conditions.elapsed / (t * t);
    Gradient by_input = Gradient::Zero();
    by_input[c] = (1 - left) * acts;
    by_input[tau] = left_by_tau * (input.history[crept] - input.values[c] * acts);
    by_input[before + crept] = left;
    by_input[before + load] = (1 - left) * input.values[c];
    by_input[before + weight] = -by_input[before + load];
    return by_input;
  }
};

class Creep : public EffectKind {
 public:
  Creep() {
    name = "creep";
    effect_class = EffectClass::time;
    summary = "a joint goes on yielding under a load that stays";
    law =
        "the rest value moves by q, tau dq/dt + q = c F with the drive's force F, or c (F - F0) "
        "with settled = 1, F0 where the cycle starts; the load of a reading acts until shortly "
        "before the next one in its cycle";
    source =
        "standard linear solid: Findley, Lai and Onaran, Creep and Relaxation of Nonlinear "
        "Viscoelastic Materials, 1976, ch. 5";
    signature = "displacement grows with time under load and returns slowly after it";
    confuser =
        "load_friction and friction, where times are short; session_drift, which knows no load";
    place = EffectPlace::joint;
    acts_on_joint_alone = true;
    varies = true;
    history = 3;
    parameters = {{.name = "c",
                   .linear = compliance::linear,
                   .angular = compliance::angular,
                   .lower = 0,
                   .upper = 1,
                   .prior_sd = 0.1,
                   .prior_unit = PriorUnit::compliance},
                  {.name = "tau",
                   .linear = spatial::dimension::time,
                   .angular = spatial::dimension::time,
                   .lower = 1e-3,
                   .upper = 1e8,
                   .prior_sd = 600,
                   .is_shape = true},
                  settled_weight()};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    spring_of_joint(modifier.chain(), joint);
    if (settles(input)) return;
    modifier.add_transmission_error(
        {.coordinate = modifier.chain().index_of(joint), .shift = Step(input).crept_now});
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput& input) const override {
    if (settles(input)) return;
    const Step::Gradient gradient = Step(input).gradient(input);
    const Eigen::Index k = columns.state().chain.index_of(joint);
    for (Eigen::Index i = 0; i < inputs; ++i) columns.add_transmission_error(i, k, gradient[i]);
  }

  // The drive's force is a function of the deflection x - command - shift.
  void advance(const ChainState& state, const std::string& joint, const EffectInput& input,
               HistoryStep& step) const override {
    const Eigen::Index k = state.chain.index_of(joint);
    const double force = state.drive_force(k);
    const Step now(input);
    const bool starts = settles(input);
    step.start(starts ? Eigen::Vector3d(0, force, force)
                      : Eigen::Vector3d(now.crept_now, force, input.history[weight]),
               state.chain.size(), inputs);
    step.by_coordinates(load, k) = state.drive_stiffness(k);
    step.by_drive_force[load] = 1;
    if (starts) {
      step.by_coordinates(weight, k) = step.by_coordinates(load, k);
      step.by_drive_force[weight] = 1;
    } else {
      step.by_input.row(crept) = now.gradient(input).transpose();
      step.by_input(weight, before + weight) = 1;
    }
  }
};

}  // namespace
}  // namespace creep_kind

Kind creep() { return std::make_shared<creep_kind::Creep>(); }

}  // namespace kinetostat::vjm::effects

// Joints whose stiffness is not the same everywhere or always: it ripples with teeth, changes along
// a screw or a telescope, or falls with temperature.
#include <cmath>
#include <functional>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

// Factor of a joint's stiffness and its derivatives by the values of an effect.
struct Factor {
  double value = 1;
  Eigen::Vector3d by_values = Eigen::Vector3d::Zero();
};

// F = (s - 1) k d beside the spring k d, s depending on the command u and nothing that moves in
// equilibrium.
class ScaledLaw : public CoordinateLaw {
 public:
  explicit ScaledLaw(std::function<double(double)> scale) : scale_(std::move(scale)) {}
  Value at(const JointState& joint) const override {
    const double more = this->more(joint), d = joint.deflection;
    return {.force = more * joint.stiffness * d,
            .tangent = more * joint.stiffness,
            .force_by_stiffness = more * d};
  }
  double energy(const JointState& joint) const override {
    return more(joint) * joint.stiffness * joint.deflection * joint.deflection / 2;
  }

 private:
  double more(const JointState& joint) const { return scale_(joint.position - joint.travel) - 1; }

  std::function<double(double)> scale_;
};

class VaryingStiffness : public EffectKind {
 public:
  VaryingStiffness() {
    place = EffectPlace::joint;
    acts_on_joint_alone = true;
    effect_class = EffectClass::varying;
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    const Chain& chain = modifier.chain();
    spring_of_joint(chain, joint);
    const double home = home_of(chain, chain.index_of(joint));
    modifier.add_law(
        joint, std::make_shared<ScaledLaw>([this, values = input.values, home](double command) {
          return factor(values, command - home).value;
        }));
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput& input) const override {
    const ChainState& state = columns.state();
    const Spring& spring = spring_of_joint(state.chain, joint);
    const Eigen::Index k = spring.first;
    const double command = state.x[k] - state.travel[k];
    const Factor s = factor(input.values, command - home_of(state.chain, k));
    for (Eigen::Index v = 0; v < input.values.size(); ++v)
      columns.add_drive_force(v, k, -spring.stiffness(0, 0) * state.deflection[k] * s.by_values[v]);
  }

 protected:
  /// Of the stiffness, at a command [m or rad] counted from the joint's home.
  virtual Factor factor(const Eigen::VectorXd& values, double command) const = 0;
};

class PeriodicStiffness : public VaryingStiffness {
 public:
  PeriodicStiffness() {
    const auto amplitude = [](const char* called) {
      return EffectParameter{.name = called,
                             .linear = spatial::dimension::none,
                             .angular = spatial::dimension::none,
                             .lower = -0.6,
                             .upper = 0.6,
                             .prior_sd = 0.1,
                             .required = false};
    };
    name = "periodic_stiffness";
    summary = "a joint whose compliance ripples with its angle or travel: teeth, flexsplines, cams";
    law =
        "1/k(u) = (1 + cosine cos(order v) + sine sin(order v)) / k, v the command from the "
        "joint's home";
    source =
        "time-varying mesh stiffness: ISO 6336-1; Tuttle and Seering, A nonlinear model of a "
        "harmonic drive gear transmission, IEEE Trans. Robot. Autom. 12 (1996) 368";
    signature = "deflections in proportion to the load, periodic in the joint's command";
    confuser = "eccentricity, which is there without load; stiffness_along_joint";
    least_commands =
        4;  // its two amplitudes, the stiffness itself, and one to see whether it is so
    parameters = {amplitude("cosine"), amplitude("sine"), order_of_ripple({1, 2})};
  }

 protected:
  Factor factor(const Eigen::VectorXd& values, double v) const override {
    const double c = std::cos(values[2] * v), s = std::sin(values[2] * v);
    const double scale = 1 / (1 + values[0] * c + values[1] * s);
    return {scale, -scale * scale * Eigen::Vector3d(c, s, v * (values[1] * c - values[0] * s))};
  }
};

class StiffnessAlongJoint : public VaryingStiffness {
 public:
  StiffnessAlongJoint() {
    name = "stiffness_along_joint";
    summary = "a joint that grows softer or stiffer along its travel: a ball screw, a telescope";
    law = "k(u) = k exp(-rate v), v the command from the joint's home";
    source = "to first order the axial compliance of a ball screw with its free length: ISO 3408-4";
    signature = "deflections in proportion to the load, larger at one end of the joint's travel";
    confuser =
        "periodic_stiffness of a long period; link_compliance or base_compliance, at few postures";
    least_commands = 2;
    parameters = {{.name = "rate",
                   .linear = {.length = -1},
                   .angular = {.angle = -1},
                   .lower = -1e3,
                   .upper = 1e3,
                   .prior_sd = 0.3,
                   .prior_unit = PriorUnit::per_joint_span}};
  }

 protected:
  Factor factor(const Eigen::VectorXd& values, double v) const override {
    const double scale = std::exp(-values[0] * v);
    return {scale, {-v * scale, 0, 0}};
  }
};

class ThermalSoftening : public EffectKind {
 public:
  ThermalSoftening() {
    name = "thermal_softening";
    effect_class = EffectClass::varying;
    place = EffectPlace::joint;
    acts_on_joint_alone = true;
    varies = true;
    summary = "a joint whose stiffness falls with its temperature";
    law =
        "k(T') = k exp(-rate (T' - reference)), lag dT'/dt + T' = T for the temperature T of the "
        "readings";
    source =
        "temperature dependence of elastic moduli: ISO 6721-1; Wachtman et al., Exponential "
        "temperature dependence of Young's modulus, Phys. Rev. 122 (1961) 1754";
    signature = "deflections in proportion to the load, larger when it is warm";
    confuser = "thermal_expansion, which is there without load; creep";
    parameters = {{.name = "rate",
                   .linear = {.temperature = -1},
                   .angular = {.temperature = -1},
                   .lower = -0.1,
                   .upper = 0.1,
                   .prior_sd = 0.005},
                  {.name = "reference",
                   .linear = spatial::dimension::temperature,
                   .angular = spatial::dimension::temperature,
                   .lower = -300,
                   .upper = 2000,
                   .prior_sd = 5,
                   .none = 20,
                   .required = false,
                   .is_shape = true},
                  lag_of_temperature()};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    const std::string spring = spring_of_joint(modifier.chain(), joint).name;
    modifier.scale_spring(spring, std::exp(-input.values[rate] * warming_of(input).above));
  }

  // d(1/k) of the part of the compliance that is scaled.
  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput& input) const override {
    if (!input.conditions.temperature) return;
    const Spring& spring = spring_of_joint(columns.state().chain, joint);
    const double scaled = 1 / spring.stiffness(0, 0) - spring.series;
    const Warming warm = warming_of(input);
    add_series_compliance(columns, rate, spring.first, warm.above * scaled);
    add_series_compliance(columns, reference, spring.first, -input.values[rate] * scaled);
    add_series_compliance(columns, lag_time, spring.first,
                          input.values[rate] * warm.by_lag * scaled);
  }

 private:
  enum Value { rate, reference, lag_time };

  static Warming warming_of(const EffectInput& input) {
    return warming(input.conditions, input.values[reference], input.values[lag_time]);
  }
};

}  // namespace

Kind periodic_stiffness() { return std::make_shared<PeriodicStiffness>(); }
Kind stiffness_along_joint() { return std::make_shared<StiffnessAlongJoint>(); }
Kind thermal_softening() { return std::make_shared<ThermalSoftening>(); }

}  // namespace kinetostat::vjm::effects

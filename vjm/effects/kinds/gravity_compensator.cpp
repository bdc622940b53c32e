// A spring balancer between two links of a robot.
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace gravity_compensator_kind {
namespace {

enum Value { stiffness, arm, distance, free_length, angle };

// The balancer at one joint angle: its length s with s^2 = a^2 + l^2 + 2 a l cos(angle - q).
struct Balancer {
  double a, l, sin, cos, length, stretch;  // stretch: 1 - s0/s

  Balancer(const Eigen::VectorXd& values, double q)
      : a(values[arm]),
        l(values[distance]),
        sin(std::sin(values[angle] - q)),
        cos(std::cos(values[angle] - q)),
        length(std::sqrt(a * a + l * l + 2 * a * l * cos)),
        stretch(1 - values[free_length] / length) {}

  double moment_per_stiffness() const { return a * l * stretch * sin; }
  // Derivative of `stretch` by a change of the length.
  double stretch_by_length(double s0) const { return s0 / (length * length); }
  double tangent_per_stiffness(double s0) const {
    return a * l * (stretch_by_length(s0) * a * l * sin / length * sin - stretch * cos);
  }
};

class BalancerLaw : public CoordinateLaw {
 public:
  explicit BalancerLaw(Eigen::VectorXd values) : values_(std::move(values)) {}
  Value at(const JointState& joint) const override {
    const Balancer b(values_, joint.position);
    const double k = values_[stiffness];
    return {.force = k * b.moment_per_stiffness(),
            .tangent = k * b.tangent_per_stiffness(values_[free_length])};
  }
  double energy(const JointState& joint) const override {
    const double stretched = Balancer(values_, joint.position).length - values_[free_length];
    return 0.5 * values_[stiffness] * stretched * stretched;
  }
  bool is_beside_drive() const override { return true; }

 private:
  Eigen::VectorXd values_;
};

class GravityCompensator : public EffectKind {
 public:
  GravityCompensator() {
    const auto length = [](const char* called, double lower, double upper, double usual) {
      return EffectParameter{.name = called,
                             .linear = spatial::dimension::length,
                             .angular = spatial::dimension::length,
                             .lower = lower,
                             .upper = upper,
                             .prior_sd = usual,
                             .is_shape = true};
    };
    name = "gravity_compensator";
    effect_class = EffectClass::weight;
    moves_like = EffectClass::geometry;
    summary = "a spring balancer about a joint that turns";
    law =
        "M = stiffness (1 - free_length/s) arm distance sin(angle - q), "
        "s^2 = arm^2 + distance^2 + 2 arm distance cos(angle - q)";
    source =
        "Klimchik, Wu, Dumas, Caro, Furet and Pashkevich, Identification of geometrical and "
        "elastostatic parameters of heavy industrial robots, ICRA 2013, eq. 4-6";
    signature = "the stiffness of one joint depends on its angle; an offset that follows the angle";
    confuser = "payload and self_weight, which change with the direction of gravity";
    place = EffectPlace::joint;
    acts_on_joint_alone = true;
    balances_weight = true;
    least_commands = 2;
    parameters = {{.name = "stiffness",
                   .linear = spatial::dimension::linear_stiffness,
                   .angular = spatial::dimension::linear_stiffness,
                   .lower = 0,
                   .upper = 1e9,
                   .prior_sd = 5e4},
                  // Arm and distance differ where both are at a bound.
                  length("arm", 1e-6, 10, 0.2),
                  length("distance", 1e-3, 20, 0.7),
                  length("free_length", 0, 10, 0.5),
                  {.name = "angle",
                   .linear = spatial::dimension::angle,
                   .angular = spatial::dimension::angle,
                   .lower = -6.3,
                   .upper = 6.3,
                   .prior_sd = 1,
                   .required = false,
                   .is_shape = true,
                   .is_phase = true}};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    const Chain& chain = modifier.chain();
    require_mobile(chain, joint);
    if (!is_rotation(chain.coordinates()[static_cast<std::size_t>(chain.index_of(joint))].motion))
      throw std::invalid_argument(
          fmt::format("joint '{}' slides: a balancer acts about a joint that turns", joint));
    if (std::abs(input.values[arm] - input.values[distance]) <
        1e-6 * (input.values[arm] + input.values[distance]))
      throw std::invalid_argument(
          "the arm and the distance of a balancer must differ: its length would be able to vanish");
    modifier.add_law(joint, std::make_shared<BalancerLaw>(input.values));
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput& input) const override {
    const Eigen::Index q = columns.state().chain.index_of(joint);
    const Eigen::VectorXd& v = input.values;
    const Balancer b(v, columns.state().x[q]);
    const double k = v[stiffness], by_length = b.stretch_by_length(v[free_length]);
    const auto add = [&](Eigen::Index value, double moment) {
      columns.add_force(value, q, -moment);
    };
    add(stiffness, b.moment_per_stiffness());
    add(arm, k * b.sin * b.l * (b.stretch + b.a * by_length * (b.a + b.l * b.cos) / b.length));
    add(distance, k * b.sin * b.a * (b.stretch + b.l * by_length * (b.l + b.a * b.cos) / b.length));
    add(free_length, -k * b.a * b.l * b.sin / b.length);
    add(angle, -k * b.tangent_per_stiffness(v[free_length]));
  }
};

}  // namespace
}  // namespace gravity_compensator_kind

Kind gravity_compensator() {
  return std::make_shared<gravity_compensator_kind::GravityCompensator>();
}

}  // namespace kinetostat::vjm::effects

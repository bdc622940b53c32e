// Dry friction in a joint, with hysteresis: it sticks elastically, then slips, at a constant force
// or at a share of the load that the joint transmits.
#include <algorithm>
#include <cmath>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace friction_kind {
namespace {

// What is shorter is taken to be as long [m or rad]: no instrument sees the difference.
constexpr double least_presliding = 1e-9;

enum Value { size, presliding, settled, gradual };
enum History {
  stretch,
  travel
};  // of the bristles over the presliding length; the joint's [m, rad]
constexpr Eigen::Index before = gradual + 1;  // where the history stands among the inputs

// The weight of a cycle's posture is put on without friction, and friction starts from there.
bool settles(const EffectInput& input) {
  return input.values[settled] > 0.5 && input.conditions.unloaded;
}

bool is_gradual(const Eigen::VectorXd& values) { return values[gradual] > 0.5; }

// Share z of the force that acts after a movement u over the presliding length, and its derivatives
// by u and by the share before.
struct Bristles {
  double value = 0, slope = 0, by_start = 0;

  Bristles(bool is_gradual, double start, double u) {
    if (is_gradual)
      bend(start, u);
    else
      stick(start, u);
  }

 private:
  void stick(double start, double u) {
    const Saturation s(start + u);
    value = s.value;
    slope = by_start = s.slope;
  }

  // dz/du = 1 - z on the way up, 1 + z on the way down, and between them where it stands.
  void bend(double start, double u) {
    const double up = u < 0 ? -1 : 1, gone = -std::expm1(-std::abs(u));
    by_start = 1 - gone;
    value = start * by_start + up * gone;
    slope = u == 0 ? 1 : (1 - up * start) * by_start;
  }
};

// The integral of z over u, and the integral of that.
struct BristleWork {
  double once, twice;

  BristleWork(bool is_gradual, double start, double u) {
    if (!is_gradual) {
      const Saturation s(start + u);
      once = s.integral();
      twice = s.second_integral();
      return;
    }
    const double size = std::abs(u), up = u < 0 ? -1 : 1;
    const double gone = -std::expm1(-size);
    once = size + (up * start - 1) * gone;
    twice = up * size * size / 2 + (start - up) * (size - gone);
  }
};

class FrictionLaw : public CoordinateLaw {
 public:
  FrictionLaw(const Eigen::VectorXd& values, const Eigen::VectorXd& history)
      : size_(values[friction_kind::size]),
        length_(std::max(least_presliding, values[presliding])),
        is_gradual_(is_gradual(values)),
        history_(history) {}

  Value at(const JointState& joint) const override {
    const Bristles z = bristles_at(joint.travel);
    return {.force = size_ * z.value, .tangent = size_ / length_ * z.slope};
  }
  double energy(const JointState& joint) const override {
    return size_ * length_ * work_at(joint.travel).once;
  }
  bool is_beside_drive() const override { return true; }
  // From one direction of slipping to the other, through where it sticks; of what gives way
  // gradually, from one direction of moving to the other.
  bool kinks(const JointState& from, double& step) const override {
    const double moved = (from.travel - history_[friction_kind::travel]) / length_;
    const double start = is_gradual_ ? moved : history_[stretch] + moved;
    const double end = start + step / length_, sticks = is_gradual_ ? 0 : 1;
    const auto slips = [&](double u) { return u > sticks ? 1 : u < -sticks ? -1 : 0; };
    if (slips(start) != 0 && start * end < 0) step = -start * length_;
    return slips(start) != slips(end);
  }

 protected:
  Bristles bristles_at(double travel) const { return {is_gradual_, history_[stretch], u(travel)}; }
  BristleWork work_at(double travel) const { return {is_gradual_, history_[stretch], u(travel)}; }
  double u(double travel) const { return (travel - history_[friction_kind::travel]) / length_; }

  double size_, length_;
  bool is_gradual_;
  Eigen::Vector2d history_;
};

// F = loss k |x| z. With du/dx = 1/L its integral over x from 0 is that of x z, L x S - L^2 SS
// with S and SS the integrals of z over u, on either side.
class LoadFrictionLaw : public FrictionLaw {
 public:
  using FrictionLaw::FrictionLaw;

  Value at(const JointState& joint) const override {
    const double x = joint.travel, side = std::copysign(1.0, x);
    const double share = size_ * joint.stiffness;
    const Bristles z = bristles_at(x);
    return {.force = share * std::abs(x) * z.value,
            .tangent = share * (side * z.value + std::abs(x) / length_ * z.slope),
            .force_by_stiffness = size_ * std::abs(x) * z.value};
  }
  double energy(const JointState& joint) const override {
    const double x = joint.travel, side = std::copysign(1.0, x);
    const BristleWork here = work_at(x), relaxed = work_at(0);
    const double integral =
        length_ * x * here.once - length_ * length_ * (here.twice - relaxed.twice);
    return size_ * joint.stiffness * side * integral;
  }
};

// Two kinds of one history; the first of their values is a force, or its share of the load.
class DryFriction : public EffectKind {
 public:
  DryFriction() {
    effect_class = EffectClass::friction;
    place = EffectPlace::joint;
    acts_on_joint_alone = true;
    history = 2;
    parameters = {{},
                  {.name = "presliding",
                   .linear = spatial::dimension::length,
                   .angular = spatial::dimension::angle,
                   .lower = 0,
                   .upper = 0.1,
                   .prior_sd = 0.02,
                   .prior_unit = PriorUnit::joint_play,
                   .is_shape = true},
                  settled_weight(),
                  either_way("gradual", "giving way gradually")};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    require_joint(modifier.chain(), joint);
    if (settles(input)) return;
    modifier.add_law(joint, joint_law(input));
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput& input) const override {
    if (settles(input)) return;
    const Step at(columns.state(), joint, input);
    const double unit = force_of(columns.state(), at.joint);
    const double limit = unit * input.values[size];
    columns.add_force(size, at.joint, -unit * at.z.value);
    columns.add_force(presliding, at.joint, -limit * at.z.slope * at.by_length);
    columns.add_force(before + stretch, at.joint, -limit * at.z.by_start);
    columns.add_force(before + travel, at.joint, limit * at.z.slope / at.length);
  }

  void advance(const ChainState& state, const std::string& joint, const EffectInput& input,
               HistoryStep& step) const override {
    constexpr Eigen::Index inputs = before + 2;
    const Step at(state, joint, input);
    const double stretched = settles(input) ? 0 : at.z.value;
    step.start(Eigen::Vector2d(stretched, state.travel[at.joint]), state.chain.size(), inputs);
    step.by_coordinates(travel, at.joint) = 1;
    if (settles(input)) return;
    step.by_coordinates(stretch, at.joint) = at.z.slope / at.length;
    step.by_input(stretch, presliding) = at.z.slope * at.by_length;
    step.by_input(stretch, before + stretch) = at.z.by_start;
    step.by_input(stretch, before + travel) = -at.z.slope / at.length;
  }

 protected:
  /// Throws std::invalid_argument where it cannot act.
  virtual void require_joint(const Chain& chain, const std::string& joint) const = 0;
  virtual std::shared_ptr<const CoordinateLaw> joint_law(const EffectInput& input) const = 0;
  /// Force at which it slips over the first of the values.
  virtual double force_of(const ChainState& state, Eigen::Index joint) const = 0;

 private:
  // From the reading before to this one.
  struct Step {
    Eigen::Index joint;
    double length, moved, by_length;  // derivative of u by the presliding length
    Bristles z;

    Step(const ChainState& state, const std::string& name, const EffectInput& input)
        : joint(state.chain.index_of(name)),
          length(std::max(least_presliding, input.values[presliding])),
          moved(state.travel[joint] - input.history[friction_kind::travel]),
          by_length(input.values[presliding] < least_presliding ? 0 : -moved / (length * length)),
          z(is_gradual(input.values), input.history[stretch], moved / length) {}
  };
};

class Friction : public DryFriction {
 public:
  Friction() {
    name = "friction";
    summary = "dry friction in a joint, with the hysteresis of a load cycle";
    law =
        "F = force z, z = s(z' + u), u = (x - x') / presliding with z' and x' after the reading "
        "before; s(z) = z while it sticks, +-1 when it slips, rounded over +-0.05 of the "
        "presliding length; with 0 it is Coulomb's. With gradual = 1 it is Dahl's: z = 1 + (z' - "
        "1) exp(-u) on the way up, z = -1 + (z' + 1) exp(u) on the way down. Before a cycle "
        "weight is put on against friction, or with settled = 1 without it";
    source =
        "elasto-plastic friction: Jenkin (1922); Iwan, A distributed-element model for hysteresis, "
        "J. Appl. Mech. 33 (1966) 893, one element. Gradual: Dahl, A solid friction model, "
        "Aerospace Corporation TOR-0158(3107-18)-1 (1968)";
    signature =
        "loading and unloading differ: a loop of 4 force travel a cycle, and an offset after it";
    confuser =
        "clearance, when the load does not reverse; creep, when loading is slower than "
        "unloading";
    parameters[size] = {.name = "force",
                        .linear = spatial::dimension::force,
                        .angular = spatial::dimension::moment,
                        .lower = 0,
                        .upper = 1e7,
                        .prior_sd = 0.1,
                        .prior_unit = PriorUnit::joint_load};
  }

 protected:
  void require_joint(const Chain& chain, const std::string& joint) const override {
    require_mobile(chain, joint);
  }
  std::shared_ptr<const CoordinateLaw> joint_law(const EffectInput& input) const override {
    return std::make_shared<FrictionLaw>(input.values, input.history);
  }
  double force_of(const ChainState&, Eigen::Index) const override { return 1; }
};

class LoadFriction : public DryFriction {
 public:
  LoadFriction() {
    name = "load_friction";
    summary = "dry friction in a joint that grows with the load that it transmits: gears, screws";
    law =
        "F = loss k |x| z, x the deflection by the load, k of the joint's spring, z as of "
        "friction: loops that grow with the load and end at zero";
    source =
        "Hamon, Gautier and Garrec, Dynamic identification of robots with a dry friction model "
        "depending on load and velocity, IROS 2010";
    signature =
        "loading and unloading differ in proportion to the load: another slope for each, and no "
        "offset after a cycle";
    confuser = "friction, whose loop is as wide at small loads; joint_compliance, in one direction";
    parameters[size] = {.name = "loss",
                        .linear = spatial::dimension::none,
                        .angular = spatial::dimension::none,
                        .lower = 0,
                        .upper = 0.9,
                        .prior_sd = 0.1};
  }

 protected:
  void require_joint(const Chain& chain, const std::string& joint) const override {
    require_mobile(chain, joint);
    spring_of_joint(chain, joint);
  }
  std::shared_ptr<const CoordinateLaw> joint_law(const EffectInput& input) const override {
    return std::make_shared<LoadFrictionLaw>(input.values, input.history);
  }
  double force_of(const ChainState& state, Eigen::Index joint) const override {
    return state.chain.stiffness()(joint, joint) * std::abs(state.travel[joint]);
  }
};

}  // namespace
}  // namespace friction_kind

Kind friction() { return std::make_shared<friction_kind::Friction>(); }
Kind load_friction() { return std::make_shared<friction_kind::LoadFriction>(); }

}  // namespace kinetostat::vjm::effects

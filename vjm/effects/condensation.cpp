// Equilibria by static condensation: of a model whose last effect is a law in one joint, from those
// of the model without it.
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/effect_model.h"
#include "kinetostat/vjm/statics/equilibrium_residuals.h"
#include "kinetostat/vjm/statics/equilibrium_state.h"

namespace kinetostat::vjm {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Vector6;

namespace {

// How far a joint is moved to know the rest of the manipulator: an angle [rad], or that times the
// manipulator's length. As far as the rest is smooth: laws in other joints may have narrow corners,
// and a rest that resists, as a closed loop does, is not asked for the farthest.
constexpr std::array ranges = {1e-2, 1e-3, 2e-4, 3e-5};
constexpr double resisting = 0.1;  // share of the stiffness of a joint that is not its own

class PushLaw : public CoordinateLaw {
 public:
  explicit PushLaw(double force) : force_(force) {}
  Value at(const JointState&) const override { return {.force = -force_, .tangent = 0}; }
  double energy(const JointState& joint) const override { return -force_ * joint.position; }

 private:
  double force_;
};

// The force of a joint's own spring and laws against x, and its derivative.
struct OwnForce {
  double value, tangent;

  OwnForce(const Chain& chain, Index k, double x, double rest, double command) {
    const double stiffness = chain.stiffness()(k, k);
    value = stiffness * (x - rest);
    tangent = stiffness;
    for (const auto& [coordinate, law] : chain.laws()) {
      if (coordinate != k) continue;
      const CoordinateLaw::Value more = law->at({x, x - rest, stiffness, x - command});
      value += more.force;
      tangent += more.tangent;
    }
  }
};

// Whether a law elsewhere bends between two states.
bool bends_elsewhere(const EquilibriumSystem& system, const JointPlace& place,
                     const SystemState& from, const SystemState& to) {
  for (std::size_t c = 0; c < system.chains().size(); ++c) {
    const ChainEquations& equations = system.chains()[c];
    for (const auto& [k, law] : equations.chain().laws()) {
      if (JointPlace{c, k} == place) continue;
      const double x = from.coordinates[c][k];
      double step = to.coordinates[c][k] - x;
      if (law->kinks({x, x - equations.rest()[k], equations.chain().stiffness()(k, k),
                      x - equations.commands()[k]},
                     step))
        return true;
    }
  }
  return false;
}

// An equilibrium with a force that pushes one joint, and how it changes with the force.
struct Pushed {
  double force, x, own, own_tangent;  // x of the joint [m or rad]
  spatial::Pose observed;
  double x_by_force;
  Vector6 motion_by_force;  // of the pose that is read

  Pushed(const EquilibriumResiduals& at, const EquilibriumDerivatives& equations,
         const ReadingErrors& errors, const JointPlace& place, double push)
      : force(push), observed(errors.observed(at.state().bodies[0])) {
    const auto [c, k] = place;
    const ChainEquations& chain = at.system().chains()[c];
    x = at.state().coordinates[c][k];
    const OwnForce all(chain.chain(), k, x, chain.rest()[k], chain.commands()[k]);
    own = all.value;
    own_tangent = all.tangent;
    EquationChange change = equations.no_change();
    change.chains[c].force[k] = 1;
    const StateDerivative by_force = equations.solve(change, {c});
    x_by_force = by_force.coordinates[c][k];
    motion_by_force = errors.observed_motion(at.state().bodies[0], by_force.platform);
  }

  // Counted from the equilibrium without the push. The law that pushes is among the joint's own.
  CondensedJoint::Sample from(const Pushed& start) const {
    const Vector6 motion = spatial::pose_difference(start.observed, observed);
    Vector6 by_x = motion_by_force / x_by_force;
    by_x.tail<3>() = (spatial::left_jacobian_inverse(motion.tail<3>()) * by_x.tail<3>()).eval();
    CondensedJoint::Sample sample{x - start.x, {}, {}};
    sample.values << own, motion;
    sample.by_x << own_tangent - 1 / x_by_force, by_x;
    return sample;
  }
};

}  // namespace

// One equilibrium of the model, from which its joints are pushed.
class EffectModel::Condenser {
 public:
  Condenser(const EffectModel& model, const Manipulator& manipulator, const ReadingErrors& errors,
            const Posture& posture, const Load& load, SystemState state)
      : model_(model),
        manipulator_(manipulator),
        errors_(errors),
        posture_(posture),
        load_(load),
        system_(manipulator, posture),
        state_(std::move(state)),
        at_(system_, state_, load_),
        equations_(at_) {}

  const EquilibriumResiduals& equilibrium() const { return at_; }

  std::optional<CondensedState::Joint> joint(const JointPlace& place) const {
    const Pushed here(at_, equations_, errors_, place, 0);
    if (!(here.x_by_force > 0) || !std::isfinite(here.x_by_force)) return std::nullopt;
    const double stiffness = 1 / here.x_by_force;
    const bool resists = stiffness - here.own_tangent >= resisting * stiffness;
    const double unit = turns(place) ? 1 : system_.scale().length;
    for (std::size_t i = resists ? 1 : 0; i < ranges.size(); ++i)
      if (const auto rest = rest_within(ranges[i] * unit, here, stiffness, place))
        return CondensedState::Joint{place, stiffness, *rest};
    return std::nullopt;
  }

 private:
  bool turns(const JointPlace& place) const {
    return is_rotation(coordinate_at(manipulator_, place).motion);
  }

  std::optional<CondensedJoint> rest_within(double range, const Pushed& here, double stiffness,
                                            const JointPlace& place) const {
    const auto below = pushed(place, -range * stiffness);
    if (!below) return std::nullopt;
    const auto above = pushed(place, range * stiffness);
    if (!above) return std::nullopt;
    return CondensedJoint::through(here.from(here), below->from(here), above->from(here),
                                   stiffness);
  }

  // Where there is such an equilibrium, and no law bends on the way.
  std::optional<Pushed> pushed(const JointPlace& place, double force) const {
    ChainModifier modifier(manipulator_.chains()[place.chain]);
    modifier.add_law(
        modifier.chain().coordinates()[static_cast<std::size_t>(place.coordinate)].name,
        std::make_shared<PushLaw>(force));
    const Manipulator manipulator =
        manipulator_.with_chain(place.chain, std::move(modifier).chain());
    const EquilibriumSystem system(manipulator, posture_);
    const FoundState found = state_under_load(system, load_, model_.options_, &state_);
    if (found.status != EquilibriumStatus::converged ||
        bends_elsewhere(system_, place, state_, found.state))
      return std::nullopt;
    const EquilibriumResiduals at(system, found.state, load_);
    return Pushed(at, EquilibriumDerivatives(at), errors_, place, force);
  }

  const EffectModel& model_;
  const Manipulator& manipulator_;
  const ReadingErrors& errors_;
  const Posture& posture_;
  const Load& load_;
  EquilibriumSystem system_;
  SystemState state_;
  EquilibriumResiduals at_;
  EquilibriumDerivatives equations_;
};

std::optional<CondensedState> EffectModel::condensed(const Posture& of_bare, const Load& stated,
                                                     const Conditions& given,
                                                     const std::vector<JointPlace>& joints,
                                                     const SystemState* near,
                                                     const Histories& histories) const {
  if (!watch_.is_empty()) return std::nullopt;
  Conditions conditions = given;
  const Histories before = histories.empty() ? no_history(effects_) : histories;
  const std::optional<Manipulator> varied = this->varied(stated, conditions, before);
  const Manipulator& manipulator = varied ? *varied : fixed_;
  const ReadingErrors errors = reads_ ? reading_errors(effects_, conditions) : ReadingErrors{};
  const Load load = errors.actual(stated);
  const std::optional<Posture> mounted = this->mounted(of_bare);
  const Posture& posture = mounted ? *mounted : of_bare;
  FoundState found =
      state_under_load(EquilibriumSystem(manipulator, posture), load, options_, near);
  if (found.status != EquilibriumStatus::converged) return std::nullopt;
  CondensedState result{.platform = found.state.bodies[0],
                        .observed = errors.observed(found.state.bodies[0]),
                        .coordinates = found.state.coordinates,
                        .commands = {},
                        .joints = {}};
  for (std::size_t c = 0; c < manipulator.size(); ++c)
    result.commands.push_back(posture.commands(manipulator.chains()[c], c));
  const Condenser condenser(*this, manipulator, errors, posture, load, std::move(found.state));
  for (const JointPlace& place : joints) {
    if (has_history_at(place)) continue;
    if (auto joint = condenser.joint(place)) result.joints.push_back(*std::move(joint));
  }
  if (!has_history_) return result;
  result.before = before;
  result.after = advanced(condenser.equilibrium(), stated, conditions, errors, before);
  return result;
}

namespace {

// Where a joint is balanced by the rest of a manipulator: its own force grows with x faster than
// that of the rest, so that there is one such place.
class Balance {
 public:
  Balance(const CondensedState::Joint& joint, const Chain& chain, double start, double rest,
          double command)
      : joint_(joint), chain_(chain), start_(start), rest_(rest), command_(command) {}

  // Newton's method between bounds. False where the joint is hardly held, or leaves what is known.
  bool find() {
    constexpr int most = 60;
    double lower = joint_.rest.lower(), upper = joint_.rest.upper();
    bool is_below_upper = false, is_above_lower = false;
    double x = 0;
    for (int i = 0; i < most; ++i) {
      if (!evaluate(x)) return false;
      const double step = unbalanced_ / stiffness_, next = x + step;
      if (std::abs(step) <= 1e-15 * std::max(1.0, std::abs(start_ + x))) {
        sample_ = joint_.rest.at(x);
        return true;
      }
      (step > 0 ? lower : upper) = x;
      (step > 0 ? is_above_lower : is_below_upper) = true;
      if (next > upper && !is_below_upper) {
        if (!evaluate(upper) || unbalanced_ > 0) return false;
        is_below_upper = true;
      }
      if (next < lower && !is_above_lower) {
        if (!evaluate(lower) || unbalanced_ < 0) return false;
        is_above_lower = true;
      }
      x = next > lower && next < upper ? next : (lower + upper) / 2;
    }
    return false;
  }

  double x() const { return start_ + sample_.x; }
  const CondensedJoint::Sample& sample() const { return sample_; }
  // Derivative of x by a further force on the joint.
  double x_by_force() const { return 1 / stiffness_; }

 private:
  bool evaluate(double x) {
    constexpr double least = 1e-4;  // of what holds the joint without the effect
    const auto [force, slope] = joint_.rest.force_at(x);
    const OwnForce own(chain_, joint_.place.coordinate, start_ + x, rest_, command_);
    unbalanced_ = force - own.value;
    stiffness_ = own.tangent - slope;
    return stiffness_ > least * joint_.stiffness;
  }

  const CondensedState::Joint& joint_;
  const Chain& chain_;
  double start_, rest_, command_;
  double unbalanced_ = 0, stiffness_ = 0;
  CondensedJoint::Sample sample_;
};

// Memory that one thread uses for reading after reading.
struct JointMemory {
  VectorXd rest, x, deflection, travel;
  ChainColumns columns;
  HistoryStep step;

  // The chain as an effect sees it that looks at nothing but its joint, with the memory of its
  // coordinates; back with them.
  ChainState take_state(const Chain& chain, const VectorXd& commands) {
    static const ChainKinematics none;
    deflection = x - rest;
    travel = x - commands;
    return {.chain = chain,
            .x = std::move(x),
            .deflection = std::move(deflection),
            .travel = std::move(travel),
            .kinematics = none,
            .origin = {},
            .gravity = spatial::Vector3::Zero(),
            .loads = {}};
  }
  void give_back(ChainState& state) {
    x = std::move(state.x);
    deflection = std::move(state.deflection);
    travel = std::move(state.travel);
  }
};

// Forces on the joint by one parameter, directly and through the history: all, and those of the
// drive.
struct ForceBy {
  double all = 0, drive = 0;

  // By a value of the effect.
  ForceBy(const ChainColumns& columns, Index joint, Index value)
      : all(columns.force()(joint, value)), drive(columns.drive()(joint, value)) {}
  // By the logarithm of the stiffness of the joint's own spring.
  ForceBy(const ChainState& state, const Spring& spring) {
    const Index k = spring.first;
    const double stiffness = state.chain.stiffness()(k, k);
    all = drive = -spring.share_that_scales() * stiffness * state.deflection[k];
    for (const auto& [coordinate, law] : state.chain.laws()) {
      if (coordinate != k) continue;
      const double by_law =
          spring.share_that_scales() * stiffness *
          law->at({state.x[k], state.deflection[k], stiffness, state.travel[k]}).force_by_stiffness;
      all -= by_law;
      if (!law->is_beside_drive()) drive -= by_law;
    }
  }

  // By what the history has become with it.
  void add_history(const ChainColumns& columns, Index joint,
                   const Eigen::Ref<const VectorXd>& history) {
    const Index first = columns.force().cols() - history.size();
    for (Index h = 0; h < history.size(); ++h) {
      all += columns.force()(joint, first + h) * history[h];
      drive += columns.drive()(joint, first + h) * history[h];
    }
  }
};

// How the pose that is read turns and shifts with x [translation; rotation increment].
Vector6 motion_by_x(const CondensedJoint::Sample& sample) {
  Vector6 motion = sample.by_x.tail<6>();
  motion.tail<3>() = (spatial::left_jacobian(sample.values.tail<3>()) * motion.tail<3>()).eval();
  return motion;
}

}  // namespace

bool EffectModel::is_law_of_joint(const std::vector<ModelParameter>& parameters) const {
  if (effects_.empty() || !watch_.is_empty()) return false;
  const auto last = effects_.size() - 1;
  const Effect& effect = effects_[last];
  if (!effect.kind->acts_on_joint_alone || effect.sites.size() != 1) return false;
  return std::all_of(parameters.begin(), parameters.end(), [&](const ModelParameter& p) {
    return p.springs.empty() ? p.effect == last : own_spring(p) != nullptr;
  });
}

bool EffectModel::has_history_at(const JointPlace& place) const {
  return std::any_of(effects_.begin(), effects_.end(), [&](const Effect& effect) {
    return effect.kind->history > 0 && effect.kind->place == EffectPlace::joint &&
           std::any_of(effect.sites.begin(), effect.sites.end(), [&](const EffectSite& site) {
             return site.chain == place.chain &&
                    fixed_.chains()[place.chain].index_of(site.element) == place.coordinate;
           });
  });
}

// The spring of the joint in which the last effect acts, where the parameter scales that alone.
const Spring* EffectModel::own_spring(const ModelParameter& parameter) const {
  const auto& [c, element] = effects_.back().sites[0];
  if (parameter.springs.size() != 1 || parameter.springs[0].chain != c) return nullptr;
  const Chain& chain = fixed_.chains()[c];
  const Index k = chain.index_of(element);
  for (const Spring& spring : chain.springs())
    if (spring.name == parameter.springs[0].spring)
      return spring.first == k && spring.stiffness.rows() == 1 ? &spring : nullptr;
  return nullptr;
}

bool EffectModel::respond_in_joint(const CondensedState& without, const Conditions& conditions,
                                   const Response& before,
                                   const std::vector<ModelParameter>& parameters,
                                   Response& response) const {
  const std::size_t e = effects_.size() - 1;
  const Effect& effect = effects_[e];
  const auto& [c, element] = effect.sites[0];
  const Chain& chain = varied_chain(c, conditions, without.before, before.histories);
  const Index k = chain.index_of(element);
  const CondensedState::Joint* joint = without.find({c, k});
  if (joint == nullptr) return false;
  const VectorXd& commands = without.commands[c];
  thread_local JointMemory memory;
  chain.find_rest(commands, memory.rest);
  Balance balance(*joint, chain, without.coordinates[c][k], memory.rest[k], commands[k]);
  if (!balance.find()) return false;
  response.observed = spatial::displaced(without.observed, balance.sample().values.tail<6>());
  const Index size = effect.kind->history, count = std::ssize(parameters);
  response.derivatives.resize(6, count);
  if (size == 0 && count == 0) return true;
  memory.x = without.coordinates[c];
  memory.x[k] = balance.x();
  ChainState state = memory.take_state(chain, commands);
  const EffectInput input{effect.values, conditions, before.histories[e]};
  memory.columns.renew(state, effect.values.size() + size);
  if (count > 0) effect.kind->differentiate(memory.columns, element, input);
  if (size > 0) {
    effect.kind->advance(state, element, input, memory.step);
    response.histories[e] = memory.step.next;
  }
  const Vector6 by_x = motion_by_x(balance.sample());
  for (Index p = 0; p < count; ++p) {
    const ModelParameter& parameter = parameters[static_cast<std::size_t>(p)];
    const Spring* spring = own_spring(parameter);
    ForceBy force =
        spring != nullptr ? ForceBy(state, *spring) : ForceBy(memory.columns, k, parameter.value);
    const auto carried = before.history_derivatives[e].col(p);
    force.add_history(memory.columns, k, carried);
    const double moved = force.all * balance.x_by_force();
    response.derivatives.col(p) = moved * by_x;
    if (size == 0) continue;
    auto rate = response.history_derivatives[e].col(p);
    rate = moved * memory.step.by_coordinates.col(k) - force.drive * memory.step.by_drive_force;
    rate.noalias() += memory.step.by_input.rightCols(size) * carried;
    if (spring == nullptr) rate += memory.step.by_input.col(parameter.value);
  }
  memory.give_back(state);
  return true;
}

}  // namespace kinetostat::vjm

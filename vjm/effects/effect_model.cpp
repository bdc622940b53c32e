#include "kinetostat/vjm/effects/effect_model.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/watcher.h"
#include "kinetostat/vjm/statics/equilibrium_residuals.h"
#include "kinetostat/vjm/statics/equilibrium_state.h"

namespace kinetostat::vjm {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// An equilibrium under its conditions.
struct EffectModel::Case {
  const EquilibriumResiduals& equilibrium;
  const Load& stated;
  const Conditions& conditions;
  const ReadingErrors& errors;
  const Watcher& watcher;

  const spatial::Pose& platform() const { return equilibrium.state().bodies[0]; }
};

namespace {

std::uint64_t next_number() {
  static std::atomic<std::uint64_t> last = 0;
  return ++last;
}

VectorXd history_at(const VectorXd& history, std::size_t site, Index size) {
  return history.segment(static_cast<Index>(site) * size, size);
}

bool is_fixed(const Effect& effect) {
  return effect.kind->acts_on_chains() && !effect.kind->varies && effect.kind->history == 0;
}

std::vector<Effect> fixed_ones(const std::vector<Effect>& effects) {
  std::vector<Effect> fixed;
  for (const Effect& effect : effects)
    if (is_fixed(effect)) fixed.push_back(effect);
  return fixed;
}

// Derivatives by values and history of an effect at each of its sites.
std::vector<ChainColumns> columns_of(const Effect& effect, const std::vector<ChainState>& states,
                                     const Conditions& conditions, const VectorXd& history) {
  std::vector<ChainColumns> all;
  for (std::size_t s = 0; s < effect.sites.size(); ++s) {
    const VectorXd before = history_at(history, s, effect.kind->history);
    all.emplace_back(states[effect.sites[s].chain], effect.values.size() + effect.kind->history);
    effect.kind->differentiate(all.back(), effect.sites[s].element,
                               {effect.values, conditions, before});
  }
  return all;
}

}  // namespace

EffectModel::EffectModel(Manipulator bare, std::vector<Effect> effects,
                         const EquilibriumOptions& options)
    : bare_(std::move(bare)),
      mounts_(mounts_of(effects)),
      effects_(on_mounts(mounts_, bare_, std::move(effects))),
      options_(options),
      fixed_(with_effects(mounts_.on(bare_), fixed_ones(effects_))),
      number_(next_number()) {
  std::set<std::size_t> with_history;
  for (std::size_t e = 0; e < effects_.size(); ++e) {
    const EffectKind& kind = *effects_[e].kind;
    varies_ |= kind.varies || kind.history > 0;
    has_history_ |= kind.history > 0;
    asks_for_load_ |= kind.by_stated_load;
    reads_ |= !kind.acts_on_chains() && !kind.acts_on_numbers();
    for (const EffectSite& site : effects_[e].sites)
      if (kind.history > 0) with_history.insert(site.chain);
  }
  for (const std::size_t e : in_order(effects_)) {
    if (!effects_[e].kind->acts_on_chains() || is_fixed(effects_[e])) continue;
    varying_.push_back(e);
    varying_effects_.push_back(effects_[e]);
  }
  chains_asked_.assign(with_history.begin(), with_history.end());
}

// Where chains share something that yields.
std::optional<Posture> EffectModel::mounted(const Posture& posture) const {
  if (!mounts_.any()) return std::nullopt;
  return mounts_.on(posture, fixed_);
}

void EffectModel::watch(Watch watch) {
  watch_ = std::move(watch);
  const std::vector<std::size_t> more = Watcher::chains_of(watch_);
  std::set<std::size_t> all(chains_asked_.begin(), chains_asked_.end());
  all.insert(more.begin(), more.end());
  chains_asked_.assign(all.begin(), all.end());
}

// How the pose that is read changes with the wrench that is stated.
void EffectModel::add_by_wrench(const EquilibriumDerivatives& equations, const Case& at,
                                Response& response) const {
  response.by_wrench.resize(6, 6);
  response.watched.by_wrench.resize(watched_rows(watch_), 6);
  for (Index k = 0; k < 6; ++k) {
    const Load change = at.errors.actual_change(at.stated, spatial::Vector6::Unit(k));
    EquationChange equation = equations.no_change();
    equation.platform_wrench = change.at_reference_point(at.platform());
    const StateDerivative state = equations.solve(equation, Watcher::chains_of(watch_));
    response.by_wrench.col(k) = at.errors.observed_motion(at.platform(), state.platform);
    if (!watch_.is_empty())
      response.watched.by_wrench.col(k) = at.watcher.change(equation, state, nullptr);
  }
}

bool EffectModel::is_relaxed_when_unloaded() const {
  return varying_.empty() && !reads_ && fixed_.is_relaxed_when_unloaded();
}

Response EffectModel::at_rest(std::size_t parameters) const {
  Response rest;
  rest.histories = no_history(effects_);
  for (const VectorXd& history : rest.histories)
    rest.history_derivatives.push_back(
        MatrixXd::Zero(history.size(), static_cast<Index>(parameters)));
  return rest;
}

Response EffectModel::relaxed(const Posture& posture, std::size_t parameters) const {
  Response response = at_rest(parameters);
  const auto columns = static_cast<Index>(parameters);
  response.observed = posture.platform;
  response.derivatives.setZero(6, columns);
  if (!watch_.is_empty())
    response.watched = watched_at_rest(watch_, fixed_, mounted(posture).value_or(posture), columns);
  return response;
}

// Formulas of users may depend on the wrench that is stated.
void EffectModel::add_load(const Load& stated, Conditions& conditions) const {
  static constexpr std::array names = {"fx", "fy", "fz", "mx", "my", "mz"};
  for (std::size_t i = 0; asks_for_load_ && i < 3; ++i) {
    conditions.covariates[names[i]] = stated.force[static_cast<Index>(i)];
    conditions.covariates[names[3 + i]] = stated.moment[static_cast<Index>(i)];
  }
}

// With the effects that vary, where there are some: these also know the load.
std::optional<Manipulator> EffectModel::varied(const Load& stated, Conditions& conditions,
                                               const Histories& before) const {
  if (varying_.empty()) return std::nullopt;
  add_load(stated, conditions);
  return with_effects(fixed_, varying_effects_, conditions, of_varying(before));
}

// One chain of it, good until the thread asks for another. Readings follow each other in one model,
// and mostly what was put on for the last can be taken off again. Histories of all but the last
// effect are `of_others`, where there are any.
const Chain& EffectModel::varied_chain(std::size_t chain, const Conditions& conditions,
                                       const Histories& of_others, const Histories& all) const {
  struct Made {
    std::uint64_t model = 0;  // 0: none
    std::size_t chain = 0;
    std::optional<ChainModifier> modifier = {};
  };
  thread_local Made made;
  const Chain& original = fixed_.chains()[chain];
  if (!act_on(chain, varying_effects_)) return original;
  if (std::exchange(made.model, 0) == number_ && made.chain == chain)
    made.modifier->take_back(original);
  else
    made.modifier.emplace(original);
  for (const std::size_t e : varying_) {
    const bool is_other = !of_others.empty() && e + 1 < effects_.size();
    put_on(chain, effects_[e], conditions, is_other ? of_others[e] : all[e], *made.modifier);
  }
  made.model = number_;
  made.chain = chain;
  return made.modifier->chain();
}

Histories EffectModel::of_varying(const Histories& all) const {
  Histories histories;
  for (const std::size_t e : varying_) histories.push_back(all[e]);
  return histories;
}

Response EffectModel::respond(const Posture& of_bare, const Load& stated, const Conditions& given,
                              const Response& before, const std::vector<ModelParameter>& parameters,
                              bool with_derivatives, const SystemState* near,
                              bool with_compliance) const {
  std::optional<Manipulator> varied;
  Conditions conditions = given;
  Response response;
  response.histories = before.histories;
  response.history_derivatives = before.history_derivatives;
  try {
    varied = this->varied(stated, conditions, before.histories);
  } catch (const std::invalid_argument& error) {
    response.failure = error.what();
    return response;
  }
  const Manipulator& manipulator = varied ? *varied : fixed_;
  const ReadingErrors errors = reads_ ? reading_errors(effects_, conditions) : ReadingErrors{};
  const Load load = errors.actual(stated);
  const std::optional<Posture> mounted = this->mounted(of_bare);
  const EquilibriumSystem system(manipulator, mounted ? *mounted : of_bare);
  NewtonEquations left;
  FoundState found = state_under_load(system, load, options_, near, &left);
  if (found.status != EquilibriumStatus::converged) {
    response.failure = std::move(found.reason);
    return response;
  }
  response.state = std::move(found.state);
  response.observed = errors.observed(response.state.bodies[0]);
  if (with_derivatives) response.derivatives.resize(6, static_cast<Index>(parameters.size()));
  const bool differentiates = with_derivatives && !parameters.empty();
  if (!differentiates && !with_compliance && !has_history_ && watch_.is_empty()) return response;
  if (left.residuals) {
    left.residuals->move_to(response.state);
  } else {
    left.residuals.emplace(system, response.state, load);
  }
  const EquilibriumResiduals& equilibrium = *left.residuals;
  const Watcher watcher(watch_, equilibrium, errors);
  response.watched = watcher.values();
  const Case at{equilibrium, stated, conditions, errors, watcher};
  if (has_history_ && !differentiates) advance(at, before, response);
  if (!differentiates && !with_compliance) return response;
  const EquilibriumDerivatives equations =
      left.matrix ? EquilibriumDerivatives(equilibrium, *std::move(left.matrix))
                  : EquilibriumDerivatives(equilibrium);
  if (with_compliance) add_by_wrench(equations, at, response);
  if (differentiates) differentiate(equations, at, before, parameters, response);
  return response;
}

// The last effect, whatever its values.
bool EffectModel::leaves_equilibrium(const Conditions& conditions,
                                     const std::vector<ModelParameter>& parameters) const {
  if (effects_.empty() || !watch_.is_empty()) return false;
  const auto last = effects_.size() - 1;
  const EffectKind& kind = *effects_[last].kind;
  if (kind.history > 0) return false;
  return (kind.acts_on_readings_alone() || !acts_under(kind, conditions)) &&
         std::all_of(parameters.begin(), parameters.end(), [&](const ModelParameter& p) {
           return p.springs.empty() && p.effect == last;
         });
}

// A response to be found: histories of the model without its last effect, and that of the last as
// it was.
void EffectModel::start_response(const CondensedState& without, const Response& before,
                                 Response& response) const {
  response.failure.clear();
  response.by_wrench.resize(6, 0);
  response.watched = {};
  response.state = {};
  response.histories = before.histories;
  std::copy(without.after.begin(), without.after.end(), response.histories.begin());
  response.history_derivatives = before.history_derivatives;
}

bool EffectModel::respond(const CondensedState& without, const Load& stated,
                          const Conditions& given, const Response& before,
                          const std::vector<ModelParameter>& parameters, Response& response) const {
  const bool is_law = !leaves_equilibrium(given, parameters);
  if (is_law && !is_law_of_joint(parameters)) return false;
  start_response(without, before, response);
  std::optional<Conditions> with_load;
  if (asks_for_load_ && !varying_.empty()) add_load(stated, with_load.emplace(given));
  const Conditions& conditions = with_load ? *with_load : given;
  if (is_law) return respond_in_joint(without, conditions, before, parameters, response);
  read_otherwise(without, conditions, parameters, response);
  return true;
}

// Where the last effect has nothing to do with the equilibrium.
void EffectModel::read_otherwise(const CondensedState& without, const Conditions& conditions,
                                 const std::vector<ModelParameter>& parameters,
                                 Response& response) const {
  const ReadingErrors errors = reading_errors(effects_, conditions);
  response.observed = errors.observed(without.platform);
  response.derivatives.resize(6, std::ssize(parameters));
  for (std::size_t p = 0; p < parameters.size(); ++p)
    response.derivatives.col(static_cast<Index>(p)) =
        errors.observed_derivative(without.platform, tangent_of(parameters[p], conditions));
}

void EffectModel::advance(const Case& at, const Response& before, Response& response) const {
  for (std::size_t e = 0; e < effects_.size(); ++e) {
    const Effect& effect = effects_[e];
    const Index size = effect.kind->history;
    for (std::size_t s = 0; size > 0 && s < effect.sites.size(); ++s) {
      const VectorXd history = history_at(before.histories[e], s, size);
      HistoryStep step;
      effect.kind->advance(chain_state(at.equilibrium, effect.sites[s].chain),
                           effect.sites[s].element, {effect.values, at.conditions, history}, step);
      response.histories[e].segment(static_cast<Index>(s) * size, size) = step.next;
    }
  }
}

Histories EffectModel::advanced(const EquilibriumResiduals& equilibrium, const Load& stated,
                                const Conditions& conditions, const ReadingErrors& errors,
                                const Histories& before) const {
  const Watcher watcher(watch_, equilibrium, errors);
  Response from, to;
  from.histories = to.histories = before;
  advance({equilibrium, stated, conditions, errors, watcher}, from, to);
  return to.histories;
}

// What all parameters of one case share.
struct EffectModel::Linear {
  const EquilibriumDerivatives& equations;
  std::vector<ChainState> states;                  // of chains
  std::vector<std::vector<ChainColumns>> columns;  // of effects at their sites, where needed

  Linear(const EquilibriumDerivatives& derivatives, const Case& at,
         const std::vector<Effect>& effects, const Response& before,
         const std::vector<ModelParameter>& parameters)
      : equations(derivatives), columns(effects.size()) {
    if (effects.empty()) return;
    for (std::size_t c = 0; c < at.equilibrium.chains().size(); ++c)
      states.push_back(chain_state(at.equilibrium, c));
    std::vector<bool> needed(effects.size());
    for (const ModelParameter& parameter : parameters)
      if (parameter.springs.empty()) needed[parameter.effect] = true;
    for (std::size_t e = 0; e < effects.size(); ++e)
      if (needed[e] || effects[e].kind->history > 0)
        columns[e] = columns_of(effects[e], states, at.conditions, before.histories[e]);
  }
};

// The change of the equations with one parameter: directly, and through what histories carry.
void EffectModel::find_change(const Linear& linear, const Case& at, const Response& before,
                              const ModelParameter& parameter, Index column,
                              EquationChange& change) const {
  linear.equations.make_none(change);
  for (const SpringParameter& spring : parameter.springs)
    linear.equations.add_log_stiffness(spring, change);
  if (parameter.springs.empty()) {
    const Effect& effect = effects_[parameter.effect];
    for (std::size_t s = 0; s < effect.sites.size(); ++s)
      change.add(effect.sites[s].chain, linear.columns[parameter.effect][s], parameter.value);
    if (!effect.kind->acts_on_chains())
      change.platform_wrench = at.errors.wrench_derivative(at.stated, at.platform(),
                                                           tangent_of(parameter, at.conditions));
  }
  for (std::size_t e = 0; e < effects_.size(); ++e) {
    const Index size = effects_[e].kind->history, values = effects_[e].values.size();
    for (std::size_t s = 0; size > 0 && s < effects_[e].sites.size(); ++s)
      for (Index h = 0; h < size; ++h)
        change.add(effects_[e].sites[s].chain, linear.columns[e][s], values + h,
                   before.history_derivatives[e](static_cast<Index>(s) * size + h, column));
  }
}

ReadingErrors EffectModel::tangent_of(const ModelParameter& parameter,
                                      const Conditions& conditions) const {
  const Effect& effect = effects_[parameter.effect];
  const VectorXd no_history;
  if (!acts_under(*effect.kind, conditions)) return ReadingErrors::tangent();
  return effect.kind->tangent(parameter.value, {effect.values, conditions, no_history});
}

void EffectModel::differentiate(const EquilibriumDerivatives& equations, const Case& at,
                                const Response& before,
                                const std::vector<ModelParameter>& parameters,
                                Response& response) const {
  const Linear linear(equations, at, effects_, before, parameters);
  // One after the other, or all of them for histories.
  std::vector<EquationChange> changes(has_history_ ? parameters.size() : 1);
  std::vector<StateDerivative> solutions(changes.size());
  response.watched.derivatives.resize(watched_rows(watch_), std::ssize(parameters));
  if (chains_asked_.empty()) equations.expect(parameters.size());
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const auto column = static_cast<Index>(p);
    EquationChange& change = changes[has_history_ ? p : 0];
    StateDerivative& solution = solutions[has_history_ ? p : 0];
    find_change(linear, at, before, parameters[p], column, change);
    linear.equations.solve(change, chains_asked_, solution);
    response.derivatives.col(column) = at.errors.observed_motion(at.platform(), solution.platform);
    std::optional<ReadingErrors> errors;
    if (parameters[p].springs.empty() && !effects_[parameters[p].effect].kind->acts_on_chains()) {
      errors = tangent_of(parameters[p], at.conditions);
      response.derivatives.col(column) += at.errors.observed_derivative(at.platform(), *errors);
    }
    if (!watch_.is_empty())
      response.watched.derivatives.col(column) =
          at.watcher.change(change, solution, errors ? &*errors : nullptr);
  }
  for (std::size_t e = 0; e < effects_.size(); ++e)
    for (std::size_t s = 0; effects_[e].kind->history > 0 && s < effects_[e].sites.size(); ++s)
      advance(linear, at, before, parameters, changes, solutions, e, s, response);
}

// Carries the history of one effect at one site, with its derivatives.
void EffectModel::advance(const Linear& linear, const Case& at, const Response& before,
                          const std::vector<ModelParameter>& parameters,
                          const std::vector<EquationChange>& changes,
                          const std::vector<StateDerivative>& solutions, std::size_t e,
                          std::size_t s, Response& response) const {
  const Effect& effect = effects_[e];
  const auto& [chain, element] = effect.sites[s];
  const Index size = effect.kind->history, first = static_cast<Index>(s) * size;
  const VectorXd history = before.histories[e].segment(first, size);
  const ChainState& state = linear.states[chain];
  HistoryStep step;
  effect.kind->advance(state, element, {effect.values, at.conditions, history}, step);
  response.histories[e].segment(first, size) = step.next;
  const bool has_drive = !step.by_drive_force.isZero(0);
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const auto column = static_cast<Index>(p);
    VectorXd rate =
        step.by_coordinates * solutions[p].coordinates[chain] +
        step.by_input.rightCols(size) * before.history_derivatives[e].block(first, column, size, 1);
    if (parameters[p].springs.empty() && parameters[p].effect == e)
      rate += step.by_input.col(parameters[p].value);
    if (has_drive)
      rate -= step.by_drive_force * changes[p].chains[chain].drive[state.chain.index_of(element)];
    response.history_derivatives[e].block(first, column, size, 1) = rate;
  }
}

}  // namespace kinetostat::vjm

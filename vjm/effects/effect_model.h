// A manipulator with its effects, as readings are taken of it: one equilibrium after the other,
// with everything that effects carry along.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/vjm/effects/condensed_state.h"
#include "kinetostat/vjm/effects/effect.h"
#include "kinetostat/vjm/effects/sensitivity.h"
#include "kinetostat/vjm/effects/watch.h"

namespace kinetostat::vjm {

/// Variable of the derivatives of a response: the logarithm of the stiffness of springs that scale
/// together, or one value of an effect (in SI).
struct ModelParameter {
  std::vector<SpringParameter> springs;
  std::size_t effect = 0;  // when there are no springs
  Eigen::Index value = 0;
};

/// One equilibrium of a sequence.
struct Response {
  std::string failure;     // empty when there is an equilibrium
  spatial::Pose observed;  // pose that is read, base axes
  /// Its derivatives [translation; rotation increment], one column a parameter.
  Matrix6X derivatives;
  /// Its change [translation; rotation increment] with the stated wrench [force; moment], base
  /// axes, at this equilibrium alone; empty when not asked for.
  Matrix6X by_wrench;
  Watched watched;                                   // what the model watches beside the platform
  Histories histories;                               // after it
  std::vector<Eigen::MatrixXd> history_derivatives;  // one column a parameter
  SystemState state;
};

class EffectModel {
 public:
  /// `bare`: without the effects. Throws what with_effects() throws.
  EffectModel(Manipulator bare, std::vector<Effect> effects,
              const EquilibriumOptions& options = {});

  /// The bare manipulator of a model that watches is that of with_watched().
  void watch(Watch watch);
  const Manipulator& bare() const { return bare_; }
  /// With sites on its own chains (on_mounts).
  const std::vector<Effect>& effects() const { return effects_; }
  /// Some effect depends on the conditions of a reading, or on the readings before it.
  bool varies() const { return varies_; }
  bool has_history() const { return has_history_; }
  /// Without load the platform stands where the posture has it.
  bool is_relaxed_when_unloaded() const;

  /// The start of a sequence.
  Response at_rest(std::size_t parameters) const;
  /// The state without load where that is relaxed (is_relaxed_when_unloaded).
  Response relaxed(const Posture& posture, std::size_t parameters) const;
  /// The equilibrium under a stated load, after `before`. `posture` is one of the bare manipulator;
  /// `near` (or nullptr) a state close to the solution, which saves time.
  Response respond(const Posture& posture, const Load& load, const Conditions& conditions,
                   const Response& before, const std::vector<ModelParameter>& parameters,
                   bool with_derivatives, const SystemState* near = nullptr,
                   bool with_compliance = false) const;

  /// The equilibrium under a stated load with the joints condensed that can be: not those in which
  /// an effect with a history acts. `histories`: before it; empty: nothing has happened. nullopt:
  /// no equilibrium, or a model that watches.
  std::optional<CondensedState> condensed(const Posture& posture, const Load& load,
                                          const Conditions& conditions,
                                          const std::vector<JointPlace>& joints,
                                          const SystemState* near = nullptr,
                                          const Histories& histories = {}) const;
  /// respond() from the same equilibrium of the model without its last effect, in much less time:
  /// equal to 1e-12 of the manipulator's length, where the histories of the other effects are those
  /// of `without`, as if the last effect had not acted before. Without `state`, which is not found.
  /// Into a response that is kept, another than `before`: from the second one on hardly anything is
  /// allocated. False unless the effect acts on what is read alone, not at all, or on one joint
  /// alone (EffectKind::acts_on_joint_alone), which is condensed, stays held and where that is
  /// known; derivatives are by values of this effect and by the stiffness of its joint alone.
  bool respond(const CondensedState& without, const Load& load, const Conditions& conditions,
               const Response& before, const std::vector<ModelParameter>& parameters,
               Response& response) const;

 private:
  class Condenser;
  struct Case;
  struct Linear;
  std::optional<Manipulator> varied(const Load& stated, Conditions& conditions,
                                    const Histories& histories) const;
  void add_load(const Load& stated, Conditions& conditions) const;
  const Chain& varied_chain(std::size_t chain, const Conditions& conditions,
                            const Histories& of_others, const Histories& all) const;
  Histories of_varying(const Histories& histories) const;
  bool leaves_equilibrium(const Conditions& conditions,
                          const std::vector<ModelParameter>& parameters) const;
  void read_otherwise(const CondensedState& without, const Conditions& conditions,
                      const std::vector<ModelParameter>& parameters, Response& response) const;
  bool respond_in_joint(const CondensedState& without, const Conditions& conditions,
                        const Response& before, const std::vector<ModelParameter>& parameters,
                        Response& response) const;
  bool is_law_of_joint(const std::vector<ModelParameter>& parameters) const;
  const Spring* own_spring(const ModelParameter& parameter) const;
  bool has_history_at(const JointPlace& place) const;
  Histories advanced(const EquilibriumResiduals& equilibrium, const Load& stated,
                     const Conditions& conditions, const ReadingErrors& errors,
                     const Histories& before) const;
  void start_response(const CondensedState& without, const Response& before,
                      Response& response) const;
  void find_change(const Linear& linear, const Case& at, const Response& before,
                   const ModelParameter& parameter, Eigen::Index column,
                   EquationChange& change) const;
  ReadingErrors tangent_of(const ModelParameter& parameter, const Conditions& conditions) const;
  void add_by_wrench(const EquilibriumDerivatives& equations, const Case& at,
                     Response& response) const;
  void advance(const Linear& linear, const Case& at, const Response& before,
               const std::vector<ModelParameter>& parameters,
               const std::vector<EquationChange>& changes,
               const std::vector<StateDerivative>& solutions, std::size_t effect, std::size_t site,
               Response& response) const;
  void differentiate(const EquilibriumDerivatives& equations, const Case& at,
                     const Response& before, const std::vector<ModelParameter>& parameters,
                     Response& response) const;
  void advance(const Case& at, const Response& before, Response& response) const;

  std::optional<Posture> mounted(const Posture& posture) const;

  Manipulator bare_;
  SharedMounts mounts_;
  std::vector<Effect> effects_;  // on the chains of `fixed_`
  EquilibriumOptions options_;
  Manipulator fixed_;                 // with the effects that are the same for all readings
  std::uint64_t number_;              // another for each model; copies are the same
  std::vector<std::size_t> varying_;  // in the order in which they are applied
  std::vector<Effect> varying_effects_;
  Watch watch_;
  std::vector<std::size_t> chains_asked_;  // whose coordinates histories or the watch depend on
  bool varies_ = false, has_history_ = false, reads_ = false, asks_for_load_ = false;
};

}  // namespace kinetostat::vjm

// Predictions of a model for each reading of a campaign.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/regression/parameter.h"
#include "kinetostat/calibration/regression/predictions.h"
#include "kinetostat/calibration/regression/reading_offsets.h"
#include "kinetostat/common/faults.h"
#include "kinetostat/common/progress.h"
#include "kinetostat/vjm/effects/effect_model.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::calibration {

struct SensorReading;

/// All states of a model with some of its joints condensed: what models share that have one more
/// law in one joint.
struct CondensedModel {
  std::vector<std::optional<vjm::CondensedState>> states;  // nullopt: not condensed
  /// Of each reading in the order of the campaign, under its load and without: which it is.
  std::vector<std::size_t> loaded, unloaded;

  /// Nearly all states have the joint condensed.
  bool knows(const vjm::JointPlace& joint) const;
};

/// Where that sits which a sensor looks at, seen from where the campaign has it: position [m] in
/// axes of the platform, or of what carries the sensor, and rotation vector [rad].
struct TargetOffset {
  std::size_t sensor = 0;
  spatial::Vector6 pose = spatial::Vector6::Zero();
  /// Derivatives by so many of its coordinates follow those by the parameters, target after target:
  /// 0, 3 or 6.
  Eigen::Index differentiated = 0;
};

/// Takes what is predicted of one reading, from any thread: displacement and work may be changed
/// where they stand, derivatives (no columns: none) are not kept. Of readings that fail nothing is
/// taken.
using ReadingTaker =
    std::function<void(std::size_t reading, Eigen::VectorXd& displacement, spatial::Vector6& work,
                       const Eigen::MatrixXd& derivatives)>;

struct PredictOptions {
  const Predictions* near = nullptr;  // of a similar model, which save time
  std::vector<TargetOffset> targets = {};
  /// The model without its last effect, which saves most of the time where that is a law in one
  /// joint; states and work are then left out.
  const CondensedModel* without = nullptr;
  ReadingTaker take = {};
  /// States of one reading a configuration: those of a long table are most of its memory.
  bool few_states = false;
};

/// The full nonlinear model: unloaded posture by kinematics, then loaded equilibrium, one after the
/// other where an effect carries a history along a cycle. Postures are found once per distinct
/// configuration, equilibria once per distinct load in it under the same conditions.
///
/// A cycle with history starts from the relaxed manipulator, which then takes its state without
/// load; readings follow in the order of step and time, masked ones included. Another configuration
/// starts anew, and so does a reading that belongs to no cycle, unless the campaign says that the
/// history continues: then the readings of a session follow each other. Where a displacement is
/// set, the force is sought that it takes; derivatives are those at this displacement,
///
///   dF/dp = -(du/dp) / (du/dF),   dv/dp = (dv/dp at F) + dv/dF dF/dp,
///
/// with u what is set and v all else that is read. In differences the state
/// without load is that at the session's first reading, at the temperature of the reading itself.
class Predictor {
 public:
  /// `bare`: the manipulator without its effects. Finds the unloaded postures. Throws
  /// common::InputError naming the lines of readings in use whose pose is out of reach, or in which
  /// a level reads a turn about an axis of it that is vertical.
  /// Keeps a reference to the campaign.
  Predictor(const vjm::Manipulator& bare, std::vector<vjm::Effect> effects,
            const Campaign& campaign, int threads, common::Progress& progress);
  /// Without effects.
  Predictor(const vjm::Manipulator& manipulator, const Campaign& campaign, int threads,
            common::Progress& progress);

  const std::vector<vjm::Effect>& effects() const { return effects_; }
  /// Posture of a reading, without load.
  const vjm::Posture& posture_of(std::size_t reading) const {
    return (*postures_)[campaign_.readings[reading].configuration].posture;
  }
  /// In the posture without load.
  PlatformAxes platform_axes() const;
  /// The same campaign and manipulator with other effects: postures are not sought again.
  Predictor with_effects(std::vector<vjm::Effect> effects) const;
  /// The same on so many threads.
  Predictor with_effects(std::vector<vjm::Effect> effects, int threads) const;

  /// For the model with its parameters at `values`.
  Predictions predict(const std::vector<Parameter>& parameters, const Eigen::VectorXd& values,
                      bool with_derivatives, common::Progress& progress) const;
  /// The same with derivatives with respect to some of the parameters only.
  Predictions predict(const std::vector<Parameter>& parameters, const Eigen::VectorXd& values,
                      const std::vector<Parameter>& derivatives_by, common::Progress& progress,
                      const PredictOptions& options = {}) const;
  /// The same without derivatives, but with `by_wrench`.
  Predictions predict_with_compliance(const std::vector<Parameter>& parameters,
                                      const Eigen::VectorXd& values, common::Progress& progress,
                                      const std::vector<TargetOffset>& targets = {}) const;
  /// The model with joints condensed, as far as they can be. `near`: its own predictions. Histories
  /// are those of this model, whatever is added to it.
  CondensedModel condensed(const std::vector<Parameter>& parameters, const Eigen::VectorXd& values,
                           const std::vector<vjm::JointPlace>& joints, const Predictions& near,
                           common::Progress& progress) const;

 private:
  // A state without load, which several cases may share.
  struct Reference {
    std::size_t configuration = 0, conditions = 0;
    std::size_t reading = 0;  // the first of those that share it
  };
  // Load case that several readings may share.
  struct LoadCase {
    std::size_t conditions = 0;
    std::size_t reference = 0;
    bool may_fail = true;     // only masked readings need it
    std::size_t end = 0;      // of its readings in readings_of_cases_
    std::size_t reading = 0;  // the first of those that share it, with its load
  };
  struct State;
  struct CaseResult;
  struct Scratch;
  class Failures;
  struct Run;

  Predictor(const Predictor& like, std::vector<vjm::Effect> effects, int threads);
  void set_effects(std::vector<vjm::Effect> effects);
  void find_postures(common::Progress& progress);
  void refuse_blind_levels(common::Faults& faults) const;
  void find_cases();
  void find_sequences(const std::vector<std::size_t>& case_of_reading);
  void group_readings(const std::vector<std::size_t>& case_of_reading);
  std::span<const std::size_t> readings_of(std::size_t c) const;
  std::size_t conditions_index(const vjm::Conditions& conditions);
  std::size_t reference_index(std::size_t configuration, const vjm::Conditions& conditions,
                              std::size_t reading);
  Predictions predict(const Run& run, common::Progress& progress) const;
  std::size_t states_kept(const Run& run) const;
  Predictions predict_then_take(Run run, common::Progress& progress) const;
  void solve(const Run& run, std::size_t configuration, const vjm::Load& load,
             std::size_t conditions, const vjm::Response& before, const vjm::SystemState* near,
             const vjm::CondensedState* without, State& state) const;
  std::vector<State> references(const Run& run, common::Progress& progress) const;
  void follow(const Run& run, std::span<const std::size_t> sequence,
              const std::vector<State>& unloaded, Predictions& predictions,
              Failures& failures) const;
  void under_load(const Run& run, const LoadCase& at, const State& unloaded,
                  const vjm::Response& before, State& state) const;
  void at_displacement(const Run& run, const LoadCase& at, const State& unloaded,
                       const vjm::Response& before, State& state) const;
  SensorReading reading_of_set(const CaseResult& result, const LoadCase& at) const;
  void hold_displacement(const Run& run, const LoadCase& at, const vjm::Response& before,
                         State& loaded, CaseResult& result) const;
  void carry_into_history(const Run& run, const LoadCase& at, const vjm::Response& before,
                          const Eigen::RowVectorXd& force, State& loaded) const;
  void condense_sequence(std::span<const std::size_t> sequence,
                         const std::function<void(std::size_t, const vjm::Histories&)>& loaded,
                         CondensedModel& model) const;
  void add_unloaded(const Run& run, const std::vector<State>& unloaded,
                    Predictions& predictions) const;
  // Where the state of a reading is kept; nothing: nowhere.
  std::optional<std::size_t> place_of_state(const Run& run, std::size_t reading) const;
  void observe(const Run& run, State& state) const;
  void find_displacements(const State& unloaded, const State& loaded, CaseResult& result) const;
  spatial::Vector6 work_of(const Run& run, const Reading& reading, const State& loaded) const;
  spatial::Vector6 measured_by(std::size_t sensor, const Reading& reading) const;
  // What the scratch has of a case.
  void enter(const Run& run, std::size_t index, Scratch& scratch, Predictions& predictions) const;
  vjm::EffectModel model(const std::vector<Parameter>& parameters,
                         const Eigen::VectorXd& values) const;

  vjm::Manipulator bare_;
  std::vector<vjm::Effect> effects_;
  const Campaign& campaign_;
  int threads_;
  bool varies_ = false, has_history_ = false, on_numbers_ = false;
  std::shared_ptr<const std::vector<vjm::PostureResult>> postures_;  // one a configuration
  std::vector<vjm::Conditions> conditions_;  // the distinct ones; the neutral one first
  std::vector<Reference> references_;
  std::map<vjm::Conditions, std::size_t> known_conditions_;
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> known_references_;
  std::vector<LoadCase> cases_;
  std::vector<std::vector<std::size_t>> sequences_;  // of cases; only where there is a history
  std::vector<std::size_t> readings_of_cases_;       // case after case
  std::vector<std::size_t> first_readings_;          // of configurations
};

/// The rotation vector that stands for the same rotation as `vector` and is nearest to `measured`
/// in those components that are not NaN.
spatial::Vector3 nearest_rotation_vector(const spatial::Vector3& vector,
                                         const spatial::Vector3& measured);

}  // namespace kinetostat::calibration

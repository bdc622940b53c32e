// A diagnosis as its file says it, by names: the robot may have changed since.
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/diagnosis/verdict.h"
#include "kinetostat/calibration/regression/correlation.h"

namespace kinetostat::calibration {

/// A number that a file need not have.
inline constexpr double not_recorded = std::numeric_limits<double>::quiet_NaN();

struct RecordedParameter {
  std::string name, unit;
  double prior_mean = 0, prior_sd = 0;
};

struct RecordedEffect {
  std::string effect, at;
  std::vector<RecordedParameter> parameters;
  std::vector<double> values, deviations;  // of the parameters, where it was fitted [SI], or NaN

  std::string name() const { return effect + " at " + at; }
};

/// One of the answers that a finding may be, by the names of its laws.
struct RecordedAnswer {
  std::vector<std::string> laws;  // "clearance at x.rho"
  double probability = 0;
};

/// An effect that was found.
struct RecordedFinding {
  RecordedEffect effect;
  double probability = 0, false_alarm_chance = 1;
  std::vector<std::string> instead = {};     // what it may be instead
  std::vector<RecordedAnswer> answers = {};  // its own among them, where known
  double nothing = 0;                        // probability that nothing is missing, where known
};

/// One row of a ranking.
struct RecordedCandidate {
  RecordedEffect effect;
  double detectability = 0, most_detectability = 0;  // as RankedCandidate has them
  std::string unobservable;                          // why; empty when it is observable
  bool is_fitted = false;
  double probability = 0, log_evidence = 0;  // where it is
};

struct RecordedStep {
  std::vector<std::string> beside;  // names of effects
  std::vector<RecordedCandidate> ranking;
};

/// What the robot file declares uncertain, fitted: a stiffness, or a value of an effect.
struct RecordedEstimate {
  std::string stiffness;             // as under `uncertain:`
  std::string effect, at, value_of;  // instead of it
  std::string unit;
  double designed = not_recorded, fitted = not_recorded, standard_error = not_recorded;
  double factor = not_recorded, standard_error_of_log_factor = not_recorded;
  bool is_kept = false, is_at_bound = false;
};

struct RecordedStage {
  std::string name;
  double error = 0;              // in units of the noise
  double before = not_recorded;  // of the nominal model on the same readings
};

struct DiagnosisRecord {
  std::filesystem::path file;  // for messages
  std::string campaign;
  std::string readings_sha256, robot_sha256;  // empty: not recorded
  Verdict verdict = Verdict::inconclusive;
  std::vector<RecordedFinding> found;
  std::vector<std::string> ambiguous;
  std::optional<RecordedFinding> doubted;          // see Diagnosis::doubted
  std::optional<RecordedEffect> instead_of_refit;  // see Diagnosis::common_cause
  bool or_something_else = false;
  std::vector<RecordedStage> waterfall;
  std::vector<RecordedEstimate> fitted_without, fitted_beside;
  EstimateCorrelation correlation_without, correlation_beside;  // empty where not recorded
  std::size_t set_aside = 0;                                    // readings
  std::vector<RecordedStep> steps;

  /// The stage of the waterfall of that name; without errors where there is none.
  RecordedStage stage_of(const std::string& name) const {
    for (const RecordedStage& stage : waterfall)
      if (stage.name == name) return stage;
    return {.name = name, .error = not_recorded};
  }
};

}  // namespace kinetostat::calibration
